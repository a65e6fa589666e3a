"""What of a vehicle is made anew: no result is believed that is half-written, edited, or of others.

The envelopes say what they were made from and by which code, so they are checked against what is
there now, whatever the times of files say. What does not fit is removed and made again.
"""

import errno
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.plan import MISNAMED, RAW_KINDS, VEHICLE_FILE, VehicleFolder, processed_file
from pipeline.provenance import code_digest, unwritable
from pipeline.stage_table import STAGES, stages_of
from pipeline.workflow.known_files import KnownFiles


def due_stages(
    vehicle: VehicleFolder,
    out: Path,
    wanted: frozenset[str],
    code: Callable[[str], str] = code_digest,
    *,
    known: KnownFiles | None = None,
    force: bool = False,
) -> tuple[str, ...]:
    """Return the stages of a vehicle whose results are missing or do not fit, in order.

    Parameters
    ----------
    vehicle : VehicleFolder
        The vehicle; its folder is relative to `out` or absolute.
    out : Path
        The folder of ``processed/`` and ``reports/``.
    wanted : frozenset of str
        The stages that are looked at, with all that they need.
    code : callable
        Digest of the code of a module, which takes its time: kept by who asks for many vehicles.
    known : KnownFiles, optional
        Digests from earlier runs.
    force : bool
        All of them are to be made anew.

    Raises
    ------
    InputError
        When a folder stands where a result belongs.
    """
    due: list[str] = []
    known = KnownFiles() if known is None else known
    for stage in stages_of("vehicle"):
        if stage not in wanted:
            continue
        path = out / processed_file(vehicle.name, stage)
        if path.is_dir():
            raise unwritable(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
        after = not set(due).isdisjoint(STAGES[stage].needs)
        of = code(f"pipeline.stages.{stage}")
        if force or after or not _is_fresh(path, stage, of, vehicle, out, known):
            due.append(stage)
    return tuple(due)


def remove_results(vehicle: VehicleFolder, out: Path, due: Sequence[str]) -> None:
    """Remove results that are made anew, and what a stage left that was ended while it wrote."""
    folder, reports = out / "processed" / vehicle.name, out / "reports"
    own = (*folder.rglob(".*.part"), *(reports / vehicle.name).rglob(".*.part"))
    shared = (*reports.glob(".*.part"), *(reports / "assets").glob(".*.part"))
    for left in (*own, *shared):
        if left.is_file():
            left.unlink(missing_ok=True)
    for left in folder.glob(".firmware.*"):
        shutil.rmtree(left, ignore_errors=True)
    for stage in due:
        (out / processed_file(vehicle.name, stage)).unlink(missing_ok=True)


def _is_fresh(  # noqa: PLR0917 - one caller
    path: Path, stage: str, code: str, vehicle: VehicleFolder, out: Path, known: KnownFiles
) -> bool:
    head = known.head(path, stage)
    expected = None
    if stage in RAW_KINDS and head is not None:
        expected = {f"{vehicle.digest_prefix}{VEHICLE_FILE}", *vehicle.digest_names(stage, out)}
        shown = vehicle.digest_prefix.removeprefix("raw/")
        room = f"{shown}{stage}/{vehicle.thruster_type}/".replace("//", "/")
        badly = {room + name for name in vehicle.misnamed_files(stage, out)}
        if badly != {one["place"]["file"] for one in head.problems if one["what"] == MISNAMED}:
            return False
    return known.fits(head, code, vehicle, out, expected)
