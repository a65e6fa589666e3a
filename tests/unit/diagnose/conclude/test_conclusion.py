"""From weighed answers to what is said: on one vehicle, with the thresholds and with others."""

from dataclasses import dataclass, replace

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case, channels_of
from pipeline.diagnose.conclude.conclusion import Conclusion, conclude
from pipeline.diagnose.conclude.consequences import nothing_added
from pipeline.diagnose.conclude.gap_seen import GapSeen, gap_seen
from pipeline.diagnose.inference.answer import Answers
from pipeline.diagnose.inference.infer import infer
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.rules.calibration import Calibration, calibration
from pipeline.diagnose.tell.record import record_of
from pipeline.records.diagnosis import DiagnosisRecord


@dataclass(frozen=True)
class Weighed:
    """A vehicle with a weak thruster, up to where it is decided what is said of it."""

    case: Case
    found: Search
    answered: Answers
    seen: GapSeen

    def conclude(self, limits: Calibration) -> Conclusion:
        """What is said with some thresholds."""
        return conclude(
            self.found,
            self.answered,
            self.seen,
            limits,
            healthy_known=False,
            supply_known=True,
        )

    def record(self, limits: Calibration) -> DiagnosisRecord:
        """The record of that."""
        said = self.conclude(limits)
        return record_of(self.case, self.case.runs, self.found, self.seen, said, None, limits)


@pytest.fixture(scope="module")
def weighed() -> Weighed:
    case = small_case(
        ("thruster_degraded:thrust_fraction=0.8@front_left",),
        effects=("thruster_degraded", "quadratic_damping", "linear_damping"),
    )
    channels = channels_of(case.vehicle, case.runs)
    found, answered = infer(case, case.runs, channels, calibration(), 1)
    return Weighed(case, found, answered, gap_seen(case, found, answered, case.runs, channels, 0))


def test_what_is_decided_by_is_the_worst_channel_where_no_error_is_known(weighed: Weighed) -> None:
    ratios = [one.ratio for one in weighed.seen.channels.values()]
    assert weighed.seen.worst_ratio == pytest.approx(max(ratios))
    assert weighed.seen.worst_ratio > 1.0


def test_the_answer_that_explains_the_gap_is_said_with_what_it_leads_to(weighed: Weighed) -> None:
    concluded = weighed.conclude(calibration())
    assert concluded.said.names == ("thruster_degraded",)
    assert concluded.top.name == "thruster_degraded"
    assert concluded.led_to.added.any()
    assert concluded.led_to.closed.after < concluded.led_to.closed.before
    total = sum(one.probability for one in concluded.answered.ranking)
    assert total == pytest.approx(1.0)


def test_an_answer_that_is_never_sure_enough_has_others_beside_it(weighed: Weighed) -> None:
    assert not weighed.conclude(calibration()).said.ambiguous
    doubting = weighed.conclude(replace(calibration(), verdict=1.1))
    assert doubting.said.names == ("thruster_degraded",)
    assert doubting.said.ambiguous


def test_the_record_tells_what_was_concluded(weighed: Weighed) -> None:
    concluded = weighed.conclude(calibration())
    record = weighed.record(calibration())
    assert record.verdict.effects == concluded.said.names
    assert record.verdict.detail.thruster == "front_left"
    assert record.gap.channels == weighed.seen.channels
    assert record.shrink == concluded.led_to.closed
    assert record.next_run is None
    assert {one.effect for one in record.ranking} >= {"none", "unknown", "linear_damping"}


def test_what_stands_beside_none_goes_into_no_model_but_says_where_to_look(
    weighed: Weighed,
) -> None:
    wide = replace(calibration(), verdict=1.1, most_none_gap=100.0)
    concluded = weighed.conclude(wide)
    assert concluded.said.names == ("none",)
    assert concluded.said.ambiguous == ("thruster_degraded",)
    assert not concluded.names_effects
    record = weighed.record(wide)
    assert record.shrink == nothing_added(weighed.seen.ahead)
    assert record.shrink.after > concluded.led_to.closed.after
    assert record.gap.where == weighed.record(calibration()).gap.where
    looked_at = next(one for one in record.ranking if one.effect == "thruster_degraded")
    assert looked_at.gap_closed == pytest.approx(concluded.led_to.closed.gap_closed)
