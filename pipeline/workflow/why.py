"""``rig2sea why``: a number of the tables, and the chain of files that it came from."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Place
from pipeline.inputs.vehicle_changes import changes_of
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import VEHICLE_FILE, UsageError, VehicleFolder, choose, discover, processed_file
from pipeline.provenance import UNREADABLE, canonical_json, file_digest, read_envelope, read_tables
from pipeline.records.base import AppliedChange
from pipeline.records.measurements import MooringRecord
from pipeline.vehicle.bench_schema import is_at_supply
from pipeline.vehicle.change_list import value_at
from pipeline.vehicle.estimates import Estimate, estimates_of
from pipeline.vehicle.load import load_checked, load_vehicle
from pipeline.vehicle.schema import Vehicle
from pipeline.workflow.cell import Cell, find_cell
from pipeline.workflow.lineage import Link, Raw, lineage
from pipeline.workflow.vehicle_places import with_types

_SIGNS = {"positive": 1, "negative": -1}

#: Sections of a vehicle file that a path may begin with.
_SECTIONS = frozenset({"water", "propellers", "drives", "thrusters", "model", "sensors"})

_DIGITS = 12


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

    Raises
    ------
    UsageError
        When there is no such number.
    InputError
        When the file or its list of changes cannot be read.
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


def stated_text(found: StatedNumber) -> str:
    """Return what is printed."""
    lines = [f"{found.path} = {found.value} in {found.file}"]
    own, change = found.estimate, found.change
    if own is not None and own.ci95 is not None:
        lines.append(f"  95 % interval: {own.ci95[0]:.6g} to {own.ci95[1]:.6g}")
    if own is not None and own.source:
        lines.append(f"  from: {own.source}")
    if change is None:
        lines.append("  no change of the list wrote it: it is the engineer's, or a default")
        return "\n".join(lines)
    before = next(one for one in change.changes if one.path == found.path)
    lines.append(f"  before: {before.old}; changed {change.date_utc} UTC by rig2sea apply")
    same = found.source_now == change.source_sha256
    state = "as it was read" if same else "CHANGED since, or gone"
    lines.append(f"  {change.source}: sha256 {change.source_sha256[:_DIGITS]}, {state}")
    lines.append(f"  runs: {', '.join(change.runs)}")
    was = change.before_sha256[:_DIGITS]
    lines.append(f"  {change.former}: the file of before, sha256 {was}")
    return "\n".join(lines)


@dataclass(frozen=True)
class Why:
    """A number and its chain; of Table 3 the sound points that it has no use for, too."""

    vehicle: str
    cell: Cell
    chain: Link
    spare: SparePoints | None = None


def why(vehicle: str, words: Sequence[str], raw: Path, out: Path) -> Why:
    """Find a number of a vehicle's tables and follow it back.

    Raises
    ------
    UsageError
        When there is no such vehicle or number.
    InputError
        When there are no tables yet, or a file of the chain is broken.
    """
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


def as_text(answer: Why) -> str:
    """Return what is printed: the number, then a line a file, each under what it made."""
    lines = [*_head(answer.cell, answer.spare), "", *_chain(answer.chain, 0)]
    described = {one.path: one for one in _every_raw(answer.chain) if _is_vehicle_file(one)}
    lines += [f"{_raw_line(one)}, read at every step" for one in described.values()]
    lines.append("")
    if answer.chain.fits:
        lines.append("Every file of the chain fits those before it.")
    else:
        lines.append("The number does not fit its inputs any more. To renew it: rig2sea run")
    return "\n".join(lines)


def _head(cell: Cell, spare: SparePoints | None) -> Iterator[str]:
    at = "" if cell.speed_mps is None else f" at {cell.speed_mps:g} m/s"
    own = f" {cell.unit}" if cell.unit else ""
    yield f"{cell.path}{at} = {cell.value!r}{own}"
    if cell.interval is not None:
        yield f"  95 % interval: {cell.interval[0]:.6g} to {cell.interval[1]:.6g}{own}"
    if cell.printed is not None:
        yield f"  published: {cell.printed:g}{own}"
    if cell.table == "table4":
        yield "  not fitted to measurements: it inverts the static family T(N, V)"
    if cell.fit is not None:
        unit = f" {cell.fit['unit']}" if cell.fit["unit"] not in {"", "1"} else ""
        out = len(cell.fit["outliers"])
        yield (
            f"  fitted to {cell.fit['points']} points, {out} left out by the fit, "
            f"residual {cell.fit['residual_std']:.3g}{unit}"
        )
    if spare is not None and spare.dead:
        yield (
            f"  not fitted: {spare.dead} of the dead thrust of {spare.thrust_dead_n:g} N or less "
            "(tables.thrust_dead_n)"
        )
    if spare is not None and spare.other_supply:
        yield f"  not fitted: {spare.other_supply} at another supply voltage"


def _chain(link: Link, depth: int) -> Iterator[str]:
    margin = "  " * depth
    state = "up to date" if not link.stale else f"STALE: {'; '.join(link.stale)}"
    yield (
        f"{margin}{link.path}: {link.title}; sha256 {link.sha256[:_DIGITS]}, made "
        f"{link.made_utc} UTC by rig2sea {link.version}, code {link.code}; {state}"
    )
    if link.why_not is not None:
        yield f"{margin}  left out: {link.why_not}"
    for one in link.raw:
        if _is_vehicle_file(one):
            continue
        yield f"{margin}  {_raw_line(one)}"
        for part in one.read:
            sheet = f'sheet "{part.sheet}": ' if part.sheet is not None else ""
            read = f"{part.points} points, {part.left_out} of them left out when read"
            yield f"{margin}    {sheet}{read}"
    for before in link.inputs:
        yield from _chain(before, depth + 1)


def _raw_line(one: Raw) -> str:
    state = "as it was read" if one.fits else "CHANGED since, or gone"
    return f"{one.path}: sha256 {one.sha256[:_DIGITS]}, {state}"


def _is_vehicle_file(one: Raw) -> bool:
    return Path(one.path).name == VEHICLE_FILE


def _every_raw(link: Link) -> Iterator[Raw]:
    yield from link.raw
    for before in link.inputs:
        yield from _every_raw(before)
