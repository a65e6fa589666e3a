"""What was asked of the gains of runs, and how a finding is said."""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.records.gains import FindingKind


@dataclass(frozen=True)
class GainQuestion:
    """One comparison: what would be found, in which runs, and how unlikely it is by chance."""

    kind: FindingKind
    p: float
    runs: tuple[str, ...]
    thrusters: tuple[str, ...] = ()
    axis: str | None = None
    value: float | None = None
    ci95: tuple[float, float] | None = None
    expected: float | None = None
    against: str = ""


def sentence(one: GainQuestion, runs: Sequence[str]) -> str:
    """Say what was found, in which runs, and what to look at.

    Parameters
    ----------
    one : GainQuestion
        The clearest of the comparisons that it rests on.
    runs : sequence of str
        All runs that show it.
    """
    figure = ""
    if one.value is not None and one.ci95 is not None:
        low, high = one.ci95
        figure = f"{one.value:.2f} [{low:.2f}, {high:.2f}]"
    expected = "" if one.expected is None else f"{one.expected:.2f}"
    names, where, against = " and ".join(one.thrusters), _where(runs), one.against
    value = "" if one.value is None else f"{one.value:.2f}"
    said = {
        "dead": f"{names} gives nothing: {figure} of what the vehicle file says, {where}.",
        "reversed": f"{names} pushes the other way: {figure} of what the file says, {where}.",
        "weak": f"{names} gives less than expected: {figure} of what the vehicle file says, "
        f"where {against} let expect {expected}, {where}.",
        "strong": f"{names} gives more than expected: {figure} of what the vehicle file says, "
        f"where {against} let expect {expected}, {where}.",
        "swapped": f"{names} look exchanged: each moves the vehicle as the other should, {where}. "
        "Check the order of the commands and the wiring.",
        "axis_reversed": f"{one.axis}: what was measured goes against every thruster, {where}. "
        "Check the sign and the axes of the sensor, then the directions of the thrusters.",
        "coupled": f"{names} moves {one.axis}, which by its place and direction it cannot: "
        f"{figure} of a typical thruster there, {where}.",
        "heading_reversed": f"the heading counts the other way: its rate goes against {against} "
        f"(correlation {value}), {where}. Check the sign of the heading, and of what it goes "
        "against.",
        "common_scale": f"all thrusters give {figure} of what they gave in {against}, alike, "
        f"{where}: no single thruster's fault. Look at the supply, the pilot's gain, the mass.",
    }
    return said[one.kind]


def _where(runs: Sequence[str]) -> str:
    if len(runs) == 1:
        return f"in {runs[0]}"
    if len(runs) <= 3:
        return f"in {', '.join(runs)}"
    return f"in {len(runs)} runs ({', '.join(runs[:2])}, ...)"
