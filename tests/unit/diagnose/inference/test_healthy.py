"""What healthy runs narrow, and what one of them alone cannot."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import index_of, small_case

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.inference.healthy import learn
from pipeline.diagnose.judging.search import ordinary_prior


@pytest.fixture(scope="module")
def case() -> Case:
    made = small_case(manoeuvres=("prbs", "surge_steps"), seconds=18.5)
    return replace(made, runs=made.runs[:1], healthy=made.runs)


def test_two_healthy_runs_narrow_what_is_stated_and_one_does_not(case: Case) -> None:
    setting = setting_of(case, case.healthy, channels_of(case.vehicle, case.healthy), threads=1)
    stated = np.diag(ordinary_prior(setting).covariance)
    known = stated > 0.0
    two = np.diag(learn(case, threads=1).prior.covariance)
    one = np.diag(learn(replace(case, healthy=case.healthy[:1]), threads=1).prior.covariance)
    assert (one[known] >= stated[known]).all()
    # what the runs show well is known better than it was stated: at least the day-to-day part stays
    assert (two[known] < 0.5 * stated[known]).any()
    assert (two[known] >= 0.2**2 * stated[known]).all()


def test_what_healthy_runs_show_that_the_file_does_not_state_is_no_effect() -> None:
    """A DVL that showed a tenth too much when the vehicle was well."""
    made = small_case(("dvl_scale:scale=1.1",), effects=("dvl_scale",))
    case = replace(made, healthy=made.runs)
    setting = setting_of(case, case.healthy, channels_of(case.vehicle, case.healthy), threads=1)
    index = index_of(setting.coordinates, "dvl_scale:scale")
    known = learn(case, threads=1).prior
    # all of it, though nothing was stated of it: 0.096 where only what does not matter is ordinary
    assert setting.coordinates[index].unit_size * known.mean[index] == pytest.approx(0.1, abs=2e-3)
    assert diagnose(case, threads=1).verdict.effects == ("none",)
