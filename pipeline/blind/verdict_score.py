"""One verdict against one label: every question of the goals' table as yes, no or does not apply.

The verdict is read from ``diagnosis.json`` as plain JSON, as an outsider would.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pipeline.blind.label import CaseLabel
from pipeline.blind.rates import Goal, Rate, rate
from pipeline.records.base import Record
from pipeline.records.diagnosis import VELOCITIES

#: Effects whose signatures stand at less than 10 degrees cannot be told apart.
SAME_COSINE = math.cos(math.radians(10.0))
#: A gap below this is hardly one: the answer "none", or that of the other effect of a pair, is then
#: no mistake.
HARDLY_A_GAP = 1.15
#: What a regressor of the verdict may be called, by regime of the label.
_REGIME_WORDS = {
    "speed": r"speed|surge|velocity|advance|\bu\b",
    "command": r"command|code|thrust|level",
    "turning": r"turn|yaw|rate|\br\b",
    "depth": r"depth|\bz\b|down",
    "wall": r"wall|bottom",
    "time": r"time",
}


class IntervalScore(Record):
    """One 95 % interval: is the truth in it, half-width over truth, error over half-width."""

    effect: str
    parameter: str
    inside: bool
    half_width_share: float | None
    miss: float | None = None


class CaseScore(Record):
    """A case after its label was opened. None: the question does not apply."""

    case: str
    vehicle: str
    kind: str
    healthy: bool
    missing: tuple[str, ...]
    manoeuvres: str
    gap_ratio: float
    truth: tuple[str, ...]
    verdict: tuple[str, ...]
    ambiguous_with: tuple[str, ...]
    probability: float
    separable: bool | None = None
    first_right: bool | None = None
    abstained: bool
    in_set: bool
    set_size: int
    group_right: bool | None = None
    detail_right: bool | None = None
    pair_exact: bool | None = None
    pair_any: bool | None = None
    smaller_gap: float | None = None
    """Of a pair: what the effect that shows less adds to the other one, over the healthy floor."""
    false_alarm: bool | None = None
    unknown_right: bool | None = None
    called_unknown: bool | None = None
    confidently_wrong: bool
    channel_right: bool | None = None
    regime_right: bool | None = None
    intervals: tuple[IntervalScore, ...] = ()
    after_over_floor: float | None = None
    gap_closed: float | None = None
    elapsed_s: float
    refused: str = ""
    gap_seen: float | None = None
    """Of the worst channel, over the healthy floor, as the diagnosis has it."""
    log_evidence: float | None = None
    """Of the first answer, and of the held-out windows for it."""
    held_out_log_evidence: float | None = None

    @property
    def right_or_abstains(self) -> bool | None:
        """Whether the right effect comes first, or nothing is claimed."""
        return self.first_right or self.abstained


def asked(
    part: Iterable[CaseScore], where: str, *rows: tuple[str, str] | tuple[str, str, Goal]
) -> list[Rate]:
    """Ask a part of the cases: each row a question, the answer's name in a score, and its goal."""
    cases = list(part)
    return [
        rate(question, where, (getattr(one, answer) for one in cases), *goal)
        for question, answer, *goal in rows
    ]


def score_case(
    case: str,
    label: CaseLabel,
    verdict: Mapping[str, Any],
    *,
    elapsed_s: float | None = None,
) -> CaseScore:
    """Score a verdict.

    The content of ``diagnosis.json``, or ``{"refused": reason}`` where the data were called
    hopeless. `elapsed_s` is the time of the diagnosis, that of the verdict otherwise [s].
    """
    refused = str(verdict.get("refused", ""))
    answer = verdict.get("verdict", {})
    effects = tuple(sorted(answer.get("effects", ("refused",))))
    others = tuple(sorted(set(answer.get("ambiguous_with", ())) - set(effects)))
    told = frozenset(effects) | frozenset(others)
    truth = label.truth
    overlap = frozenset(label.overlaps) & told and _tells_time(verdict)
    in_set = frozenset(truth) <= told or bool(overlap)
    abstained = bool(refused) or bool(others) or effects == ("none",)
    small = label.gap_ratio < HARDLY_A_GAP and effects == ("none",)
    small |= bool(label.own_ratios) and frozenset(effects) == frozenset(
        name for name, ratio in label.own_ratios.items() if ratio >= HARDLY_A_GAP
    )
    right = effects == truth or (bool(overlap) and label.kind == "outside")
    values: dict[str, Any] = {}
    if label.kind == "single":
        alike = _alike(truth[0], verdict)
        values["separable"] = not alike
        values["first_right"] = right
        values["group_right"] = frozenset(effects) <= (alike | {truth[0]}) and in_set
        values["called_unknown"] = effects == ("unknown",)
        if right:
            values["detail_right"] = _detail_right(label, answer)
    elif label.kind == "pair":
        values["pair_exact"] = effects == truth
        values["pair_any"] = bool(frozenset(truth) & frozenset(effects))
        values["smaller_gap"] = min(label.own_ratios.values(), default=None)
        values["called_unknown"] = effects == ("unknown",)
    elif label.kind == "none":
        values["false_alarm"] = effects != ("none",) and not refused
    else:
        values["unknown_right"] = right
    if label.kind != "none" and not refused:
        values["channel_right"] = _channel_right(label, verdict)
        values["regime_right"] = _regime_right(label, verdict)
    shrink = verdict.get("shrink", {})
    floor = shrink.get("noise_floor")
    if right and label.kind in ("single", "pair") and floor:
        values["after_over_floor"] = float(shrink["after"]) / float(floor)
        values["gap_closed"] = shrink.get("gap_closed")
    if right and label.kind in ("single", "pair"):
        values["intervals"] = _intervals(label, verdict)
    # an effect too many is as wrong as one too few; some answers to other trouble are as right
    too_many = not overlap and not frozenset(effects) <= frozenset(truth)
    wrong = (not in_set or too_many) and not abstained and not small
    first: Mapping[str, Any] = next(iter(verdict.get("ranking", ())), {})
    return CaseScore(
        case=case,
        vehicle=label.vehicle,
        kind=label.kind,
        healthy=label.healthy_runs > 0,
        missing=label.missing,
        manoeuvres=label.manoeuvres,
        gap_ratio=label.gap_ratio,
        truth=truth if label.kind != "leave_one_out" else (label.effects[0].effect,),
        verdict=effects,
        ambiguous_with=others,
        probability=float(answer.get("probability", 0.0)),
        abstained=abstained,
        in_set=in_set,
        set_size=len(told),
        confidently_wrong=wrong,
        elapsed_s=float(verdict.get("elapsed_s", 0.0)) if elapsed_s is None else elapsed_s,
        refused=refused,
        gap_seen=max((one["ratio"] for one in _channels(verdict).values()), default=None),
        log_evidence=first.get("log_evidence"),
        held_out_log_evidence=first.get("held_out_log_evidence"),
        **values,
    )


def _channels(verdict: Mapping[str, Any]) -> Mapping[str, Any]:
    channels: Mapping[str, Any] = verdict.get("gap", {}).get("channels", {})
    return channels


def _alike(effect: str, verdict: Mapping[str, Any]) -> frozenset[str]:
    """Effects that the runs cannot tell from one, as the diagnosis itself found."""
    out = set()
    for one, other, cosine in verdict.get("confusable", ()):
        if abs(float(cosine)) >= SAME_COSINE and effect in (one, other):
            out.add(other if one == effect else one)
    return frozenset(out)


def _detail_right(label: CaseLabel, answer: Mapping[str, Any]) -> bool | None:
    """Whether the thruster, or one of the axes, is the true one."""
    true = label.effects[0]
    detail = answer.get("detail", {})
    if true.thruster is not None:
        return bool(detail.get("thruster") == true.thruster)
    if true.axes and detail.get("axes"):
        return bool({VELOCITIES[axis] for axis in true.axes} & set(detail["axes"]))
    return None


def _tells_time(verdict: Mapping[str, Any]) -> bool:
    """Whether the verdict tells a time course: stretches of runs that carry the gap."""
    times = verdict.get("gap", {}).get("where", {}).get("times", ())
    return bool(times)


def _channel_right(label: CaseLabel, verdict: Mapping[str, Any]) -> bool | None:
    """Whether a channel that is named carries at least half of the gap of the worst one."""
    named = set(verdict.get("gap", {}).get("where", {}).get("channels", ()))
    size = {name: math.sqrt(max(r * r - 1.0, 0.0)) for name, r in label.channel_ratios.items()}
    worst = max(size.values(), default=0.0)
    if worst < 1.0:
        return None
    return bool(named & {name for name, value in size.items() if value >= 0.5 * worst})


def _regime_right(label: CaseLabel, verdict: Mapping[str, Any]) -> bool | None:
    """Whether one of the first two regimes that are named is one with which the true gap goes."""
    strength = {name: abs(value) for name, value in label.regimes.items()}
    most = max(strength.values(), default=0.0)
    if most < 0.3 or label.gap_ratio < 1.5:
        return None
    good = [name for name, value in strength.items() if value >= 0.6 * most]
    regimes: Sequence[Mapping[str, Any]] = (
        verdict.get("gap", {}).get("where", {}).get("regimes", ())
    )
    return any(
        re.search(_REGIME_WORDS[name], str(one.get("regressor", "")), re.IGNORECASE)
        for one in regimes[:2]
        for name in good
    )


def _intervals(label: CaseLabel, verdict: Mapping[str, Any]) -> tuple[IntervalScore, ...]:
    """Intervals of the true effects' parameters in the ranking's entry that names them."""
    wanted = {one.effect for one in label.effects}
    rows = [
        row for row in verdict.get("ranking", ()) if set(str(row["effect"]).split("+")) == wanted
    ]
    if not rows:
        return ()
    out = []
    for true in label.effects:
        for name, value in true.parameters.items():
            found = rows[0]["parameters"].get(name) or rows[0]["parameters"].get(
                f"{true.effect}.{name}"
            )
            if not found or not found.get("ci95"):
                continue
            low, high = (float(edge) for edge in found["ci95"])
            out.append(
                IntervalScore(
                    effect=true.effect,
                    parameter=name,
                    inside=low <= value <= high,
                    half_width_share=0.5 * (high - low) / abs(value) if value else None,
                    miss=abs(value - 0.5 * (low + high)) / max(0.5 * (high - low), 1e-12),
                )
            )
    return tuple(out)
