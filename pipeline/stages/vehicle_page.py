"""Every record of a vehicle -> its page, and a receipt with its line for the index."""

import os
from pathlib import Path
from typing import Any

from pipeline.ignored_files import ignored_file_problems
from pipeline.inputs.vehicle_changes import changes_of
from pipeline.plan import POOL, RAW_KINDS, RECORD_STAGES, typed_name
from pipeline.provenance import Envelope, file_digest
from pipeline.records.base import PageFile, Record
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.records.trial import PageReceipt
from pipeline.records.validation import AllocationMap, AllocatorValidation
from pipeline.report.html import placed, write_page
from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_page, vehicle_receipt
from pipeline.stages.job import FirmwareFiles, Job, leaves_record
from pipeline.stages.page_provenance import page_provenance
from pipeline.vehicle.load import vehicle_notes
from pipeline.vehicle.schema import Vehicle

MODELS: dict[str, type[Record]] = {
    "load_test": LoadTestRecord,
    "mooring": MooringRecord,
    "open_water": OpenWaterRecord,
    "propeller": PropellerFit,
    "drive": DriveFit,
    "static": StaticCharacteristic,
    "inverse": InverseCharacteristic,
    "allocation": AllocationMap,
    "validation": AllocatorValidation,
}


@leaves_record
def run(job: Job) -> PageFile:
    """Write the page."""
    page = job.more_outputs[0]
    envelopes = {stage: job.envelope(stage, MODELS[stage]) for stage in RECORD_STAGES}
    results = _results(job, page, envelopes)
    write_page(vehicle_page(results, assets=placed(page.parents[1] / "assets", page)), page)
    return vehicle_receipt(results, {page.as_posix(): file_digest(page)})


def _results(job: Job, page: Path, envelopes: dict[str, Envelope[Any]]) -> VehicleResults:
    vehicle = job.vehicle()
    notes = (*vehicle_notes(vehicle), *_types_apart(job, vehicle))
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
        provenance=page_provenance(everything.values()),
        firmware_files=tuple(
            Path(os.path.relpath(file, page.parent)).as_posix() for file in sorted(files)
        ),
        page=page,
        trials=tuple(
            day
            for _, one in job.all_of("trial_page", PageReceipt)
            if (day := one.record) is not None
        ),
        changes=changes_of(job.vehicle_file),
        ignored=tuple(
            one
            for kind in (() if job.folder.thruster_type else (*RAW_KINDS, POOL))
            for one in ignored_file_problems(
                job.vehicle_file.parent / kind, f"{job.vehicle_name}/{kind}", vehicle.tables.types
            )
        ),
        **records,
    )


def _types_apart(job: Job, vehicle: Vehicle) -> tuple[str, ...]:
    """Say of each further type of thruster which thrusters are of it and where its page is."""
    of = {
        name: [one.name for one in vehicle.thrusters if vehicle.type_of(one) == name]
        for name in vehicle.tables.types
    }
    return tuple(
        f"tables of thruster type {name} ({', '.join(names) or 'no thruster'}) are on a page of "
        f"their own, {typed_name(job.vehicle_name, name)}."
        for name, names in of.items()
    )
