"""From weighed answers to what is said: on one vehicle, with the thresholds and with others."""

from dataclasses import dataclass, replace

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.answer import Answers
from pipeline.diagnose.calibration import Calibration, calibration
from pipeline.diagnose.case import Case, channels_of
from pipeline.diagnose.conclusion import Conclusion, conclude
from pipeline.diagnose.gap_seen import GapSeen, gap_seen
from pipeline.diagnose.inference import infer
from pipeline.diagnose.record import record_of
from pipeline.diagnose.search import Search


@dataclass(frozen=True)
class Weighed:
    """A vehicle with a weak thruster, up to where it is decided what is said of it."""

    case: Case
    found: Search
    answered: Answers
    seen: GapSeen

    def conclude(self, limits: Calibration) -> Conclusion:
        """What is said with some thresholds."""
        return conclude(self.found, self.answered, self.seen, limits, healthy_known=False)


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
    record = record_of(
        weighed.case,
        weighed.case.runs,
        weighed.found,
        weighed.seen,
        concluded,
        None,
        calibration(),
    )
    assert record.verdict.effects == concluded.said.names
    assert record.verdict.detail.thruster == "front_left"
    assert record.gap.channels == weighed.seen.channels
    assert record.shrink == concluded.led_to.closed
    assert record.next_run is None
    assert {one.effect for one in record.ranking} >= {"none", "unknown", "linear_damping"}
