"""The result file of the measured cases as a table in Markdown."""

from collections.abc import Sequence
from typing import Any

_BEGIN, _END = "<!-- the table -->", "<!-- end of the table -->"
_HEAD = (
    "| vehicle, run | withheld | healthy runs | verdict | probability | rank of the truth | value "
    "found (95 %) | gap before, after | s |\n|---|---|---|---|---|---|---|---|---|"
)


def table(lines: Sequence[dict[str, Any]], planned: int | None = None) -> str:
    """Write a row for each case, and how many named the truth.

    Parameters
    ----------
    lines : sequence of dict
        As `line_of` makes them.
    planned : int, optional
        How many cases there are in all.
    """
    rows = [_HEAD, *(_row(line) for line in lines)]
    if planned is not None and len(lines) < planned:
        rows = [f"{len(lines)} of {planned} cases were run.", "", *rows]
    return "\n".join([*rows, "", *_sums(lines)]) + "\n"


def with_table(page: str, text: str) -> str:
    """Put the table between its marks on a page.

    Raises
    ------
    ValueError
        When the page has no such marks.
    """
    before, _, rest = page.partition(_BEGIN)
    _, mark, after = rest.partition(_END)
    if not mark:
        raise ValueError(f"the page has no place for a table: {_BEGIN} ... {_END}")
    return f"{before}{_BEGIN}\n{text}{_END}{after}"


def outcome(line: dict[str, Any]) -> str:
    """Say what came of a case: right, right group, other, abstained or refused."""
    if "refused" in line:
        return "refused"
    if ran_away(line):
        return "ran away"
    verdict = line["verdict"]
    wanted = "none" if line["truth"] is None else line["truth"]
    if wanted in verdict["effects"]:
        thruster = verdict["detail"]["thruster"]
        alone = len(verdict["effects"]) == 1
        if line["thruster"] not in (None, thruster) and alone:
            return "right effect, other thruster"
        return "right" if alone else "right among others"
    if wanted in verdict["ambiguous_with"]:
        return "in the group"
    return "unknown" if verdict["effects"] == ["unknown"] else "other"


def ran_away(line: dict[str, Any]) -> bool:
    """Tell a verdict that rests on nothing: no channel had a residual that is a number."""
    return bool(line.get("noise")) and max(line["noise"].values()) == 0.0


def _row(line: dict[str, Any]) -> str:
    place = f"{line['subject']} {line['fold']}"
    what = line["injected"] + (f", without {', '.join(line['hidden'])}" if line["hidden"] else "")
    healthy = "yes" if line["healthy"] else "no"
    if "refused" in line:
        told = line["refused"].splitlines()[0].replace("|", "/")
        return f"| {place} | {what} | {healthy} | refused: {told} | | | | | {_s(line)} |"
    shrink = line["shrink"]
    return (
        f"| {place} | {what} | {healthy} | {_verdict(line)} | {line['verdict']['probability']:.2f} "
        f"| {line['rank'] or '-'} | {_value(line)} | {shrink['before']:.2f}, "
        f"{shrink['after']:.2f} | {_s(line)} |"
    )


def _s(line: dict[str, Any]) -> str:
    return f"{line['elapsed_s']:.0f}"


def _verdict(line: dict[str, Any]) -> str:
    verdict = line["verdict"]
    text = " + ".join(f"`{name}`" for name in verdict["effects"])
    if verdict["detail"]["thruster"]:
        text += f" {verdict['detail']['thruster']}"
    if verdict["ambiguous_with"]:
        text += " or " + ", ".join(f"`{name}`" for name in verdict["ambiguous_with"])
    if ran_away(line):
        text += " (on nothing: the simulation ran away)"
    return text


def _value(line: dict[str, Any]) -> str:
    found = line["found"]
    if found is None or not line["value"]:
        return "-"
    parts = []
    for name, true in line["value"].items():
        # beside another effect a parameter has the effect's name before its own
        given = found["parameters"]
        one = given.get(name, given.get(f"{line['truth']}.{name}"))
        if one is None:
            parts.append(f"{name} not freed (true {true:g})")
            continue
        low, high = one["ci95"]
        parts.append(f"{name} {one['value']:.3g} ({low:.3g} to {high:.3g}; true {true:g})")
    return ", ".join(parts)


def _sums(lines: Sequence[dict[str, Any]]) -> list[str]:
    found = []
    for name, wanted in (("Injected", True), ("As they are", False)):
        own = [outcome(line) for line in lines if (line["truth"] is not None) == wanted]
        counts = ", ".join(f"{kind} {own.count(kind)}" for kind in dict.fromkeys(sorted(own)))
        if own:
            found.append(f"{name}, {len(own)} cases: {counts}.")
    return found
