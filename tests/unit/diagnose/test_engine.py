"""Whole diagnoses of small fixed cases, verdicts compared."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case
from pipeline.diagnose.conclude import consequences
from pipeline.diagnose.linear.linear_model import Setting, vector_of
from pipeline.diagnose.rules.calibration import calibration

from pipeline.diagnose import engine
from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose, diagnose_fully
from pipeline.errors import CannotComputeError
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.types import FloatArray


@pytest.fixture(scope="module")
def weak_case() -> Case:
    return small_case(("thruster_degraded:thrust_fraction=0.6@front_left",))


@pytest.fixture(scope="module")
def weak(weak_case: Case) -> DiagnosisRecord:
    return diagnose(weak_case, threads=1)


def test_a_weak_thruster_is_named_with_its_thrust(weak: DiagnosisRecord) -> None:
    assert weak.verdict.effects == ("thruster_degraded",)
    assert weak.verdict.detail.thruster == "front_left"
    assert weak.verdict.probability > 0.9
    low, high = weak.ranking[0].parameters["thrust_fraction"].ci95
    assert low < 0.6 < high
    assert high - low < 0.2


def test_the_gap_is_there_and_closes_on_what_was_held_out(weak: DiagnosisRecord) -> None:
    assert max(one.ratio for one in weak.gap.channels.values()) > 3.0
    assert weak.shrink.before > 2.0
    assert weak.shrink.after < 1.3
    assert weak.shrink.gap_closed is not None
    assert weak.shrink.gap_closed > 0.8


def test_every_effect_is_in_the_ranking_and_probabilities_add_up(weak: DiagnosisRecord) -> None:
    names = {row.effect for row in weak.ranking}
    assert {"none", "unknown", "dvl_scale", "residual_buoyancy", "quadratic_damping"} <= names
    assert sum(row.probability for row in weak.ranking) == pytest.approx(1.0)


def test_what_is_not_named_goes_into_no_vehicle_file(
    weak_case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    patient = replace(calibration(), verdict=1.1, most_none_gap=1e3)
    monkeypatch.setattr(engine, "calibration", lambda: patient)
    found = diagnose_fully(weak_case, threads=1)
    assert found.record.verdict.effects == ("none",)
    assert found.record.verdict.ambiguous_with == ("thruster_degraded",)
    assert found.specs == ()


def test_order_and_names_of_runs_do_not_matter(weak_case: Case, weak: DiagnosisRecord) -> None:
    first, second = weak_case.runs
    turned = replace(
        weak_case, runs=(replace(second, name="b"), replace(first, name="a")), name="other"
    )
    found = diagnose(turned, threads=1, seed=7)
    assert found.verdict.effects == weak.verdict.effects
    assert found.verdict.probability == pytest.approx(weak.verdict.probability, rel=1e-6)
    assert found.ranking[0].parameters == weak.ranking[0].parameters


def test_a_healthy_vehicle_has_no_effect() -> None:
    found = diagnose(small_case(seed=4), threads=1)
    assert found.verdict.effects == ("none",)
    assert found.leftover.axes["surge"] < 2.0


@pytest.mark.slow
def test_an_error_of_the_dvl_is_named_beside_what_has_no_name() -> None:
    """A current hides the scale among forces; dead reckoning knows it all the same."""
    case = small_case(
        ("dvl_scale:scale=1.1", "current:north_mps=0.4"), effects=("dvl_scale", "residual_buoyancy")
    )
    answer = diagnose_fully(case, threads=1)
    found, first = answer.record, answer.record.ranking[0]
    assert found.verdict.effects == ("dvl_scale", "unknown")
    assert "no effect of the library explains" in found.verdict.sentence
    assert set(first.parameters) == {"scale"}
    low, high = first.parameters["scale"].ci95
    assert low < 1.1 < high
    assert sum(row.probability for row in found.ranking) == pytest.approx(1.0)
    assert {row.effect for row in found.ranking} >= {"none", "unknown", "residual_buoyancy"}
    # the gap is that of the vehicle file, whose DVL reads right; what was found is written back
    assert [spec.id for spec in answer.specs] == ["dvl_scale"]
    assert found.gap.channels["u"].ratio > 1.5
    assert "dead reckoning" in found.evidence.stages["kinematics"]


@pytest.mark.parametrize("fault", [np.linalg.LinAlgError("no")])
def test_instruments_that_cannot_be_compared_take_nothing_from_the_answer(
    weak_case: Case, weak: DiagnosisRecord, monkeypatch: pytest.MonkeyPatch, fault: Exception
) -> None:
    def refuse(*_: object) -> None:
        raise fault

    monkeypatch.setattr(engine, "errors_of", refuse)
    found = diagnose(weak_case, threads=1)
    assert found.verdict == weak.verdict


def test_stated_values_pulled_to_where_no_vehicle_is_refuse_no_diagnosis(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As a pool vehicle so far from its file that what is stated left it no mass."""
    asked: list[bool] = []

    def vector(setting: Setting, departures: FloatArray) -> FloatArray:
        stated = [not one.effect.unstated for one in setting.coordinates]
        asked.append(bool(departures[stated].any()))
        if asked[-1]:
            raise CannotComputeError("the vehicle has -7.7 kg left. The total must stay positive.")
        return vector_of(setting, departures)

    monkeypatch.setattr(consequences, "vector_of", vector)
    found = diagnose(small_case(seed=4), threads=1)
    assert asked == [False, True, False]
    assert found.verdict.effects == ("none",)
    assert found.shrink.after == found.shrink.before


def test_held_out_windows_say_nothing_against_an_effect_that_is_there(
    weak: DiagnosisRecord,
) -> None:
    said = {row.effect: row.held_out_log_evidence for row in weak.ranking}
    found = said["thruster_degraded"]
    # nor much for it: a stated parameter far off, as the chosen windows have it, says the same
    assert found is not None
    assert found > -1.0
    assert said["none"] is None
    assert said["unknown"] is None


@pytest.mark.slow
def test_held_out_runs_of_another_vehicle_take_the_answer_its_certainty(weak_case: Case) -> None:
    well = small_case(seed=1)
    found = diagnose(replace(weak_case, holdout=well.runs), threads=1)
    said = {row.effect: row.held_out_log_evidence for row in found.ranking}
    against = said["thruster_degraded"]
    assert against is not None
    assert against < 0.0
    assert found.verdict.effects != ("thruster_degraded",)
