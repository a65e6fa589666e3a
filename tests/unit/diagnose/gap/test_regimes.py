"""The gap of a channel in a regime is the error of the windows that lie in it."""

import numpy as np
import pytest
from pipeline.diagnose.gap.forecast import Forecast

from pipeline.diagnose.gap.regimes import Regressor, ratios_of, regime_gaps


def test_a_gap_that_grows_with_depth_shows_in_the_deepest_third() -> None:
    windows, readings = 9, 20
    depth = np.repeat([1.0, 2.0, 3.0], 3)
    owner = np.repeat(np.arange(windows), readings)
    sign = np.tile([1.0, -1.0], windows * readings // 2)
    errors = {"w": 0.1 * sign, "u": 0.1 * sign}
    errors["w"][owner >= 6] = 0.5 * sign[owner >= 6]
    ahead = np.tile(np.linspace(0.2, 10.0, readings), windows)
    near = Forecast(
        errors=errors,
        ahead_s={"w": ahead, "u": ahead},
        window={"w": owner, "u": owner},
        sensor={"w": 0.06, "u": 0.06},
    )
    spread = {"w": np.full(owner.size, 0.08**2), "u": np.full(owner.size, 0.08**2)}
    wall = Regressor("wall_distance_m", "m", np.full(windows, np.nan))
    found = regime_gaps([Regressor("depth_m", "m", depth), wall], ratios_of(near, spread, 6.0))
    # healthy floor: sqrt(0.08^2 + 0.06^2) = 0.1
    assert [one.ratios["u"] for one in found] == pytest.approx([1.0] * len(found))
    assert found[-1].range[1] == 3.0
    assert found[-1].ratios["w"] > 4.0 * found[0].ratios["w"]
    assert sum(one.share_of_time for one in found) == pytest.approx(1.0)
    assert {one.regressor for one in found} == {"depth_m"}


def test_a_regressor_that_never_changes_is_one_regime_or_none() -> None:
    near = Forecast(
        errors={"u": np.full(4, 0.1)},
        ahead_s={"u": np.full(4, 1.0)},
        window={"u": np.arange(4)},
        sensor={"u": 0.1},
    )
    still = Regressor("depth_m", "m", np.full(4, 1.5))
    assert regime_gaps([still], ratios_of(near, {"u": np.zeros(4)}, 6.0)) == ()
