"""What of a vehicle is made anew: no result is believed that is half-written, edited, or of others.

The envelopes say what they were made from and by which code, so they are checked against what is
there now, whatever the times of files say. What does not fit is removed and made again.
"""

import errno
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.errors import InputError
from pipeline.plan import MISNAMED, RAW_KINDS, RECEIPT_STAGES, VehicleFolder, processed_file
from pipeline.provenance import code_digest, file_digest, read_raw_envelope, read_tables, unwritable
from pipeline.stage_table import STAGES, stages_of


def due_stages(
    vehicle: VehicleFolder,
    out: Path,
    wanted: frozenset[str],
    code: Callable[[str], str] = code_digest,
    *,
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
    force : bool
        All of them are to be made anew.

    Raises
    ------
    InputError
        When a folder stands where a result belongs.
    """
    due: list[str] = []
    digest = cache(file_digest)
    for stage in stages_of("vehicle"):
        if stage not in wanted:
            continue
        path = out / processed_file(vehicle.name, stage)
        if path.is_dir():
            raise unwritable(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
        after = not set(due).isdisjoint(STAGES[stage].needs)
        of = code(f"pipeline.stages.{stage}")
        if force or after or not _is_fresh(path, stage, of, vehicle, out, digest):
            due.append(stage)
    return tuple(due)


def remove_results(vehicle: VehicleFolder, out: Path, due: Sequence[str]) -> None:
    """Remove results that are made anew, and what a stage left that was ended while it wrote."""
    folder = out / "processed" / vehicle.name
    assets = (out / "reports" / "assets").glob(".*.part") if "vehicle_page" in due else ()
    for left in (*folder.glob(".*.part"), *assets):
        if left.is_file():
            left.unlink(missing_ok=True)
    for left in folder.glob(".firmware.*"):
        shutil.rmtree(left, ignore_errors=True)
    for stage in due:
        (out / processed_file(vehicle.name, stage)).unlink(missing_ok=True)


def _is_fresh(  # noqa: PLR0917 - one caller
    path: Path,
    stage: str,
    code: str,
    vehicle: VehicleFolder,
    out: Path,
    digest: Callable[[Path], str],
) -> bool:
    try:
        body = (
            read_tables(path)["provenance"] if stage == "tables" else read_raw_envelope(path, stage)
        )
        if body["code"] != code:
            return False
        if stage in RAW_KINDS and not _are_the_files(body, stage, vehicle, out):
            return False
        prefix, raw_folder = vehicle.digest_prefix, out / vehicle.folder
        made_from: Mapping[str, str] = body["inputs"]
        for name, known in made_from.items():
            is_raw = name.startswith(prefix)
            if digest(raw_folder / name.removeprefix(prefix) if is_raw else out / name) != known:
                return False
        if stage in RECEIPT_STAGES and body["record"] is not None:
            files: Mapping[str, str] = body["record"]["files"]
            return all(digest(out / name) == files[name] for name in files)
    except (InputError, KeyError, TypeError, AttributeError, ValueError):
        return False
    return True


def _are_the_files(body: Mapping[str, Any], kind: str, vehicle: VehicleFolder, out: Path) -> bool:
    """Whether a result is of the raw files there are, those counted that have a bad name."""
    room = f"{vehicle.digest_prefix}{kind}/"
    read = {name for name in body["inputs"] if name.startswith(room)}
    shown = f"{room.removeprefix('raw/')}{vehicle.thruster_type}/".replace("//", "/")
    badly = {shown + name for name in vehicle.misnamed_files(kind, out)}
    return read == vehicle.digest_names(kind, out) and _named_badly(body) == badly


def _named_badly(body: Mapping[str, Any]) -> set[str]:
    """Return the raw files that a result says were not read for their names."""
    problems = (*body["problems"], *(body["record"] or {}).get("problems", ()))
    return {one["place"]["file"] for one in problems if one["what"] == MISNAMED}
