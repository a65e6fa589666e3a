"""The healthy floor is not made of more scatter than the healthy runs bear out."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import index_of, small_case

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.gap.healthy_floor import borne_out
from pipeline.diagnose.inference import healthy
from pipeline.diagnose.inference.healthy import learn
from pipeline.diagnose.judging.search import ordinary_prior
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.types import FloatArray


@pytest.fixture(scope="module")
def case() -> Case:
    made = small_case(manoeuvres=("prbs", "surge_steps"), seconds=18.5)
    return replace(made, runs=made.runs[:1], healthy=made.runs)


def _part(case: Case, deviations: float, lag_power: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Scatter of so many stated deviations, and what the runs of a healthy vehicle leave of it."""
    channels = channels_of(case.vehicle, case.healthy)
    setting = setting_of(case, case.healthy, channels, threads=1)
    stated = ordinary_prior(setting)
    scatter = deviations * np.sqrt(np.diag(stated.covariance))
    mean = stated.mean.copy()
    power = index_of(setting.coordinates, "lag_form:power")
    mean[power] = (lag_power - 1.0) / setting.coordinates[power].unit_size
    known = Prior(mean, 0.04 * stated.covariance)
    still = np.zeros((setting.bench.window_count, 12))
    return scatter, borne_out(setting, case.healthy, channels, still, known, scatter)


def test_a_little_scatter_stays(case: Case) -> None:
    scatter, left = _part(case, 0.1)
    np.testing.assert_array_equal(left, scatter)


def test_scatter_that_the_runs_do_not_show_does_not(case: Case) -> None:
    scatter, left = _part(case, 100.0)
    assert (left <= 0.25 * scatter).all()


def test_a_form_of_lag_that_nothing_has_is_none(case: Case) -> None:
    """Readings that the model hardly fits may want a power of the code below 0, which runs away."""
    scatter, left = _part(case, 0.1, lag_power=-0.047)
    assert (left <= scatter).all()


def test_one_run_shows_none(case: Case) -> None:
    assert learn(replace(case, healthy=case.healthy[:1]), threads=1).floor_scatter is None
    two = learn(case, threads=1).floor_scatter
    assert two is not None


@pytest.mark.slow
def test_a_gap_is_seen_though_the_scatter_is_learned_far_too_large(
    case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    sick = small_case(("thrust_deduction:t=0.3",), seconds=18.5)
    sick = replace(sick, healthy=case.healthy)

    def largest() -> float:
        return max(one.ratio for one in diagnose(sick, threads=1).gap.channels.values())

    def far_too_large(setting: Setting, *_: object) -> FloatArray:
        stated = np.array([one.ordinary for one in setting.coordinates])
        return 8.0 * stated

    monkeypatch.setattr(healthy, "scatter_between_runs", far_too_large)
    seen = largest()
    monkeypatch.setattr(healthy, "borne_out", lambda *asked: asked[-1])
    assert seen > 1.5
    assert largest() < 1.0
