"""``rig2sea why``."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW
from pipeline.commands.common.say import print_json, say
from pipeline.language import translate

if TYPE_CHECKING:
    from pipeline.workflow.cell import Cell
    from pipeline.workflow.why import Link, Raw, SparePoints, StatedNumber, Why


@click.command()
@click.argument("vehicle")
@click.argument("cell", nargs=-1, required=True, metavar="CELL...")
@AS_JSON
@RAW
@OUT
def why(vehicle: str, cell: tuple[str, ...], as_json: bool, raw: Path, out: Path) -> None:
    r"""Show where a number came from, back to the sheets of the raw files or to a finding.

    CELL is a path as in tables.json, or table, coefficient and speed in m/s (Tables 2 and 4) or
    number of the coefficient (Tables 1 and 3, from 0). Every file of the chain is shown with its
    digest, the version and code that made it, and whether it still fits what it was made from. A
    path of vehicle.yaml shows the interval of its number and the finding that apply wrote it from.

    \b
    Examples:
      rig2sea why mmt300 table4.KN1[2]
      rig2sea why mmt300 table2 1.5 KF1
      rig2sea why mmt300 table3 positive 1 --json
      rig2sea why mmt300 thrusters.upper.gain_ahead
    """
    from pipeline.workflow.why import to_json, why_stated
    from pipeline.workflow.why import why as find

    stated = why_stated(vehicle, cell, raw, out)
    if stated is not None:
        shown = {**asdict(stated), "schema": "rig2sea/why/1", "file": str(stated.file)}
        if stated.change is not None:
            shown["change"] = stated.change.model_dump(mode="json")
        if as_json:
            print_json(shown)
        else:
            say(stated_text(stated))
        return
    answer = find(vehicle, cell, raw, out)
    click.echo(to_json(answer) if as_json else translate(as_text(answer)))


_DIGITS = 12


def stated_text(found: "StatedNumber") -> str:
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


def as_text(answer: "Why") -> str:
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


def _head(cell: "Cell", spare: "SparePoints | None") -> Iterator[str]:
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


def _chain(link: "Link", depth: int) -> Iterator[str]:
    margin = "  " * depth
    state = "up to date" if not link.stale else f"STALE: {'; '.join(link.stale)}"
    yield (
        f"{margin}{link.path}: {link.title}; sha256 {link.sha256[:_DIGITS]}, made "
        f"{link.made_utc} UTC by rig2sea {link.version}, code {link.code}; {state}"
    )
    if link.why_not is not None:
        yield f"{margin}  left out: {link.why_not}"
    for one in (raw for raw in link.raw if not _is_vehicle_file(raw)):
        yield f"{margin}  {_raw_line(one)}"
        for part in one.read:
            sheet = f'sheet "{part.sheet}": ' if part.sheet is not None else ""
            read = f"{part.points} points, {part.left_out} of them left out when read"
            yield f"{margin}    {sheet}{read}"
    for before in link.inputs:
        yield from _chain(before, depth + 1)


def _raw_line(one: "Raw") -> str:
    state = "as it was read" if one.fits else "CHANGED since, or gone"
    return f"{one.path}: sha256 {one.sha256[:_DIGITS]}, {state}"


def _is_vehicle_file(one: "Raw") -> bool:
    return Path(one.path).name == "vehicle.yaml"


def _every_raw(link: "Link") -> "Iterator[Raw]":
    yield from link.raw
    for before in link.inputs:
        yield from _every_raw(before)
