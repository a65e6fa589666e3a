"""``rig2sea export``: bring the firmware sources up to date and copy them out."""

import shutil
from dataclasses import replace
from pathlib import Path

from pipeline.errors import CannotComputeError, InputError
from pipeline.plan import processed_file
from pipeline.provenance import read_envelope, unwritable
from pipeline.stages.receipt import FirmwareFiles
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import Request, run
from pipeline.workflow.summary import failure_line


def export_firmware(request: Request, to: Path) -> list[Path]:
    """Copy one vehicle's firmware files, made anew where they are stale.

    Parameters
    ----------
    request : Request
        With exactly one vehicle.
    to : Path
        Folder that gets the files.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    CannotComputeError
        When the vehicle's data do not give firmware tables; the text says why.
    InputError
        When the folder cannot be written.
    """
    result = run(replace(request, only=("firmware",)), Progress(quiet=True))
    for problem in result.refused:
        raise InputError(problem)
    (outcome,) = result.outcomes
    name = outcome.vehicle
    if result.failed:
        raise CannotComputeError(failure_line(result.failed[0]))
    receipt = request.out / processed_file(name, "firmware")
    envelope = read_envelope(receipt, "firmware", FirmwareFiles)
    if envelope.record is None:
        raise CannotComputeError(f"{name} has no firmware tables. {envelope.why_not}")
    written = []
    try:
        to.mkdir(parents=True, exist_ok=True)
        for file in envelope.record.files:
            source = request.out / file
            part = to / f".{source.name}.part"
            shutil.copyfile(source, part)
            part.replace(to / source.name)
            written.append(to / source.name)
    except OSError as error:
        raise unwritable(to, error) from error
    return written
