"""``rig2sea apply``."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW
from pipeline.commands.common.say import print_json, say
from pipeline.language import translate

if TYPE_CHECKING:
    from pipeline.records.base import AppliedChange, FileChange
    from pipeline.workflow.apply import ChangeProposal, Codes


@click.command()
@click.argument("vehicle")
@click.argument("source", required=False, metavar="[DIAGNOSIS | IDENTIFICATION | DAY | RUN]")
@click.option("--yes", is_flag=True, help="Write without asking.")
@click.option("--undo", is_flag=True, help="Undo the last change.")
@AS_JSON
@RAW
@OUT
def apply(
    *, vehicle: str, source: str | None, yes: bool, undo: bool, as_json: bool, raw: Path, out: Path
) -> None:
    r"""Write what was found into vehicle.yaml, after showing what changes.

    The second argument is "diagnosis" or "identification" (the last one of the vehicle), the path
    of a diagnosis.json or identification.json or of its folder, the name of a diagnosis under
    reports/, a trial day or a pool run. Shown are values before and after with their interval, the
    codes of thrusters that change, and the errors on held-out data. Comments and layout of the file
    stay; the former file is kept beside it. With --json nothing is written unless --yes is given
    too.

    \b
    Examples:
      rig2sea apply mmt300 diagnosis
      rig2sea apply myauv 2024-05-15 --yes
      rig2sea apply myauv --undo
    """
    from pipeline.workflow import apply as work

    if undo == (source is not None):
        raise click.UsageError(
            "Give what was found (diagnosis, identification, a trial day, a run or a file), or "
            "--undo."
        )
    if undo:
        file, entry = work.undo(vehicle, raw, out)
        if as_json:
            print_json({"undone": entry.model_dump(mode="json")})
            return
        say(f"{file} is as it was before {entry.date_utc} UTC ({entry.reason}).")
        return
    assert source is not None  # noqa: S101 - refused above
    proposal = work.propose(vehicle, source, raw, out)
    if as_json:
        written = work.apply(proposal, out) if yes else None
        print_json(as_json_object(proposal, written))
        return
    say(as_text(proposal))
    if not yes and not click.confirm(translate(f"Write this into {proposal.file}?")):
        say("Nothing was written.")
        return
    entry = work.apply(proposal, out)
    say(f"written: {proposal.file}; the former one: {entry.former}")
    say(f"To bring tables, allocator and firmware up to date: rig2sea run {vehicle}")


def as_json_object(proposal: "ChangeProposal", entry: "AppliedChange | None") -> dict[str, Any]:
    """Return one JSON object; `applied` is null where nothing was written."""
    found = proposal.found
    return {
        "schema": "rig2sea/apply/1",
        "vehicle": proposal.vehicle,
        "file": str(proposal.file),
        "source": str(found.source),
        "reason": found.reason,
        "runs": list(found.runs),
        "changes": [one.model_dump(mode="json") for one in found.changes],
        "held_out": {name: {"before": a, "after": b} for name, (a, b) in found.gap.items()},
        "codes": [asdict(one) for one in proposal.codes],
        "codes_stay": list(proposal.unchanged),
        "why_no_codes": proposal.why_no_codes,
        "applied": None if entry is None else entry.model_dump(mode="json"),
    }


def as_text(proposal: "ChangeProposal") -> str:
    """Say what would change."""
    found = proposal.found
    lines = [f"{proposal.file}, from {found.source} ({found.reason}):", ""]
    lines += [f"  {change_line(one)}" for one in found.changes]
    if found.gap:
        lines += ["", "Held out, before and after:"]
        lines += [f"  {name}: {a:.4g} -> {b:.4g}" for name, (a, b) in found.gap.items()]
    lines.append("")
    if proposal.why_no_codes:
        lines.append(f"Codes are not shown: {proposal.why_no_codes}")
    elif not proposal.codes:
        lines.append("The codes of all thrusters stay.")
    else:
        lines += list(_code_lines(proposal.codes))
        if proposal.unchanged:
            lines.append(f"The codes of {', '.join(proposal.unchanged)} stay.")
    return "\n".join(lines)


def change_line(one: "FileChange") -> str:
    """Say one change.

    >>> from pipeline.records.base import FileChange
    >>> change_line(FileChange(path="a.b", old=1.0, value=0.69, ci95=(0.63, 0.76)))
    'a.b: 1 -> 0.69 [0.63, 0.76]'
    """
    old, new = (_short(value) for value in (one.old, one.value))
    interval = f" [{one.ci95[0]:.4g}, {one.ci95[1]:.4g}]" if one.ci95 else ""
    return f"{one.path}: {old} -> {new}{interval}"


def _short(value: object) -> str:
    if value is None:
        return "not stated"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _code_lines(codes: "Sequence[Codes]") -> list[str]:
    lines = ["Codes before -> after, by thrust [N] and speed along the thruster [m/s]:"]
    for one in codes:
        if one.speed_mps == codes[0].speed_mps:
            head = "".join(f"{thrust:>11.1f}" for thrust in one.thrust_n)
            lines.append(f"  {one.thruster:<10}{head}")
        row = "".join(f"{f'{a}->{b}':>11}" for a, b in zip(one.old, one.new, strict=True))
        lines.append(f"  {one.speed_mps:>10g}{row}")
    return lines
