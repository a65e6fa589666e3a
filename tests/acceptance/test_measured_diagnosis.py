"""Effects that were put into measured runs are found against the other runs of the day."""

from pathlib import Path

import pytest

from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose
from pipeline.effects.library import parse_effect
from pipeline.measured.inject import injected
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.stages.measured_subjects import MeasuredSubject, load_subject

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
    return diagnose(case, threads=1)


def test_the_weak_thruster_is_named_with_its_run(told: DiagnosisRecord) -> None:
    verdict = told.verdict
    assert verdict.effects == ("thruster_degraded",)
    assert verdict.detail.thruster == WEAK
    assert verdict.probability > 0.9
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
