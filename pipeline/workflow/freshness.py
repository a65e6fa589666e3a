"""Sweep before a run: no result is believed that is half-written, edited, or from other inputs.

The engine decides by its own memory and by file times; both can be lost or wrong. The envelopes
say what they were made from, so they are checked against what is there now, and what does not fit
is removed and made again.
"""

import errno
import os
import shutil
import time
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

from pipeline.errors import InputError
from pipeline.plan import RAW_KINDS, RECEIPT_STAGES, RECORD_STAGES, VehicleFolder, processed_file
from pipeline.provenance import code_digest, file_digest, read_raw_envelope, read_tables, unwritable


def remove_stale(vehicle: VehicleFolder, out: Path, *, pages: bool = True) -> list[str]:
    """Remove a vehicle's results that do not fit their inputs; later ones follow from the engine.

    Parameters
    ----------
    vehicle : VehicleFolder
        The vehicle; its folder is relative to `out` or absolute.
    out : Path
        The folder of ``processed/`` and ``reports/``.
    pages : bool
        Whether pages are made in this execution, and so looked at.

    Returns
    -------
    list of str
        The files removed, from the output folder.

    Raises
    ------
    InputError
        When a folder stands where a result belongs.
    """
    folder = out / "processed" / vehicle.name
    assets = (out / "reports" / "assets").glob(".*.part") if pages else ()
    for left in (*folder.glob(".*.part"), *assets):
        if left.is_file():
            left.unlink(missing_ok=True)
    for left in folder.glob(".firmware.*"):
        shutil.rmtree(left, ignore_errors=True)
    # a stage later in the order is looked at after its inputs: a chain falls at its first link
    removed = []
    digest = cache(file_digest)
    for stage in (*RECORD_STAGES, "tables", *RECEIPT_STAGES):
        relative = processed_file(vehicle.name, stage)
        path = out / relative
        if stage == "vehicle_page" and not pages:
            continue
        if path.is_dir():
            raise unwritable(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
        if path.is_file() and not _is_fresh(path, stage, vehicle, out, digest):
            path.unlink()
            removed.append(relative)
        elif path.is_file():
            _bring_back_from_the_future(path)
    index = out / "reports" / "index.html"
    if pages and index.is_file() and index.stat().st_mtime > time.time():
        os.utime(index, (0, 0))  # nothing tells what it was made from: it is made anew
    return removed


def _bring_back_from_the_future(path: Path) -> None:
    """Give a sound result that is newer than now, because the clock was set back, the time of now.

    The engine would take it for newer than all that is made from it, again and again. Called in the
    order in which data flow, it keeps that order.
    """
    if path.stat().st_mtime > time.time():
        os.utime(path)


def _is_fresh(
    path: Path, stage: str, vehicle: VehicleFolder, out: Path, digest: Callable[[Path], str]
) -> bool:
    try:
        body = (
            read_tables(path)["provenance"] if stage == "tables" else read_raw_envelope(path, stage)
        )
        inputs: Mapping[str, str] = body["inputs"]
        if body["code"] != code_digest(f"pipeline.stages.{stage}"):
            return False
        raw_folder = out / vehicle.folder
        prefix = vehicle.digest_prefix
        if stage in RAW_KINDS:
            there = vehicle.digest_names(stage, out)
            if there != {name for name in inputs if name.startswith(f"{prefix}{stage}/")}:
                return False
        for name, known in inputs.items():
            actual = (
                raw_folder / name.removeprefix(prefix) if name.startswith(prefix) else out / name
            )
            if digest(actual) != known:
                return False
        if stage in RECEIPT_STAGES and body["record"] is not None:
            files: Mapping[str, str] = body["record"]["files"]
            return all(digest(out / name) == files[name] for name in files)
    except (InputError, KeyError, TypeError, AttributeError, ValueError):
        return False
    return True
