"""Errors ahead in time: what is ordinary is no gap."""

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.regression.ahead import error_of, rms_of, summed, typical
from pipeline.diagnose.regression.grid import on_grids
from pipeline.diagnose.regression.known import by_file


@pytest.mark.parametrize(("force_n", "ordinary"), [(1.0, True), (3.0, False)])
def test_trim_that_a_healthy_vehicle_may_have_is_taken_off(force_n: float, ordinary: bool) -> None:
    case = small_case((f"residual_buoyancy:force_n={force_n}",), seconds=24.0)
    known = by_file(case)
    learned = known.best
    period = [learned.response.period_s]
    (grid,) = on_grids(case.packed, case.runs[0], case.vehicle.sensors, known.directions, period)
    (run,) = learned.told_runs([grid])
    heave = learned.response.channels.index("w")
    bare = rms_of([summed(learned.after(run)[1], learned.response.period_s)])[heave]
    left = rms_of([error_of(learned, run)])[heave]
    floor = typical([error_of(learned, one) for one in learned.usual])[heave]
    assert left < 0.75 * bare
    assert (left < floor) == ordinary


def test_one_run_that_is_off_makes_no_floor() -> None:
    runs = [np.full((10, 1), value) for value in (1.0, 1.0, 1.0, 16.0)]
    assert typical(runs) == pytest.approx(2.0)
    assert rms_of(runs)[0] > 8.0
    assert typical([np.zeros((0, 2))]) == pytest.approx(0.0)
