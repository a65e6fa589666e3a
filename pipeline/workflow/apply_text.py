"""What applying a result would change, as text and as JSON."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from pipeline.records.base import AppliedChange, FileChange
from pipeline.workflow.apply import ChangeProposal, Codes


def as_json(proposal: ChangeProposal, entry: AppliedChange | None) -> dict[str, Any]:
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


def as_text(proposal: ChangeProposal) -> str:
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


def change_line(one: FileChange) -> str:
    """Say one change.

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


def _code_lines(codes: Sequence[Codes]) -> list[str]:
    lines = ["Codes before -> after, by thrust [N] and speed along the thruster [m/s]:"]
    for one in codes:
        if one.speed_mps == codes[0].speed_mps:
            head = "".join(f"{thrust:>11.1f}" for thrust in one.thrust_n)
            lines.append(f"  {one.thruster:<10}{head}")
        row = "".join(f"{f'{a}->{b}':>11}" for a, b in zip(one.old, one.new, strict=True))
        lines.append(f"  {one.speed_mps:>10g}{row}")
    return lines
