"""The verdict on a mooring table in a sentence, and what to measure next."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.bench.answer import Ranked
from pipeline.diagnose.bench.model import ThrusterAtRest
from pipeline.diagnose.bench.noise import SCALE
from pipeline.diagnose.bench.table import BenchTable
from pipeline.records.diagnosis import NextRun, Shrink

_PERCENT = 100.0


def sentence(
    model: ThrusterAtRest,
    best: Ranked,
    members: Sequence[str],
    probability: float,
    shrunk: Shrink,
) -> str:
    """Say the answer in one sentence or two."""
    sure = f"{min(probability, 0.999):.3g}"
    if members:
        sure = f"{sure} together with its look-alikes"
    listed = ", ".join(members)
    also = f" This table cannot tell it from {listed}." if members else ""
    if best.name == "none":
        return (
            f"The table agrees with the thruster model of {model.name} within what a healthy "
            f"thruster may differ by (probability {sure})."
            + (f" Too small to be seen here, if present: {listed}." if members else "")
        )
    if best.name == "unknown":
        return (
            f"The table departs from the thruster model of {model.name} in a way that no effect "
            f"of the library explains (probability {sure}).{also}"
        )
    said = "; ".join(_described(best, effect) for effect in best.fit.effects)
    closes = (
        ""
        if shrunk.gap_closed is None
        else f"; it closes {_share(shrunk.gap_closed)} of the gap at {shrunk.held_out}"
    )
    return f"The cause is {said} (probability {sure}){closes}.{also}"


def _share(closed: float) -> str:
    return "all" if closed >= 0.995 else f"{_PERCENT * closed:.0f} %"


def _described(best: Ranked, effect: str) -> str:
    values = {name: value for (owner, name), value in best.fit.values.items() if owner == effect}
    if effect == "dead_zone":
        return f"dead_zone: {values['codes']:.3g} codes more than stated give no thrust"
    if effect == "reverse_thrust":
        return f"reverse_thrust: astern the thrust is {values['fraction']:.3g} of the stated one"
    if effect == "voltage_sag":
        drop, load = values["drop"], values["load_drop"]
        full = drop + load
        text = f"voltage_sag: the drive gets {_share_off(drop)} % {_way(drop)} than its supply"
        if load > 0.005:
            text += f", at full code {_share_off(full)} % {_way(full)}"
        return text
    share = values.get("thrust_fraction", 1.0 - values.get("t", 0.0))
    return f"{effect}: the thrust is {share:.3g} of the stated one at all codes"


def _share_off(missing: float) -> str:
    return f"{_PERCENT * abs(missing):.3g}"


def _way(missing: float) -> str:
    return "more" if missing < 0.0 else "less"


def next_step(
    table: BenchTable, ranking: Sequence[Ranked], members: Sequence[str]
) -> NextRun | None:
    """Measurement that separates the first answer from another best; None where nothing would.

    The separation is the difference that the two predict over the standard deviation of the
    instrument, at the largest code.
    """
    group = {*ranking[0].fit.effects, *members}
    weak = group & {"thruster_degraded", "thrust_deduction", "reverse_thrust", "dead_zone"}
    if "voltage_sag" in group and weak and "voltage" not in table.channels:
        missing = sum(_fitted(ranking, "voltage_sag", name) for name in ("drop", "load_drop"))
        other = "thruster_degraded" if "thruster_degraded" in weak else min(weak)
        return NextRun(
            manoeuvre="the same codes again, with the supply voltage measured at the drive",
            separates=("voltage_sag", other),
            expected_separation_sigma=abs(missing) / SCALE["voltage"],
        )
    if {"thruster_degraded", "thrust_deduction"} <= group and ranking[0].name != "none":
        share = _fitted(ranking, "thruster_degraded", "thrust_fraction")
        return NextRun(
            manoeuvre="the same codes with the thruster taken out of the hull, or with another one",
            separates=("thruster_degraded", "thrust_deduction"),
            expected_separation_sigma=abs(1.0 - share) / (np.sqrt(2.0) * SCALE["thrust"]),
        )
    return None


def _fitted(ranking: Sequence[Ranked], effect: str, parameter: str) -> float:
    """Value in the most probable answer that has the effect: every one is ranked."""
    key = (effect, parameter)
    return next(one.fit.values[key] for one in ranking if key in one.fit.values)
