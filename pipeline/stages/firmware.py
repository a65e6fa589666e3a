"""Inverse characteristic -> firmware sources, and a receipt that names them."""

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from pipeline import __version__
from pipeline.errors import CannotComputeError
from pipeline.export.allocator_layout import AllocatorLayout, allocator_layout
from pipeline.export.c_source import VoltageTables, voltage_tables
from pipeline.export.firmware import write_firmware
from pipeline.provenance import file_digest, unwritable
from pipeline.records.fits import FirmwareCharacteristic, InverseCharacteristic
from pipeline.stages.job import FirmwareFiles, Job, NotMeasuredError, leaves_record
from pipeline.vehicle.schema import Gate


@leaves_record
def run(job: Job) -> FirmwareFiles:
    """Write the sources into ``firmware/``: all of them, or none."""
    folder = job.output.parent / "firmware"
    try:
        shutil.rmtree(folder, ignore_errors=True)
        vehicle = job.vehicle()
        made, voltages = {}, {}
        for name in vehicle.used_types:
            inverse = job.of_type(name).needed("inverse", InverseCharacteristic)
            if inverse.firmware is None:
                raise NotMeasuredError(
                    "The inverse characteristic has no firmware form. "
                    + " ".join(inverse.explanations)
                )
            _refuse_failed(inverse, vehicle.accept)
            made[name] = inverse.firmware
            voltages[name] = voltage_tables(inverse)
        return _write_whole(job, made, voltages, folder)
    except OSError as error:
        raise unwritable(folder, error) from error


def _refuse_failed(inverse: InverseCharacteristic, accepted: Mapping[Gate, str]) -> None:
    """Write no firmware from tables of which a check says that they may be wrong."""
    failed = [
        check
        for check in inverse.checks
        if not check.passed and check.gate and check.gate not in accepted
    ]
    if failed:
        said = "; ".join(f"{check.name}: no, {check.text}" for check in failed)
        lines = ", ".join(f'{check.gate}: "..."' for check in failed)
        raise CannotComputeError(
            f"No firmware was written, because {said}. Correct the test, or say in vehicle.yaml "
            f"why it may be used all the same: accept: {{{lines}}}."
        )


def _write_whole(
    job: Job,
    made: Mapping[str, FirmwareCharacteristic],
    voltages: Mapping[str, VoltageTables],
    folder: Path,
) -> FirmwareFiles:
    """Write the sources of every type of thruster, and the allocator of all."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".firmware.") as temporary:
        work = Path(temporary) / "firmware"
        work.mkdir()
        vehicle = job.vehicle()
        layout: AllocatorLayout | None = None
        notes: tuple[str, ...] = ()
        try:
            others = {name: one for name, one in made.items() if name}
            several = [name for name, rows in voltages.items() if rows]
            layout = allocator_layout(vehicle, made[""], others, several)
        except CannotComputeError as error:
            notes = (str(error),)
        for name, characteristic in made.items():
            of_type = job.of_type(name)
            tables = of_type.tables()
            digest = tables.pop("provenance")["tables_sha256"]
            write_firmware(
                of_type.vehicle_name,
                characteristic,
                tables_digest=digest,
                tool_version=__version__,
                folder=work,
                tables=tables,
                layout=None if name else layout,
                accepted={str(gate): why for gate, why in vehicle.accept.items()},
                voltages=voltages[name],
            )
        files = {
            (folder / path.name).as_posix(): file_digest(path) for path in sorted(work.iterdir())
        }
        work.rename(folder)
    return FirmwareFiles(files=files, notes=notes)
