"""How far the gap shrinks, counted over what healthy vehicles leave before and after."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.diagnose.gap.forecast import RUN_AWAY, Forecast
from pipeline.diagnose.gap.shrink import _blocks, shrink

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


def with_runaway(found: Forecast, windows: int) -> Forecast:
    """The simulation of the first held-out windows ran away."""
    errors = found.errors["r"].copy()
    first = 3 * READINGS
    errors[first : first + windows * READINGS] = np.nan
    return replace(found, errors={"r": errors})


@pytest.mark.parametrize("windows", [1, 2, 3])
def test_an_answer_under_which_the_simulation_runs_away_closes_nothing(windows: int) -> None:
    after = with_runaway(forecast(1.0), windows)
    found = shrink(forecast(6.0), after, spread(3.0), HELD, "")
    assert found.after > found.before == pytest.approx(3.0)
    assert found.gap_closed is not None
    assert found.gap_closed < 0.0


def test_a_file_under_which_the_simulation_runs_away_is_off_by_that() -> None:
    found = shrink(with_runaway(forecast(2.0), 1), forecast(2.0), spread(3.0), HELD, "")
    assert found.before == pytest.approx(np.sqrt((RUN_AWAY**2 + 2.0) / 3.0))
    assert found.after == pytest.approx(1.0)


def test_a_channel_that_is_never_predicted_takes_nothing_from_the_others() -> None:
    def beside(found: Forecast) -> Forecast:
        blank = np.full(WINDOWS * READINGS, np.nan)
        return Forecast(
            {**found.errors, "z": blank},
            {**found.ahead_s, "z": found.ahead_s["r"]},
            {**found.window, "z": found.window["r"]},
            {**found.sensor, "z": 1.0},
        )

    squares = {**spread(3.0), "z": spread(3.0)["r"]}
    found = shrink(beside(forecast(6.0)), beside(forecast(2.0)), squares, HELD, "")
    assert (found.before, found.after) == pytest.approx((3.0, 1.0))


def test_what_is_further_ahead_than_the_window_does_not_count() -> None:
    def late(size: float) -> Forecast:
        """Errors of this size within a second, and a hundred times as large after it."""
        found = forecast(size)
        ahead = np.tile(np.where(np.arange(READINGS) < 25, 1.0, 8.0), WINDOWS)
        errors = np.where(ahead > 1.0, 100.0, 1.0) * found.errors["r"]
        return replace(found, errors={"r": errors}, ahead_s={"r": ahead})

    near = shrink(late(6.0), late(2.0), spread(3.0), HELD, "", within_s=6.0)
    assert (near.before, near.after) == pytest.approx((3.0, 1.0))
    assert shrink(late(6.0), late(2.0), spread(3.0), HELD, "").before > 100.0


def test_windows_are_drawn_with_their_neighbours() -> None:
    """What is predicted of one reaches into the next, so two of them are hardly two looks."""
    drawn = _blocks(np.random.default_rng(0), np.arange(9))
    assert drawn.size == 9
    assert (np.diff(drawn)[::2] == 1).all()
    assert _blocks(np.random.default_rng(0), np.array([4])).tolist() == [4]
    few = {tuple(_blocks(np.random.default_rng(k), np.array([2, 3]))) for k in range(20)}
    assert few == {(2, 2), (2, 3), (3, 2), (3, 3)}


def test_where_nothing_was_held_out_nothing_is_told() -> None:
    """Runs too short for a third window: no figures, and no division by zero."""
    found = shrink(forecast(6.0), forecast(2.0), spread(3.0), np.zeros(WINDOWS, bool), "")
    assert (found.gap_closed, found.ci95, dict(found.channels)) == (None, None, {})
