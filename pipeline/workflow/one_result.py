"""One stage's result of one vehicle, made anew where it is stale; what ``run --only`` would be."""

import shutil
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Generic, TypeVar

from pipeline.bundled.vehicles import bundled_vehicle, bundled_vehicles
from pipeline.errors import CannotComputeError, InputError, Problem
from pipeline.plan import TITLES, UsageError, VehicleFolder, choose, processed_file, report_file
from pipeline.provenance import file_digest, read_envelope, read_raw_envelope, unwritable
from pipeline.records.base import Record
from pipeline.records.validation import AllocatorValidation
from pipeline.stages.job import FirmwareFiles
from pipeline.workflow.outcome import check_line, failure_line, faults_behind
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import RunRequest, run

R = TypeVar("R", bound=Record)


@dataclass(frozen=True)
class OneResult(Generic[R]):
    """The result, the file it was read from, and the errors of raw files it had to do without.

    `failed_checks` are those of all that it was made from.
    """

    vehicle: VehicleFolder
    file: Path
    record: R
    refused: tuple[Problem, ...]
    failed_checks: tuple[str, ...] = ()


def one_result(request: RunRequest, stage: str, model: type[R], lacks: str) -> OneResult[R]:
    """Bring one stage's result up to date and read it; progress goes to standard error.

    The request names exactly one vehicle; `lacks` says of it what it is without the result.
    """
    result = run(replace(request, only=(stage,)), Progress(sys.stderr))
    for problem in result.refused:
        raise InputError(problem)
    name = result.vehicles[0]  # behind it come its further types of thruster
    if result.failed:
        raise CannotComputeError(failure_line(result.failed[0]))
    file = request.out / processed_file(name, stage)
    if not result.complete and not file.is_file():
        raise CannotComputeError(f"{name}: the run did not come to this: {TITLES[stage]}.")
    envelope = read_envelope(file, stage, model)
    if envelope.record is None:
        raise CannotComputeError(f"{name} {lacks} {envelope.why_not}")
    (vehicle,), _ = choose(request.vehicles, request.raw, request.out)
    return OneResult(vehicle, file, envelope.record, *faults_behind(vehicle, stage, request.out))


def export_firmware(request: RunRequest, to: Path) -> tuple[tuple[Path, ...], tuple[Problem, ...]]:
    """Copy one vehicle's firmware files into a folder, made anew where they are stale.

    Checks of the tables that failed are told on standard error: the files are good to compile, and
    whoever flashes them should know. Returns the files written, and the errors of raw files that
    the tables had to do without. The request names exactly one vehicle.
    """
    made = one_result(request, "firmware", FirmwareFiles, "has no firmware tables.")
    files = _copied([request.out / file for file in made.record.files], to)
    say = Progress(sys.stderr).say
    for note in made.record.notes:
        say(note)
    for check in made.failed_checks:
        say(check_line(made.vehicle.name, check))
    return files, made.refused


def _copied(sources: Sequence[Path], to: Path) -> tuple[Path, ...]:
    """Copy the files, none before all could be written: a header fits one source alone."""
    parts = [to / f".{source.name}.part" for source in sources]
    targets = tuple(to / source.name for source in sources)
    try:
        to.mkdir(parents=True, exist_ok=True)
        for source, part in zip(sources, parts, strict=True):
            shutil.copyfile(source, part)
        for part, target in zip(parts, targets, strict=True):
            part.replace(target)
    except OSError as error:
        for part in parts:
            with suppress(OSError):
                part.unlink()
        raise unwritable(to, error) from error
    return targets


def validated(
    text: str, raw: Path, out: Path
) -> tuple[OneResult[AllocatorValidation], Path | None]:
    """Run what is stale of what one vehicle's flights need; also the report that shows them.

    `text` is a name under the raw folder, a path to a folder with ``vehicle.yaml``, or a bundled
    name; `out` gets ``processed/`` and ``reports/``. Raises as `one_result`.
    """
    request = RunRequest((_place(text, raw, out),), raw, out)
    made = one_result(request, "validation", AllocatorValidation, "cannot be flown.")
    name = made.vehicle.name
    return made, out / report_file(name) if _is_shown(name, out) else None


def _is_shown(name: str, out: Path) -> bool:
    """Whether the vehicle's page was made with these flights."""
    file = processed_file(name, "validation")
    try:
        body = read_raw_envelope(out / processed_file(name, "vehicle_page"), "vehicle_page")
        return bool(body["inputs"].get(file) == file_digest(out / file))
    except (InputError, KeyError, TypeError, AttributeError):
        return False


def _place(text: str, raw: Path, out: Path) -> str:
    """Return what a run takes for the vehicle: a bundled one by its folder."""
    try:
        choose((text,), raw, out)
    except UsageError:
        if text in bundled_vehicles():
            return str(bundled_vehicle(text))
        raise
    return text
