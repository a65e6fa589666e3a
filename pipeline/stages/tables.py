"""Fits -> tables.json, the file that others read."""

from pipeline.provenance import tables_text, write_atomically
from pipeline.records.fits import InverseCharacteristic, PropellerFit, StaticCharacteristic
from pipeline.stages.job import Job
from pipeline.tables.build import build_tables


def run(job: Job) -> str:
    """Write the tables with what they were made from."""
    digests = job.input_digests()
    propeller = job.envelope("propeller", PropellerFit)
    static = job.envelope("static", StaticCharacteristic)
    inverse = job.envelope("inverse", InverseCharacteristic)
    reasons = {
        one.kind: one.why_not for one in (propeller, static, inverse) if one.why_not is not None
    }
    body = build_tables(job.vehicle(), propeller.record, static.record, inverse.record, reasons)
    write_atomically(job.output, tables_text(body, inputs=digests, code=job.code))
    return ""
