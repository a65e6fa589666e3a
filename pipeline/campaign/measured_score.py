"""What the measured blind check is judged by: every case a line, and rates against the goals."""

from collections.abc import Iterable, Sequence

from pipeline.blind.goals import at_least, at_most, between
from pipeline.blind.rates import Rate, rate
from pipeline.blind.score import Confusion, confusion
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
    def in_set(self) -> bool:
        """Whether the answer holds the effect, first or beside it."""
        alone = len(self.score.verdict) == 1 and not self.score.ambiguous_with
        other = alone and self.told_thruster != self.thruster and self.thruster is not None
        return self.score.in_set and not other

    @property
    def surely_wrong(self) -> bool:
        """Whether another effect, another thruster, or too many are named without a doubt."""
        sure = not self.score.abstained and self.score.verdict != ("unknown",)
        return sure and (self.score.confidently_wrong or not self.in_set)

    @property
    def sure_effect(self) -> bool:
        """Whether an effect is named without a doubt that is no common scale of the thrust."""
        named = set(self.score.verdict) - {"none", "unknown", "refused"}
        sure = not self.score.abstained and "unknown" not in self.score.verdict
        return sure and bool(named - COMMON_THRUST)


class MeasuredScore(Record):
    """The result of a measured blind check."""

    cases: int
    refused: int
    goals: tuple[Rate, ...]
    rates: tuple[Rate, ...]
    confusion: Confusion


def score_measured(lines: Sequence[MeasuredLine]) -> MeasuredScore:
    """Put the lines of a campaign together."""
    put = [line for line in lines if line.kind != "none"]
    calm = [line for line in lines if line.kind == "none"]
    dead = [line for line in put if line.kind == "dead" and line.size == 0.0]
    weak = [line for line in put if line.effect == "thruster_degraded" and line.size >= CLEAR]
    other = [line for line in put if line.effect != "thruster_degraded" and line.size >= CLEAR]
    covered = [one.inside for line in put for one in line.score.intervals]
    goals = (
        rate(
            "thruster first, 0.5 or more",
            f"a thruster weak, {CLEAR:g} floors or more",
            (line.first for line in weak),
            ">= 90 %",
            at_least(0.90),
        ),
        rate(
            "truth in the answer set",
            f"a thruster weak, {CLEAR:g} floors or more",
            (line.in_set for line in weak),
            ">= 98 %",
            at_least(0.98),
        ),
        rate(
            "effect first, 0.5 or more",
            f"another effect, {CLEAR:g} floors or more",
            (line.first for line in other),
            ">= 70 %",
            at_least(0.70),
        ),
        rate(
            "truth in the answer set",
            f"another effect, {CLEAR:g} floors or more",
            (line.in_set for line in other),
            ">= 95 %",
            at_least(0.95),
        ),
        rate(
            "surely wrong",
            "all effects put in",
            (line.surely_wrong for line in put),
            "<= 2 %",
            at_most(0.02),
        ),
        rate(
            "a sure effect",
            "runs as they are",
            (line.sure_effect for line in calm),
            "0",
            at_most(0.0),
        ),
        rate(
            "95 % intervals cover the size",
            "right answers",
            covered,
            "90-98 %",
            between(0.90, 0.98),
        ),
        rate(
            "answered, neither refused nor a fault of the program",
            "all cases",
            (not line.score.refused for line in lines),
            "100 %",
            at_least(1.0),
        ),
        rate(
            "named",
            "a thruster commanded and without effect",
            (line.first for line in dead),
            "100 %",
            at_least(1.0),
        ),
    )
    return MeasuredScore(
        cases=len(lines),
        refused=sum(bool(line.score.refused) for line in lines),
        goals=goals,
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
