"""Where an answer acts, told from the difference that it makes to the prediction."""

import numpy as np
import pytest

from pipeline.diagnose.conclude.where import by_window, made
from pipeline.diagnose.gap.forecast import AHEAD_S, Forecast
from pipeline.diagnose.gap.regimes import Regressor, rank_correlation, regime_shares

WINDOWS, READINGS = 4, 5


def forecast(errors: dict[str, np.ndarray]) -> Forecast:
    """Readings of some windows; the last of each is further ahead than what counts."""
    ahead = np.tile([*np.linspace(1.0, AHEAD_S, READINGS - 1), AHEAD_S + 1.0], WINDOWS)
    window = np.repeat(np.arange(WINDOWS), READINGS)
    return Forecast(
        errors,
        dict.fromkeys(errors, ahead),
        dict.fromkeys(errors, window),
        dict.fromkeys(errors, 3.0),
    )


@pytest.fixture
def before() -> Forecast:
    rng = np.random.default_rng(1)
    return forecast({name: rng.normal(size=WINDOWS * READINGS) for name in ("u", "v")})


def test_the_difference_is_counted_in_floors_whatever_the_noise(before: Forecast) -> None:
    act = np.zeros(WINDOWS * READINGS)
    act[READINGS : 2 * READINGS] = 10.0
    after = forecast({"u": before.errors["u"] - act, "v": before.errors["v"]})
    spread = {name: np.full(act.size, 16.0) for name in ("u", "v")}
    found = made(before, after, spread)
    # sqrt(4^2 + 3^2) is the floor
    assert found["u"][READINGS : 2 * READINGS - 1] == pytest.approx(2.0)
    assert found["v"][: READINGS - 1] == pytest.approx(0.0)
    assert np.isnan(found["u"][READINGS - 1 :: READINGS]).all()
    assert by_window(found, before, WINDOWS) == pytest.approx([0.0, 4.0, 0.0, 0.0])


def test_a_simulation_that_ran_away_says_nothing(before: Forecast) -> None:
    errors = before.errors["u"].copy()
    errors[:READINGS] = np.inf
    after = forecast({"u": errors, "v": before.errors["v"]})
    found = made(before, after, {name: np.zeros(errors.size) for name in ("u", "v")})
    assert by_window(found, before, WINDOWS)[0] == 0.0


def test_a_gap_that_grows_a_little_with_speed_throughout_is_said_to_go_with_it() -> None:
    speed = np.linspace(0.0, 1.0, 12)
    every = [Regressor("speed_mps", "m/s", speed), Regressor("depth_m", "m", np.sin(40.0 * speed))]
    (found,) = regime_shares(every, 1.0 + 0.5 * speed)
    assert found.regressor == "speed_mps"
    assert found.correlation == pytest.approx(1.0)
    assert found.range[1] == 1.0
    assert regime_shares(every, np.ones(12)) == ()


@pytest.mark.parametrize(("windows", "named"), [(81, True), (12, False)])
def test_a_regime_is_named_where_the_gap_goes_with_it_by_more_than_chance(
    windows: int, named: bool
) -> None:
    """A rank correlation of a half is chance one time in ten of twelve windows."""
    place = np.arange(windows)
    speed = place / windows
    # what else there is comes three times over, whatever the speed
    gap = 1.5 + speed + place % 3
    assert 0.3 < rank_correlation(gap, speed) < 0.6
    assert bool(regime_shares([Regressor("speed_mps", "m/s", speed)], gap)) == named


def test_a_force_that_grows_through_zero_goes_with_the_time_though_its_size_does_not() -> None:
    time_s = np.linspace(0.0, 60.0, 12)
    force = np.linspace(-1.0, 1.0, 12)
    every = [Regressor("time_s", "s", time_s), Regressor("depth_m", "m", np.sin(time_s))]
    assert "time_s" not in {one.regressor for one in regime_shares(every, np.ones(12))}
    first = regime_shares(every, force**2, {"time_s": 1.0})[0]
    assert first.regressor == "time_s"
    assert first.correlation == 1.0
    assert first.share > first.share_of_time


def test_the_gap_grows_with_the_time_also_where_the_force_is_against_the_axis() -> None:
    time_s = np.linspace(0.0, 60.0, 12)
    (found,) = regime_shares([Regressor("time_s", "s", time_s)], time_s**2, {"time_s": -0.8})
    assert found.correlation == 0.8
