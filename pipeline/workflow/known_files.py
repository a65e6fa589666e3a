"""What a result was made from, and whether it still fits; digests are remembered from run to run.

A result fits where this code made it of these files as they are now: `misfits` alone says so, for
stages, runs, days and ``rig2sea why``.

Two hundred logs of a season are gigabytes: a run that has nothing to do must not read them again.
A file is known by its size, its times (that of the last change of its entry too, which no program
can set back) and its number on the disk; whatever differs is read anew. The memory, the only one
of the workflow, is a help: without it, or with a broken one, everything is read.
"""

import errno
import json
import os
import shutil
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.errors import InputError
from pipeline.plan import (
    MISNAMED,
    RAW_KINDS,
    VehicleFolder,
    is_vehicle_name,
    processed_file,
)
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
_SCHEMA = "rig2sea/known_files/2"


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
    """The memory; `load` and `save` it around a run.

    Beside files it knows the folder that each vehicle was in (`places`), and what the index was
    made from when all was done last (`settled`).
    """

    digests: dict[str, list[Any]] = field(default_factory=dict)
    heads: dict[str, list[Any]] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)
    settled: str = ""
    _used: set[str] = field(default_factory=set)

    @classmethod
    def load(cls, path: Path) -> "KnownFiles":
        """Read the memory; a missing or broken one is empty."""
        try:
            body = json.loads(path.read_text(encoding="utf-8"))
            if body["schema"] == _SCHEMA:
                places = {
                    name: folder
                    for name, folder in body["places"].items()
                    if isinstance(folder, str) and is_vehicle_name(name)
                }
                return cls(dict(body["digests"]), dict(body["heads"]), places, str(body["settled"]))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            pass
        return cls()

    def save(self, path: Path) -> None:
        """Write what was asked for since it was loaded; the rest belongs to files that are gone."""
        body = {
            "schema": _SCHEMA,
            "digests": {key: own for key, own in self.digests.items() if key in self._used},
            "heads": {key: own for key, own in self.heads.items() if key in self._used},
            "places": self.places,
            "settled": self.settled,
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


def stage_inputs(
    vehicle: VehicleFolder, stage: str, out: Path, types: Iterable[str] = ()
) -> list[str]:
    """Return the files that a stage of a vehicle reads; `types` are its further thruster types.

    The folder of the vehicle is relative to `out`, that of ``processed/`` and ``reports/``, or
    absolute; types are named as their results are. Pages of days come on top, for its page.
    """
    needs, of_types = STAGES[stage].needs, STAGES[stage].of_types
    raw = vehicle.raw_files(stage, out) if stage in RAW_KINDS else ()
    results = [processed_file(vehicle.name, need) for need in needs]
    results += [processed_file(name, need) for name in types for need in of_types]
    return [vehicle.vehicle_file, *raw, *results]


def due_stages(  # noqa: PLR0917 - what results are compared with
    vehicle: VehicleFolder,
    out: Path,
    wanted: Collection[str],
    code: Callable[[str], str] = code_digest,
    types: Iterable[str] = (),
    receipts: Sequence[str] = (),
    *,
    known: KnownFiles | None = None,
    force: bool = False,
) -> tuple[str, ...]:
    """Return the stages of a vehicle whose results are missing or do not fit, in order.

    `wanted` are the stages that are looked at, with all that they need but for what is removed;
    `force`: all of them are to be made anew. `code` gives the digest of the code of a module, which
    takes its time: kept by who asks for many vehicles. `types` are as of `stage_inputs`, `receipts`
    those of the pages of days. `known` has digests from earlier runs.

    Raises `InputError` when a folder stands where a result belongs.
    """
    due: list[str] = []
    known = known or KnownFiles()
    for stage in (one for one in stages_of("vehicle") if one in wanted):
        path = out / processed_file(vehicle.name, stage)
        if path.is_dir():
            raise unwritable(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
        files = stage_inputs(vehicle, stage, out, types)
        files += receipts if stage == "vehicle_page" else ()
        head, names = known.head(path, stage), vehicle.names_in_results(files)
        after = not set(due).isdisjoint(STAGES[stage].needs)
        fits = known.fits(head, code(module_of(stage)), vehicle, out, names)
        if force or after or not fits or _misnamed_differ(head, stage, vehicle, out):
            due.append(stage)
    return tuple(due)


def _misnamed_differ(head: Head | None, stage: str, vehicle: VehicleFolder, out: Path) -> bool:
    """Whether a result names other files that cannot be read for their names than there are."""
    if stage not in RAW_KINDS or head is None:
        return False
    shown = vehicle.digest_prefix.removeprefix("raw/")
    room = f"{shown}{stage}/{vehicle.thruster_type}/".replace("//", "/")
    badly = {room + name for name in vehicle.misnamed_files(stage, out)}
    return badly != {one["place"]["file"] for one in head.problems if one["what"] == MISNAMED}


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
