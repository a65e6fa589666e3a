"""How far the gap shrinks, counted over what healthy vehicles leave before and after."""

import numpy as np
import pytest

from pipeline.diagnose.gap.forecast import Forecast
from pipeline.diagnose.gap.shrink import shrink

WINDOWS, READINGS = 6, 50


def forecast(size: float, sensor: float = 1.0) -> Forecast:
    """One channel whose errors have this rms, in windows of 50 readings."""
    errors = np.tile([size, -size], WINDOWS * READINGS // 2)
    window = np.repeat(np.arange(WINDOWS), READINGS)
    return Forecast({"r": errors}, {"r": np.ones(errors.size)}, {"r": window}, {"r": sensor})


def spread(square: float) -> dict[str, np.ndarray]:
    return {"r": np.full(WINDOWS * READINGS, square)}


HELD = np.arange(WINDOWS) >= 3


def test_figures_are_counted_over_the_healthy_floor() -> None:
    # sqrt(3 + 1^2) = 2
    found = shrink(forecast(8.0), forecast(2.0), spread(3.0), HELD, "three windows")
    assert (found.before, found.after, found.noise_floor) == pytest.approx((4.0, 1.0, 1.0))
    assert found.gap_closed == pytest.approx(1.0)
    assert found.channels["r"].noise_floor == pytest.approx(2.0)
    assert found.channels["r"].noise_floor_after is None


def test_what_is_ordinary_for_a_vehicle_with_the_answer_is_no_gap() -> None:
    # with the answer the same parameter errors leave sqrt(35 + 1) = 6
    found = shrink(forecast(8.0), forecast(7.5), spread(3.0), HELD, "", 0, spread(35.0))
    assert (found.before, found.after) == pytest.approx((4.0, 1.25))
    assert found.gap_closed == pytest.approx(2.75 / 3.0)
    one = found.channels["r"]
    assert (one.before, one.after, one.noise_floor, one.noise_floor_after) == pytest.approx(
        (8.0, 7.5, 2.0, 6.0)
    )


def test_a_less_sensitive_vehicle_is_held_to_the_same_floor() -> None:
    found = shrink(forecast(8.0), forecast(2.0), spread(3.0), HELD, "", 0, spread(0.0))
    assert found.after == pytest.approx(1.0)
    assert found.channels["r"].noise_floor_after is None
