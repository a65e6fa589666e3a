"""The gap of a channel in a regime is the error of the windows that lie in it."""

import numpy as np
import pytest

from pipeline.diagnose.gap.regimes import Regressor, regime_gaps
from pipeline.types import BoolArray


def test_a_gap_that_grows_with_depth_shows_in_the_deepest_third() -> None:
    windows = 9
    depth = np.repeat([1.0, 2.0, 3.0], 3)
    ratio = np.where(depth > 2.5, 5.0, 1.0)

    def ratios_in(inside: BoolArray) -> dict[str, float]:
        return {"w": float(ratio[inside].mean()), "u": 1.0}

    wall = Regressor("wall_distance_m", "m", np.full(windows, np.nan))
    found = regime_gaps([Regressor("depth_m", "m", depth), wall], ratios_in)
    assert [one.ratios["u"] for one in found] == [1.0] * len(found)
    assert found[-1].range[1] == 3.0
    assert found[-1].ratios["w"] > 4.0 * found[0].ratios["w"]
    assert sum(one.share_of_time for one in found) == pytest.approx(1.0)
    assert {one.regressor for one in found} == {"depth_m"}


def test_a_regressor_that_never_changes_is_one_regime_or_none() -> None:
    still = Regressor("depth_m", "m", np.full(4, 1.5))
    assert regime_gaps([still], lambda _: {}) == ()
