"""``rig2sea export``: bring the firmware sources up to date and copy them out."""

import shutil
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import CannotComputeError, Problem
from pipeline.plan import choose
from pipeline.provenance import unwritable
from pipeline.stages.receipt import FirmwareFiles
from pipeline.workflow.one_result import one_result
from pipeline.workflow.outcome import failed_checks_behind
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import RunRequest
from pipeline.workflow.summary import check_line


@dataclass(frozen=True)
class ExportedFiles:
    """The files written, and the errors of raw files that the tables had to do without."""

    files: tuple[Path, ...]
    refused: tuple[Problem, ...]


def export_firmware(request: RunRequest, to: Path) -> ExportedFiles:
    """Copy one vehicle's firmware files, made anew where they are stale.

    Checks of the tables that failed are told on standard error: the files are good to compile, and
    whoever flashes them should know.

    Parameters
    ----------
    request : RunRequest
        With exactly one vehicle.
    to : Path
        Folder that gets the files.

    Returns
    -------
    ExportedFiles
        The files written, and what is missing from them.

    Raises
    ------
    CannotComputeError
        When the vehicle's data do not give firmware tables; the text says why.
    InputError
        When the folder cannot be written.
    """
    made = one_result(request, "firmware", FirmwareFiles)
    receipt = made.envelope
    if receipt.record is None:
        raise CannotComputeError(f"{made.vehicle} has no firmware tables. {receipt.why_not}")
    sources = [request.out / file for file in receipt.record.files]
    files = _copied(sources, to)
    (vehicle,), _ = choose(request.vehicles, request.raw, request.out)
    say = Progress(sys.stderr).say
    for note in receipt.record.notes:
        say(note)
    for check in failed_checks_behind(vehicle, "firmware", request.out):
        say(check_line(made.vehicle, check))
    return ExportedFiles(files, made.refused)


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
