"""``rig2sea why``: a number of the tables, and the chain of files that it came from."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Place
from pipeline.plan import VEHICLE_FILE, VehicleFolder, choose, discover, processed_file
from pipeline.provenance import canonical_json, read_tables
from pipeline.workflow.cell import Cell, find_cell
from pipeline.workflow.lineage import Link, Raw, lineage
from pipeline.workflow.spare_points import SparePoints, spare_points
from pipeline.workflow.thruster_types import with_types

_DIGITS = 12


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
