"""What a result was made from, and whether it still fits; digests are remembered from run to run.

A result fits where this code made it of these files as they are now: `misfits` alone says so, for
stages, runs, days and ``rig2sea why``.

Two hundred logs of a season are gigabytes: a run that has nothing to do must not read them again.
A file is known by its size, its times (that of the last change of its entry too, which no program
can set back) and its number on the disk; whatever differs is read anew. The memory is a help only:
without it, or with a broken one, everything is read.
"""

import errno
import json
import os
import shutil
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.errors import InputError
from pipeline.plan import MISNAMED, RAW_KINDS, VEHICLE_FILE, VehicleFolder, processed_file
from pipeline.provenance import (
    UNREADABLE,
    code_digest,
    file_digest,
    read_raw_envelope,
    read_tables,
    unwritable,
    write_atomically,
)
from pipeline.stage_table import STAGES, module_of, stages_of

#: A file that changed less than this ago may change again without a sign. [ns]
_YOUNG_NS = 100_000_000
_SCHEMA = "rig2sea/known_files/1"


@dataclass(frozen=True)
class Head:
    """What a processed file says of itself, without its numbers."""

    code: str
    inputs: dict[str, str]
    files: dict[str, str]
    why_not: str | None
    problems: tuple[Mapping[str, Any], ...]
    """Those of the file and of its record."""


def read_head(path: Path, kind: str) -> Head:
    """Read what a processed file says of itself."""
    if kind == "tables":
        body = {"record": None, "why_not": None, "problems": ()} | read_tables(path)["provenance"]
    else:
        body = read_raw_envelope(path, kind)
    record = body["record"] or {}
    return Head(
        str(body["code"]),
        dict(body["inputs"]),
        dict(record.get("files", {})),
        body["why_not"],
        (*body["problems"], *record.get("problems", ())),
    )


def misfits(  # noqa: PLR0917 - what a result is compared with
    head: Head,
    code: str,
    vehicle: VehicleFolder,
    out: Path,
    digest: Callable[[Path], str],
    expected: Collection[str] | None = None,
) -> Iterator[str]:
    """Yield each reason why a result does not fit what there is now; none where it does.

    `head` is what the result says of itself, `code` the digest of the code that would make it now,
    `digest` gives that of a file as it is now; `expected` names all the files that it would be made
    from now. `out` is the folder of ``processed/``.
    """
    if head.code != code:
        yield "the program has changed since"
    for name, known in sorted((head.inputs | head.files).items()):
        now = digest(vehicle.place_of(out, name))
        if now != known or (
            expected is not None and name not in expected and name not in head.files
        ):
            yield f"{name} {'is gone' if now == UNREADABLE else 'has changed since'}"
    if expected is not None:
        yield from (f"{name} is new" for name in sorted(set(expected) - head.inputs.keys()))


@dataclass
class KnownFiles:
    """The memory; `load` and `save` it around a run."""

    digests: dict[str, list[Any]] = field(default_factory=dict)
    heads: dict[str, list[Any]] = field(default_factory=dict)
    _used: set[str] = field(default_factory=set)

    @classmethod
    def load(cls, path: Path) -> "KnownFiles":
        """Read the memory; a missing or broken one is empty."""
        try:
            body = json.loads(path.read_text(encoding="utf-8"))
            if body["schema"] == _SCHEMA:
                return cls(dict(body["digests"]), dict(body["heads"]))
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            pass
        return cls()

    def save(self, path: Path) -> None:
        """Write what was asked for since it was loaded; the rest belongs to files that are gone."""
        body = {
            "schema": _SCHEMA,
            "digests": {key: own for key, own in self.digests.items() if key in self._used},
            "heads": {key: own for key, own in self.heads.items() if key in self._used},
        }
        write_atomically(path, json.dumps(body))

    def digest(self, path: Path) -> str:
        """SHA-256 of a file, or `UNREADABLE`."""
        key, mark = _mark(path)
        self._used.add(key)
        if mark is None:
            return UNREADABLE
        known = self.digests.get(key)
        if known is not None and known[0] == mark:
            return str(known[1])
        found = file_digest(path)
        if found != UNREADABLE and _is_settled(mark):
            self.digests[key] = [mark, found]
        return found

    def fits(
        self,
        head: Head | None,
        code: str,
        vehicle: VehicleFolder,
        out: Path,
        expected: Collection[str] | None = None,
    ) -> bool:
        """Whether there is a result, and `misfits` has nothing against it."""
        if head is None:
            return False
        return next(misfits(head, code, vehicle, out, self.digest, expected), None) is None

    def head(self, path: Path, kind: str) -> Head | None:
        """Return what a processed file says, None when it is absent, broken or edited."""
        key, mark = _mark(path)
        self._used.add(key)
        if mark is None:
            return None
        known = self.heads.get(key)
        try:
            if known is not None and known[0] == mark and known[1] == kind:
                return Head(*known[2])
            found = read_head(path, kind)
        except (InputError, KeyError, TypeError, AttributeError, ValueError, IndexError):
            return None
        if _is_settled(mark):
            self.heads[key] = [
                mark,
                kind,
                [found.code, found.inputs, found.files, found.why_not, list(found.problems)],
            ]
        return found


def _mark(path: Path) -> tuple[str, list[int] | None]:
    try:
        status = os.stat(path)  # noqa: PTH116 - asked a thousand times a run
    except OSError:
        return str(path), None
    mark = [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]
    return str(path), mark


def _is_settled(mark: list[int]) -> bool:
    return time.time_ns() - max(mark[1], mark[2]) > _YOUNG_NS


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

    Its folder is relative to `out`, that of ``processed/`` and ``reports/``, or absolute. `wanted`
    are the stages that are looked at, with all that they need; `force`: all of them are to be made
    anew. `code` gives the digest of the code of a module, which takes its time: kept by who asks
    for many vehicles. `known` has digests from earlier runs.

    Raises `InputError` when a folder stands where a result belongs.
    """
    due: list[str] = []
    known = known or KnownFiles()
    for stage in stages_of("vehicle"):
        if stage not in wanted:
            continue
        path = out / processed_file(vehicle.name, stage)
        if path.is_dir():
            raise unwritable(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
        after = not set(due).isdisjoint(STAGES[stage].needs)
        of = code(module_of(stage))
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
