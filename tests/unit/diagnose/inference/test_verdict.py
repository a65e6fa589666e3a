"""Values and intervals of an answer's parameters."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import index_of, small_case

from pipeline.diagnose.case import channels_of
from pipeline.diagnose.inference import verdict
from pipeline.diagnose.inference.answer import Candidate
from pipeline.diagnose.inference.infer import infer
from pipeline.diagnose.inference.verdict import parameters_of
from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.rules.calibration import calibration


@pytest.fixture(scope="module")
def found() -> Search:
    case = small_case(("quadratic_damping:surge=1.8,sway=1.8",), seconds=16.0)
    return infer(case, case.runs, channels_of(case.vehicle, case.runs), calibration(), 1)[0]


@pytest.mark.parametrize("axes", [("surge",), ("surge", "sway"), ("surge", "sway", "heave")])
def test_intervals_grow_with_the_root_of_the_parameters(
    found: Search, axes: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    every = found.setting.coordinates
    which = tuple(index_of(every, f"quadratic_damping:{axis}") for axis in axes)
    blank = np.zeros(len(which))
    finding = Finding((("quadratic_damping", None),), which, 0.0, blank, np.eye(len(which)), blank)
    one = Candidate("quadratic_damping", 1.0, 0.0, finding, found.judged[0])

    def surge(share: float) -> tuple[float, float]:
        monkeypatch.setattr(verdict, "_MODEL_SHARE", share)
        row = parameters_of(found, one, 1.0)[0]["surge"]
        return row.value, 0.5 * (row.ci95[1] - row.ci95[0])

    value, wide = surge(0.015)
    _, narrow = surge(0.0)
    more = np.sqrt(wide**2 - narrow**2)
    assert value > 1.2
    assert more == pytest.approx(1.96 * 0.015 * np.sqrt(len(axes)) * (value - 1.0), rel=1e-3)


def test_a_factor_is_one_on_what_the_vehicle_was_when_it_was_well(
    found: Search, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A drag of 1.3 on the healthy runs and of 1.8 now has grown by 1.8 / 1.3, not by 0.5."""
    monkeypatch.setattr(verdict, "_MODEL_SHARE", 0.0)
    every = found.setting.coordinates
    index = index_of(every, "quadratic_damping:surge")
    blank, wide = np.zeros(1), np.array([25.0])
    finding = Finding((("quadratic_damping", None),), (index,), 0.0, blank, np.eye(1), wide)
    one = Candidate("quadratic_damping", 1.0, 0.0, finding, found.judged[0])
    mean, covariance = found.prior.mean.copy(), found.prior.covariance.copy()
    mean[index] = 0.3 / every[index].unit_size
    covariance[index], covariance[:, index] = 0.0, 0.0
    searches = [
        replace(found, prior=Prior(middle, covariance)) for middle in (found.prior.mean, mean)
    ]
    fresh, since = (parameters_of(search, one, 1.0)[0]["surge"] for search in searches)
    assert fresh.value > 1.5
    assert since.value == pytest.approx(fresh.value / 1.3, rel=0.01)
    halves = [0.5 * (row.ci95[1] - row.ci95[0]) for row in (fresh, since)]
    assert halves[1] == pytest.approx(halves[0] / 1.3, rel=0.1)
