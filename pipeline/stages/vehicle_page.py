"""Every record of a vehicle -> its page, and a receipt with its line for the index."""

import os
from pathlib import Path
from typing import Any

from pipeline.plan import RECORD_STAGES
from pipeline.provenance import Envelope, file_digest
from pipeline.records.allocation import AllocationMap
from pipeline.records.base import Record
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.report.site import index_entry
from pipeline.report.vehicle_page import VehicleResults, write_vehicle_page
from pipeline.stages.job import Job, write_record
from pipeline.stages.receipt import FirmwareFiles, PageFile
from pipeline.vehicle.load import vehicle_notes

MODELS: dict[str, type[Record]] = {
    "load_test": LoadTestRecord,
    "mooring": MooringRecord,
    "open_water": OpenWaterRecord,
    "propeller": PropellerFit,
    "drive": DriveFit,
    "static": StaticCharacteristic,
    "inverse": InverseCharacteristic,
    "allocation": AllocationMap,
}


def run(job: Job) -> str:
    """Write the page."""
    page = job.more_outputs[0]

    def compute() -> PageFile:
        envelopes = {stage: job.envelope(stage, MODELS[stage]) for stage in RECORD_STAGES}
        results = _results(job, page, envelopes)
        write_vehicle_page(results, page)
        entry = index_entry(results, page.relative_to("reports").as_posix())
        return PageFile(
            files={page.as_posix(): file_digest(page)},
            title=entry.title,
            name=entry.name,
            href=entry.href,
            data_note=entry.data_note,
            errors=entry.status.errors,
            warnings=entry.status.warnings,
            failed_checks=entry.status.failed_checks,
            not_computed=entry.status.not_computed,
        )

    return write_record(job, compute)


def _results(job: Job, page: Path, envelopes: dict[str, Envelope[Any]]) -> VehicleResults:
    vehicle = job.vehicle()
    notes = vehicle_notes(vehicle)
    if vehicle.name != job.vehicle_name:
        difference = (
            f"vehicle.yaml names the vehicle {vehicle.name}, its folder {job.vehicle_name}; "
            "results and firmware are named after the folder."
        )
        notes = (*notes, difference)
    firmware = job.envelope("firmware", FirmwareFiles)
    everything: dict[str, Envelope[Any]] = {**envelopes, "firmware": firmware}
    records = {stage: envelope.record for stage, envelope in envelopes.items()}
    files = firmware.record.files if firmware.record else {}
    return VehicleResults(
        vehicle=vehicle,
        notes=notes,
        missing={s: e.why_not for s, e in everything.items() if e.why_not is not None},
        provenance=_provenance(everything),
        firmware_files=tuple(
            Path(os.path.relpath(file, page.parent)).as_posix() for file in sorted(files)
        ),
        **records,
    )


def _provenance(envelopes: dict[str, Envelope[Any]]) -> dict[str, str]:
    """List the digest of every raw file, and of the code of every stage."""
    first = next(iter(envelopes.values()))
    raw = {
        name: f"sha256 {digest}"
        for envelope in envelopes.values()
        for name, digest in envelope.inputs.items()
        if name.startswith("raw/")
    }
    code = {f"code of {stage}": envelope.code for stage, envelope in envelopes.items()}
    return {"rig2sea": first.version, **dict(sorted(raw.items())), **code}
