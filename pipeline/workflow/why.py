"""``rig2sea why``: a number of the tables, and the chain of files that it came from."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Place
from pipeline.inputs.vehicle_changes import changes_of
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import (
    RECORD_STAGES,
    TITLES,
    VEHICLE_FILE,
    UsageError,
    VehicleFolder,
    choose,
    discover,
    processed_file,
)
from pipeline.provenance import (
    UNREADABLE,
    canonical_json,
    code_digest,
    file_digest,
    read_envelope,
    read_raw_envelope,
    read_tables,
)
from pipeline.records.base import AppliedChange
from pipeline.records.measurements import MooringRecord
from pipeline.stage_table import module_of
from pipeline.vehicle.bench_schema import is_at_supply
from pipeline.vehicle.change_list import value_at
from pipeline.vehicle.estimates import Estimate, estimates_of
from pipeline.vehicle.load import load_checked, load_vehicle
from pipeline.vehicle.schema import Vehicle
from pipeline.workflow.cell import Cell, find_cell
from pipeline.workflow.known_files import Head, misfits
from pipeline.workflow.vehicle_places import with_types


@dataclass(frozen=True)
class Points:
    """Points that a raw file gave: all of them, and those that the reader left out."""

    sheet: str | None
    points: int
    left_out: int


@dataclass(frozen=True)
class Raw:
    """A raw file: digest when it was read, digest now, and what was read in it."""

    path: str
    sha256: str
    sha256_now: str
    read: tuple[Points, ...] = ()

    @property
    def fits(self) -> bool:
        """Whether it is the file that was read."""
        return self.sha256 == self.sha256_now


@dataclass(frozen=True)
class Link:
    """A processed file: what made it, when, and why it does not fit any more (`stale`)."""

    path: str
    stage: str
    title: str
    sha256: str
    version: str
    code: str
    code_now: str
    made_utc: str
    why_not: str | None
    stale: tuple[str, ...]
    inputs: tuple["Link", ...]
    raw: tuple[Raw, ...]

    @property
    def fits(self) -> bool:
        """Whether this file and all before it are up to date."""
        return not self.stale and all(link.fits for link in self.inputs)


def lineage(vehicle: VehicleFolder, out: Path, table: str, stage: str) -> Link:
    """Follow a table of ``tables.json`` back to the raw files: that file with all it is made from.

    `stage` computed the table: the other inputs of ``tables.json`` are left out, and of the inverse
    characteristic those that this table is not made of. The vehicle's folder is relative to `out`,
    that of ``processed/``, or absolute.
    """
    path = out / processed_file(vehicle.name, "tables")
    body = read_tables(path)["provenance"]
    # Table 3 is fitted to the mooring test alone, Table 4 to the static characteristic alone
    spare = {"table3": ("static",), "table4": ("mooring",)}.get(table, ())
    return _link(vehicle, out, "tables", body, only=(stage,), spare=spare)


def _link(
    vehicle: VehicleFolder,
    out: Path,
    stage: str,
    body: Mapping[str, Any],
    *,
    only: Sequence[str] | None = None,
    spare: Sequence[str] = (),
) -> Link:
    relative = processed_file(vehicle.name, stage)
    inputs: Mapping[str, str] = body["inputs"]
    code_now, path = code_digest(module_of(stage)), out / relative
    there = vehicle.names_in_results(vehicle.raw_files(stage, out))
    digest = cache(file_digest)
    head = Head(body["code"], dict(inputs), {}, None, ())
    stale = misfits(head, code_now, vehicle, out, digest, there | inputs.keys())
    links: list[Link] = []
    raw: list[Raw] = []
    read = _points(body.get("record"))
    for name, known in sorted(inputs.items()):
        before = Path(name).stem
        is_result = name == processed_file(vehicle.name, before) and before in RECORD_STAGES
        if not is_result:
            points = read.get(name.removeprefix("raw/"), ())
            raw.append(Raw(name, known, digest(vehicle.place_of(out, name)), points))
        elif before not in spare and (only is None or before in only) and _is_before(before, stage):
            links.append(
                _link(vehicle, out, before, read_raw_envelope(out / name, before), spare=spare)
            )
    return Link(
        path=relative,
        stage=stage,
        title=TITLES[stage],
        sha256=file_digest(path),
        version=body["version"],
        code=body["code"],
        code_now=code_now,
        made_utc=datetime.fromtimestamp(path.stat().st_mtime, UTC).strftime("%Y-%m-%d %H:%M:%S"),
        why_not=body.get("why_not"),
        stale=tuple(stale),
        inputs=tuple(links),
        raw=tuple(raw),
    )


def _is_before(stage: str, after: str) -> bool:
    """Tell whether data flow that way: a chain has an end, whatever a file says."""
    order = (*RECORD_STAGES, "tables")
    return order.index(stage) < order.index(after)


def _points(record: Mapping[str, Any] | None) -> dict[str, tuple[Points, ...]]:
    """Count the points of a record of measurements by file and sheet."""
    points = (record or {}).get("points")
    if not isinstance(points, list):
        return {}
    every: Counter[tuple[str, str | None]] = Counter()
    out: Counter[tuple[str, str | None]] = Counter()
    for point in points:
        key = (point["source"]["file"], point["source"]["sheet"])
        every[key] += 1
        out[key] += bool(point["marks"])
    found: dict[str, tuple[Points, ...]] = {}
    for (file, sheet), count in every.items():
        found[file] = (*found.get(file, ()), Points(sheet, count, out[file, sheet]))
    return found


_SIGNS = {"positive": 1, "negative": -1}

#: Sections of a vehicle file that a path may begin with.
_SECTIONS = frozenset({"water", "propellers", "drives", "thrusters", "model", "sensors"})


@dataclass(frozen=True)
class SparePoints:
    """Points of one sign of code that are not fitted.

    `dead` of them gave `thrust_dead_n` [N] or less, `other_supply` were taken at another supply
    voltage than the tables are for.
    """

    thrust_dead_n: float
    dead: int
    other_supply: int


def spare_points(cell: Cell, vehicle: VehicleFolder, out: Path) -> SparePoints | None:
    """Count them for a number of Table 3; None for any other, and where nothing can be counted."""
    sign = _SIGNS.get(cell.path.partition(".")[2].partition("[")[0])
    if cell.table != "table3" or sign is None:
        return None
    try:
        tables = load_vehicle(out / vehicle.vehicle_file).tables
        path = out / processed_file(vehicle.name, "mooring")
        record = read_envelope(path, "mooring", MooringRecord).record
    except InputError:
        return None
    if record is None:
        return None
    own = [one for one in record.points if not one.marks and sign * one.code > 0]
    near = [one for one in own if is_at_supply(one.voltage_v, tables.supply_voltage_v)]
    dead = sum(sign * one.thrust_n <= tables.thrust_dead_n for one in near)
    return SparePoints(tables.thrust_dead_n, dead, len(own) - len(near))


@dataclass(frozen=True)
class StatedNumber:
    """A number of the vehicle file; `change` is the entry of the list that wrote it, if one did."""

    vehicle: str
    file: Path
    path: str
    value: object
    estimate: Estimate | None
    change: AppliedChange | None
    source_now: str
    """Digest now of the result that the change is from."""


def why_stated(vehicle: str, words: Sequence[str], raw: Path, out: Path) -> StatedNumber | None:
    """Find a number of the vehicle file; None where the words do not begin as one of its paths.

    Thrusters may be named in place of their number: ``thrusters.upper.gain_ahead``.
    """
    parts = [part for word in words for part in re.split(r"[.\[\]]+", word) if part]
    if not parts or parts[0] not in _SECTIONS:
        return None
    name, file = find_vehicle(vehicle, raw, out)
    stated = load_checked(file, Vehicle, expected=f"a {VEHICLE_FILE}.", remedy="")
    numbers = {one.name: str(index) for index, one in enumerate(stated.thrusters)}
    if parts[0] == "thrusters" and len(parts) > 1:
        parts[1] = numbers.get(parts[1], parts[1])
    path = ".".join(parts)
    value = value_at(stated.model_dump(), path)
    if value is None or isinstance(value, dict | list | tuple):
        raise UsageError(
            f"{file} has no number {path}. Expected the path of one, such as "
            "thrusters.upper.gain_ahead or model.damping.linear[0]."
        )
    held = [one for one in changes_of(file) if not one.undone_utc]
    wrote = [one for one in held if any(change.path == path for change in one.changes)]
    change = wrote[-1] if wrote else None
    now = UNREADABLE if change is None else file_digest(out / change.source)
    return StatedNumber(name, file, path, value, estimates_of(file).get(path), change, now)


@dataclass(frozen=True)
class Why:
    """A number and its chain; of Table 3 the sound points that it has no use for, too."""

    vehicle: str
    cell: Cell
    chain: Link
    spare: SparePoints | None = None


def why(vehicle: str, words: Sequence[str], raw: Path, out: Path) -> Why:
    """Find a number of a vehicle's tables and follow it back."""
    folder = _one(vehicle, raw, out)
    tables = out / processed_file(folder.name, "tables")
    if not tables.exists():
        raise InputError.at(
            Place(str(tables)), "not made yet.", remedy=f"Make it: rig2sea run {folder.name}"
        )
    cell = find_cell(read_tables(tables), words)
    chain = lineage(folder, out, cell.table, cell.stage)
    return Why(folder.name, cell, chain, spare_points(cell, folder, out))


def _one(vehicle: str, raw: Path, out: Path) -> VehicleFolder:
    for one in with_types(discover(raw, out)[0], out):
        if one.name == vehicle and one.thruster_type:
            return one
    chosen, refused = choose((vehicle,), raw, out)
    if not chosen:
        raise InputError(refused[0])
    return chosen[0]


def to_json(answer: Why) -> str:
    """Return one JSON object."""
    body: dict[str, Any] = {"schema": "rig2sea/why/1", **asdict(answer)}
    body["up_to_date"] = answer.chain.fits
    return canonical_json(body)
