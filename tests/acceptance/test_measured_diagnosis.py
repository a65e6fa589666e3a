"""Effects that were put into measured runs are found against the other runs of the day."""

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.campaign.measured_subjects import MeasuredSubject, load_subject
from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose
from pipeline.effects.library import candidates, parse_effect
from pipeline.measured.inject import commanded_without_effect, injected
from pipeline.records.diagnosis import DiagnosisRecord

WEAK = "rear_left"


@pytest.fixture(scope="module")
def tank(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> MeasuredSubject:
    if not (shared_data / "brov2_tank_mocap").is_dir():
        pytest.skip("no tank runs")
    return load_subject(shared_data / "brov2_tank_mocap", tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="module")
def told(tank: MeasuredSubject) -> DiagnosisRecord:
    """One of two runs has a weak thruster in it."""
    runs = sorted(tank.runs, key=lambda one: one.time_s.size)
    spec = parse_effect(f"thruster_degraded:thrust_fraction=0.6@{WEAK}", tank.packed.thruster_names)
    bad = injected(tank.packed, runs[1], [spec], tank.vehicle.sensors).run
    healthy = (runs[0], runs[2], runs[4])
    case = Case("tank", tank.vehicle, tank.packed, (bad, runs[3]), healthy=healthy)
    return diagnose(case)


def test_the_weak_thruster_is_named_with_its_run(told: DiagnosisRecord) -> None:
    verdict = told.verdict
    assert verdict.effects == ("thruster_degraded",)
    assert verdict.detail.thruster == WEAK
    assert verdict.probability > 0.5
    assert len(verdict.runs) == 1
    assert "Only in" in verdict.text
    low, high = told.ranking[0].parameters["thrust_fraction"].ci95
    assert low < 0.6 < high


def test_what_is_printed_is_the_posterior_and_the_sound_runs(told: DiagnosisRecord) -> None:
    posterior = told.evidence.posterior
    assert posterior[f"thruster_degraded@{WEAK}"] == told.verdict.probability
    assert sum(posterior.values()) == pytest.approx(1.0)
    assert told.verdict.since == ", ".join(told.evidence.healthy_runs)
    assert all(one.ci95[0] <= one.value <= one.ci95[1] for one in told.gains)
    assert any("sound runs" in note for note in told.notes)


def test_a_wrong_scale_of_the_velocity_is_named(tank: MeasuredSubject) -> None:
    """Dead reckoning to the measured place is sure of it, beside the regression."""
    runs = sorted(tank.runs, key=lambda one: one.time_s.size)
    bad = replace(runs[1], values=runs[1].values | {"velocity": 1.1 * runs[1].values["velocity"]})
    case = Case("tank", tank.vehicle, tank.packed, (bad,), healthy=(runs[0], runs[2], runs[4]))
    record = diagnose(case)
    assert record.verdict.effects == ("dvl_scale",)
    assert record.verdict.since
    low, high = record.ranking[0].parameters["scale"].ci95
    assert low < 1.1 < high


def test_a_thruster_that_did_nothing_is_named_without_sound_runs(
    shared_data: Path, tmp_path: Path
) -> None:
    """Commands are written for one that stood still in a run of others' vehicle."""
    if not (shared_data / "exjobbrov_pool").is_dir():
        pytest.skip("no pool runs")
    pool = load_subject(shared_data / "exjobbrov_pool", tmp_path)
    run = next(one for one in pool.runs if one.name.startswith("stepPsiS3E10_2016-05-25-09-04"))
    told = commanded_without_effect(pool.packed, run, "sway")
    every = candidates(pool.packed.context)
    few = {name: every[name] for name in ("thruster_degraded", "residual_buoyancy")}
    record = diagnose(Case("pool", pool.vehicle, pool.packed, (told,), effects=few))
    assert record.verdict.effects[0] == "thruster_degraded"
    assert record.verdict.detail.thruster == "sway"
    low, high = record.ranking[0].parameters["thrust_fraction"].ci95
    assert low == 0.0
    assert high < 0.3
    assert record.gains
