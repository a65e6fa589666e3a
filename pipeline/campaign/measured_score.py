"""What the measured blind check is judged by: every case a line, and rates against the goals."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pipeline.blind.rates import Goal, Rate, at_least, at_most, between, rate
from pipeline.blind.score import Score, confusion
from pipeline.blind.verdict_score import CaseScore
from pipeline.records.base import Record

#: From so many floors an effect is to be named. [1]
CLEAR = 3.0
#: A thrust that differs alike for all thrusters may be told of a run as it is: it does differ.
COMMON_THRUST = frozenset({"thrust_deduction", "voltage_sag"})


class MeasuredLine(Record):
    """A case that is over: what was done, and how the answer was.

    `size` and `channel_sizes` are in measured floors, `share` is the part of the effect that stands
    in the logs.
    """

    number: int
    subject: str
    kind: str
    runs: tuple[str, ...]
    healthy: tuple[str, ...]
    effect: str | None
    thruster: str | None
    parameters: dict[str, float]
    size: float
    wanted: float
    channel_sizes: dict[str, float]
    share: float
    told_thruster: str | None
    score: CaseScore

    @property
    def first(self) -> bool:
        """Whether effect and thruster are named, with a probability of a half or more."""
        return bool(
            self.score.verdict == self.score.truth
            and self.score.probability >= 0.5
            and self.told_thruster == self.thruster
        )

    @property
    def named(self) -> bool:
        """Whether effect and thruster are named, perhaps beside what nothing explains."""
        truth, verdict = set(self.score.truth), set(self.score.verdict)
        there = truth <= verdict <= {*truth, "unknown"}
        return there and self.score.probability >= 0.5 and self.told_thruster == self.thruster

    @property
    def in_set(self) -> bool:
        """Whether the answer holds the effect, first or beside it."""
        alone = len(self.score.verdict) == 1 and not self.score.ambiguous_with
        other = alone and self.told_thruster != self.thruster and self.thruster is not None
        return self.score.in_set and not other

    @property
    def surely_wrong(self) -> bool:
        """Whether another effect, another thruster, or too many are named without a doubt."""
        sure = not self.score.abstained and self.score.verdict != ("unknown",)
        wrong = self.score.confidently_wrong or not self.in_set
        return sure and wrong and not self.named

    @property
    def sure_effect(self) -> bool:
        """Whether an effect is named without a doubt that is no common scale of the thrust."""
        named = set(self.score.verdict) - {"none", "unknown", "refused"}
        sure = not self.score.abstained and "unknown" not in self.score.verdict
        return sure and bool(named - COMMON_THRUST)


def measured_lines(lines: Iterable[Mapping[str, Any]]) -> list[MeasuredLine]:
    """Read the lines of a campaign's file that have a score."""
    return [MeasuredLine.model_validate_json(json.dumps(line)) for line in lines]


def score_measured(lines: Sequence[MeasuredLine]) -> Score:
    """Put the lines of a campaign together."""
    put = [line for line in lines if line.kind != "none"]
    calm = [line for line in lines if line.kind == "none"]
    dead = [line for line in put if line.kind == "dead" and line.size == 0.0]
    weak = [line for line in put if line.effect == "thruster_degraded" and line.size >= CLEAR]
    other = [line for line in put if line.effect != "thruster_degraded" and line.size >= CLEAR]
    covered = [one.inside for line in put for one in line.score.intervals]
    of_weak, of_other = (
        f"{what}, {CLEAR:g} floors or more" for what in ("a thruster weak", "another effect")
    )
    in_set, wrong, as_flown = "truth in the answer set", "surely wrong", "runs as they are"
    answered = "answered, neither refused nor a fault of the program"
    calm_goal, whole = Goal("0", high=0.0), Goal("100 %", low=1.0)
    asked = (
        ("thruster first, 0.5 or more", of_weak, (one.first for one in weak), at_least(0.90)),
        (in_set, of_weak, (one.in_set for one in weak), at_least(0.98)),
        ("effect first, 0.5 or more", of_other, (one.first for one in other), at_least(0.70)),
        (in_set, of_other, (one.in_set for one in other), at_least(0.95)),
        (wrong, "all effects put in", (one.surely_wrong for one in put), at_most(0.02)),
        ("a sure effect", as_flown, (one.sure_effect for one in calm), calm_goal),
        ("95 % intervals cover the size", "right answers", covered, between(0.90, 0.98)),
        (answered, "all cases", (not one.score.refused for one in lines), whole),
        ("named", "a thruster commanded and without effect", (one.named for one in dead), whole),
    )
    return Score(
        cases=len(lines),
        refused=sum(bool(line.score.refused) for line in lines),
        goals=tuple(rate(*question) for question in asked),
        rates=tuple(_rates(put, calm)),
        confusion=confusion([line.score for line in lines], lambda one: "+".join(one.verdict)),
    )


def _rates(put: Sequence[MeasuredLine], calm: Sequence[MeasuredLine]) -> Iterable[Rate]:
    for name, low, high in (
        ("below 1.5", 0.0, 1.5),
        ("1.5 to 3", 1.5, 3.0),
        ("3 or more", 3.0, 1e9),
    ):
        part = [line for line in put if low <= line.size < high and line.kind != "dead"]
        for word, own in (
            ("a thruster weak", [one for one in part if one.effect == "thruster_degraded"]),
            ("another effect", [one for one in part if one.effect != "thruster_degraded"]),
        ):
            stratum = f"{word}, {name} floors"
            yield rate("first, 0.5 or more", stratum, (line.first for line in own))
            yield rate("truth in the answer set", stratum, (line.in_set for line in own))
            yield rate("surely wrong", stratum, (line.surely_wrong for line in own))
    for subject in sorted({line.subject for line in (*put, *calm)}):
        own = [line for line in put if line.subject == subject]
        yield rate("first, 0.5 or more", subject, (line.first for line in own))
        yield rate("truth in the answer set", subject, (line.in_set for line in own))
    yield rate("none", "runs as they are", (one.score.verdict == ("none",) for one in calm))
    yield rate("unknown", "runs as they are", ("unknown" in one.score.verdict for one in calm))
