"""What healthy runs narrow, and what one of them alone cannot."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.healthy import learn
from pipeline.diagnose.search import ordinary_prior


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
