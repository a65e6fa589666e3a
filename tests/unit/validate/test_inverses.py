"""The wrappers change what they say and nothing else."""

import numpy as np
import pytest
from flight_cases import Bench

from pipeline.control.inverse import firmware_grid, rounded
from pipeline.validate.closed_loop import ClosedLoop
from pipeline.validate.controllers import Remembered


def test_remembered_limits_are_those_at_the_nearest_millimetre_per_second(mmt300: Bench) -> None:
    grid = firmware_grid(mmt300.inverse)
    one = Remembered(grid)
    for speed in (0.0, 0.7, 1.4996, -0.3):
        assert one.limits(speed).forward_n == pytest.approx(grid.limits(speed).forward_n, abs=0.02)
        assert one.limits(speed) is one.limits(speed)
    assert one.code(12.0, 1.1) == grid.code(12.0, 1.1)


def test_fixed_point_codes_are_the_rounded_ones_of_the_grid(
    mmt300: Bench, field: ClosedLoop
) -> None:
    generator = np.random.default_rng(5)
    thrust, speed = generator.uniform(-40, 40, 500), generator.uniform(-0.5, 2.0, 500)
    fixed = field.controllers.fixed
    assert fixed is not None
    exact = firmware_grid(mmt300.inverse).code(thrust, speed)
    off = np.abs(fixed.code(thrust, speed) - rounded(exact))
    assert off.max() <= 1.0
    assert (off > 0.0).mean() < 0.01
    assert np.abs(fixed.code(thrust, speed) - exact).max() <= 0.501
