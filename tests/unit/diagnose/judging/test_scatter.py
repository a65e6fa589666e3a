"""By how much runs differ from each other: found where they do, and nothing where they do not."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.judging.hypotheses import groups_of
from pipeline.diagnose.judging.nil import reach, with_small
from pipeline.diagnose.judging.scatter import scatter_between_runs
from pipeline.diagnose.judging.search import force_prior, ordinary_prior
from pipeline.diagnose.linear.elimination import grams, marginal
from pipeline.diagnose.linear.evidence import fit
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.types import FloatArray

EFFECTS = ("quadratic_damping", "linear_damping")
#: The same drag, and drag that is another in each run by far more than rov8's file states (8 %).
SAME, OTHER = (
    ("quadratic_damping:sway=1.1",) * 2,
    (
        "quadratic_damping:surge=0.7,sway=0.7,heave=0.7,yaw=0.7",
        "quadratic_damping:surge=1.4,sway=1.4,heave=1.4,yaw=1.4",
    ),
)


def of_runs(faults: tuple[str, str]) -> Case:
    """Two runs of one vehicle, each with a fault of its own."""
    first, second = (small_case((fault,), effects=EFFECTS) for fault in faults)
    return replace(first, runs=(first.runs[0], second.runs[1]))


def scattered(case: Case) -> tuple[FloatArray, float]:
    """Scatter, and by how much it widens what the runs leave of the drag in surge."""
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    model = linear_model(setting, setting.origin())
    prior, moved = ordinary_prior(setting), reach(model, ordinary_prior(setting))
    prior = with_small(prior, moved, setting)
    forces = force_prior(setting, Level(np.ones(6), 1.0, True))
    normal = grams(model)
    groups = groups_of(setting.coordinates)
    found = scatter_between_runs(setting, normal, forces, prior, moved, groups)
    index = [one.name for one in setting.coordinates].index("quadratic_damping:surge")
    alone, apart = (
        fit(marginal(replace(normal, scatter=one), forces), prior).std[index]
        for one in (0.0 * found, found)
    )
    return found, float(apart / alone)


def test_runs_of_one_vehicle_do_not_differ() -> None:
    found, wider = scattered(of_runs(SAME))
    np.testing.assert_array_equal(found, 0.0)
    assert wider == pytest.approx(1.0)


def test_runs_that_differ_leave_less_of_what_they_agree_on() -> None:
    found, wider = scattered(of_runs(OTHER))
    assert found.max() > 0.0
    assert wider > 1.5


def test_one_run_cannot_show_it() -> None:
    case = of_runs(OTHER)
    found, _ = scattered(replace(case, runs=case.runs[:1]))
    np.testing.assert_array_equal(found, 0.0)
