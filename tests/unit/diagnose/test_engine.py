"""Whole diagnoses of small fixed cases, verdicts compared."""

from dataclasses import replace

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose
from pipeline.records.diagnosis import DiagnosisRecord


@pytest.fixture(scope="module")
def weak_case() -> Case:
    return small_case(("thruster_degraded:thrust_fraction=0.6@front_left",))


@pytest.fixture(scope="module")
def weak(weak_case: Case) -> DiagnosisRecord:
    return diagnose(weak_case)


def test_a_weak_thruster_is_named_with_its_thrust(weak: DiagnosisRecord) -> None:
    assert weak.verdict.effects == ("thruster_degraded",)
    assert weak.verdict.detail.thruster == "front_left"
    assert weak.verdict.probability > 0.9
    low, high = weak.ranking[0].parameters["thrust_fraction"].ci95
    assert low < 0.6 < high
    assert high - low < 0.35


def test_the_gap_is_there_and_closes_on_what_was_held_out(weak: DiagnosisRecord) -> None:
    assert max(one.ratio for one in weak.gap.channels.values()) > 2.0
    assert weak.shrink.before > 1.3
    assert weak.shrink.after < 1.3
    assert weak.shrink.gap_closed is not None
    assert weak.shrink.gap_closed > 0.8


def test_every_effect_is_in_the_ranking_and_probabilities_add_up(weak: DiagnosisRecord) -> None:
    names = {row.effect for row in weak.ranking}
    assert {"none", "unknown", "dvl_scale", "residual_buoyancy", "quadratic_damping"} <= names
    assert sum(row.probability for row in weak.ranking) == pytest.approx(1.0)


def test_order_and_names_of_runs_do_not_matter(weak_case: Case, weak: DiagnosisRecord) -> None:
    first, second = weak_case.runs
    turned = replace(
        weak_case, runs=(replace(second, name="b"), replace(first, name="a")), name="other"
    )
    found = diagnose(turned)
    assert found.verdict.effects == weak.verdict.effects
    assert found.verdict.probability == pytest.approx(weak.verdict.probability, rel=1e-6)
    assert found.ranking[0].parameters == weak.ranking[0].parameters


def test_a_healthy_vehicle_has_no_effect() -> None:
    found = diagnose(small_case(seed=4))
    assert found.verdict.effects == ("none",)
    assert found.leftover.axes["surge"] < 2.0


@pytest.mark.slow
def test_held_out_runs_speak_for_what_they_show_and_against_what_they_do_not() -> None:
    weak = small_case(("thruster_degraded:thrust_fraction=0.6@front_left",), seconds=32.0)
    well = small_case(seconds=32.0)
    evidence = []
    for held in (weak.runs[1], well.runs[1]):
        found = diagnose(replace(weak, runs=weak.runs[:1], holdout=(held,)))
        # the first row of an effect is that of the likeliest thruster
        said = {row.effect: row.held_out_log_evidence for row in reversed(found.ranking)}
        assert said["none"] is None
        evidence.append(said["thruster_degraded"])
    assert None not in evidence
    assert evidence[0] > 0.0 > evidence[1]
