"""Values and intervals of an answer's parameters."""

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
