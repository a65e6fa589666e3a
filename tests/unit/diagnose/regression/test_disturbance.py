"""A force that comes and goes, by variance between blocks and within."""

import numpy as np
import pytest
from scipy import stats

from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.disturbance import block_powers, log_odds
from pipeline.diagnose.regression.weigh import NONE, UNKNOWN, with_disturbance

PERIOD_S = 0.25
NO_SIZE = np.zeros(0)


def left(seed: int, pull: float = 0.0) -> np.ndarray:
    """White noise (k, 2) with a pull in a sixth of it along the first channel."""
    noise = np.random.default_rng(seed).standard_normal((240, 2))
    noise[100:140, 0] += pull
    return noise


def ratios(seed: int, pull: float = 0.0) -> np.ndarray:
    return ratio_of(left(seed, pull))


def ratio_of(values: np.ndarray) -> np.ndarray:
    between, within = block_powers(values, PERIOD_S)
    return between / within


def test_the_ratio_is_that_of_an_analysis_of_variance() -> None:
    values = left(1, 1.0)
    blocks = values.reshape(15, 16, 2)
    expected = [stats.f_oneway(*blocks[:, :, c]).statistic for c in range(2)]
    assert ratio_of(values) == pytest.approx(expected)
    assert ratio_of(100.0 * values) == pytest.approx(expected)
    assert np.isnan(ratio_of(values[:40])).all()


def test_a_pull_for_a_sixth_of_a_run_shows_and_noise_does_not() -> None:
    sound = [ratios(seed) for seed in range(6)]
    assert log_odds(sound, [ratios(10), ratios(11)]) < 0.0
    assert log_odds(sound, [ratios(10), ratios(11, pull=4.0)]) > 2.5
    # where sound runs are pulled as well it is ordinary
    pulled = [ratios(seed, pull=4.0) for seed in range(3)]
    less = log_odds(pulled, [ratios(11, pull=4.0)])
    assert less < log_odds(sound, [ratios(11, pull=4.0)]) - 2.0


def test_a_channel_that_stands_out_in_each_sound_run_is_ordinary() -> None:
    """No other run shows the manoeuvre that moves it."""
    own = [np.array([40.0 if c == run else 1.0 for c in range(6)]) for run in range(3)]
    asked = [np.array([1.0, 1.0, 1.0, 40.0, 1.0, 1.0])]
    even = [np.ones(6)] * 3
    assert log_odds(even, asked) > 1.5
    assert log_odds(own, asked) < 0.5


def test_runs_too_short_for_blocks_say_nothing() -> None:
    sound = [ratios(seed) for seed in range(3)]
    assert log_odds(sound, [np.full(2, np.nan)]) == pytest.approx(0.0)


def test_it_is_weighed_beside_each_change() -> None:
    ranking = tuple(
        Change(name, (), (), 0.0, share, NO_SIZE, NO_SIZE)
        for name, share in ((NONE, 0.6), ("lift", 0.38), (UNKNOWN, 0.02))
    )
    found = with_disturbance(ranking, {NONE: np.log(240.0), "lift": np.log(24.0)})
    share = {one.name: one.probability for one in found}
    assert sum(share.values()) == pytest.approx(1.0)
    # a prior of 0.025 to the 0.6 of none: 10 times as likely as none, once as lift
    assert share[UNKNOWN] / share[NONE] == pytest.approx((10 * 0.6 + 0.38 + 0.02) / 0.6)
    assert share["lift"] / share[NONE] == pytest.approx(0.38 / 0.6)
    assert found[0].name == UNKNOWN
    assert found[0].evidence == pytest.approx(np.log((10 * 0.6 + 0.38 + 0.02) / 0.02))
