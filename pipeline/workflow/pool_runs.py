"""Which pool runs a vehicle has, what their results are called, and on which day each was made."""

import hashlib
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePath

from pipeline.errors import Place, Problem
from pipeline.ingest.log_files import (
    bags_in,
    dates_in,
    is_log_name,
    not_a_log,
    parts_of,
    unprintable_log,
)
from pipeline.plan import POOL, VehicleFolder, is_raw, printable
from pipeline.stage_table import STAGES
from pipeline.vehicle.run_notes import BAG_FILE, run_of

UNDATED = "undated"
_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
_NOTES = (".yaml", ".yml")


@dataclass(frozen=True)
class PoolLog:
    """A log of a vehicle: `run` is its name among the results, `path` as the workflow sees it."""

    run: str
    path: str
    notes: str | None = None
    parts: tuple[str, ...] = ()
    """Of a bag in a folder, the other files there."""

    @property
    def inputs(self) -> tuple[str, ...]:
        """The files that the run is read from, the one it is known by first."""
        notes = () if self.notes is None else (self.notes,)
        return (self.path, *notes, *self.parts)


def run_name(file: str) -> str:
    """Return the name of a log's results: its own where that is plain, else one made safe.

    Names become parts of paths and addresses; a digest of the file's name keeps two that look
    alike apart.

    >>> run_name("zig_zag-3.mcap")
    'zig_zag-3'
    >>> run_name("rosbag2_7/metadata.yaml")
    'rosbag2_7'
    >>> run_name("проба 1/5?.mcap")
    '1_5-9b2ec523'
    """
    bag = file.removesuffix(f"/{BAG_FILE}")
    stem, ending = os.path.splitext(file)  # noqa: PTH122 - the text may hold what no path may
    if bag != file:
        file, stem, ending = bag, bag, ".mcap"
    if ending == ".mcap" and _PLAIN.fullmatch(stem):
        return stem
    safe = re.sub(r"[^A-Za-z0-9._-]+", "_", stem).strip("._-")[:60] or "run"
    return f"{safe}-{hashlib.sha256(file.encode(errors='surrogateescape')).hexdigest()[:8]}"


def pool_logs(
    vehicle: VehicleFolder, base: Path, waiting: frozenset[str] = frozenset()
) -> tuple[PoolLog, ...]:
    """Find a vehicle's logs, by name of the file; its folder is relative to `base`.

    `waiting` names logs that are still being copied: left for later.
    """
    folder = base / vehicle.folder / POOL
    found: list[PoolLog] = []
    files = set(file_names(folder)) - {BAG_FILE}
    names = files | {path.relative_to(folder).as_posix() for path in bags_in(folder)}
    for name in sorted(names):
        if not is_log_name(name) or name in waiting or not name.isprintable():
            continue
        stem = run_of(PurePath(name))
        notes = next((stem + end for end in _NOTES if stem + end in names), None)
        place = f"{vehicle.folder}/{POOL}"
        notes_path = f"{place}/{notes}" if notes is not None else None
        run = run_name(name)
        if run.lower() in {log.run.lower() for log in found}:
            # another log has this name already: each is to keep results of its own
            run = f"{run[:60]}-{hashlib.sha256(name.encode(errors='surrogateescape')).hexdigest()}"
        parts = tuple(f"{place}/{path.relative_to(folder)}" for path in parts_of(folder / name))
        found.append(PoolLog(run, f"{place}/{name}", notes_path, parts))
    return tuple(found)


def day_problems(vehicle: str, logs: Iterable[PoolLog], days: Mapping[str, str]) -> list[Problem]:
    """Return a warning for each log whose name says another day than its times.

    `days` gives the day that each run is taken for.
    """
    found = []
    for log in logs:
        name = log.path.partition(f"/{POOL}/")[2]
        said, day = dates_in(run_of(PurePath(name))), days.get(log.run, UNDATED)
        if said and day not in {UNDATED, *said}:
            found.append(
                Place(f"{vehicle}/{POOL}/{printable(name)}").warning(
                    f"the file's name says {said[0]}, the times in the log say {day}: it is taken "
                    "for a run of that day.",
                    remedy="Rename the file, or set the recorder's clock.",
                )
            )
    return found


def pool_problems(vehicle: VehicleFolder, base: Path) -> tuple[Problem, ...]:
    """Return a problem for each file in ``pool/`` that is not read as a run."""
    folder = base / vehicle.folder / POOL
    found = []
    for name in sorted(file_names(folder)):
        if not is_raw(name):
            continue
        shown = f"{vehicle.name}/{POOL}/{printable(name)}"
        if not is_log_name(name) or name == BAG_FILE:
            found.append(not_a_log(shown))
        elif not name.isprintable():
            found.append(unprintable_log(shown))
    return tuple(found)


def file_names(folder: Path) -> list[str]:
    """Return the names of the files in a folder of raw files, as they come; none without a folder.

    Hidden files and the lock files of spreadsheet programs are left out, and so is a link that
    leads nowhere, or round in a circle.
    """
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if not entry.name.startswith((".", "~$"))]
    except (FileNotFoundError, NotADirectoryError):
        return []
    return [name for name in names if (folder / name).is_file()]


def log_size(path: Path) -> int:
    """Return the bytes of a log, 0 when it has gone."""
    try:
        return sum(one.stat().st_size for one in (path, *parts_of(path)))
    except OSError:
        return 0


def by_day(days: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Turn run -> day round: the days in order, those without a date last.

    >>> by_day({"b": "2026-05-04", "a": "2026-05-04", "c": "undated"})
    {'2026-05-04': ('a', 'b'), 'undated': ('c',)}
    """
    found: dict[str, list[str]] = {}
    for run, day in sorted(days.items()):
        found.setdefault(day, []).append(run)
    return {day: tuple(found[day]) for day in sorted(found, key=lambda day: (day == UNDATED, day))}


def result_file(vehicle: str, stage: str, item: str) -> str:
    """Path of a stage's result of one run or one day, from the output folder."""
    return f"processed/{vehicle}/{STAGES[stage].room}/{item}.json"
