"""A velocity that follows accelerations at the level of its readings."""

import numpy as np
import pytest

from pipeline.physics.complementary_filter import followed

PERIOD_S, EVERY = 0.02, 10


def flown(noise_mps: float, drift_mps2: float, seconds: float = 60.0) -> tuple[np.ndarray, ...]:
    """Time, true velocity (m, 3), its readings, where they are, and the accelerations' sum."""
    draw = np.random.default_rng(5)
    time_s = np.arange(0.0, seconds, PERIOD_S)
    true = np.stack([np.sin(time_s), 0.3 * np.sin(2.1 * time_s), 0.1 * np.cos(0.7 * time_s)], 1)
    read = np.arange(time_s.size) % EVERY == 0
    readings = true + noise_mps * draw.standard_normal(true.shape)
    summed = true - 3.0 + drift_mps2 * time_s[:, None]
    return time_s, true, readings, read, summed


def test_noise_falls_with_the_readings_of_a_level_and_a_steady_drift_does_not_stay() -> None:
    _, true, readings, read, summed = flown(0.01, 0.05)
    found = followed(readings, read, summed, PERIOD_S)
    assert found is not None
    inside = slice(100, -100)
    error = float(np.std((found - true)[inside]))
    # eleven readings in two seconds
    assert error == pytest.approx(0.01 / 11**0.5, rel=0.15)


def test_without_noise_it_is_the_velocity() -> None:
    _, true, readings, read, summed = flown(0.0, 0.0)
    found = followed(readings, read, summed, PERIOD_S)
    assert found is not None
    np.testing.assert_allclose(found, true, atol=1e-12)


def test_accelerations_that_foretell_readings_worse_than_their_neighbours_are_not_taken() -> None:
    time_s, _, readings, read, _ = flown(0.001, 0.0)
    other = 0.5 * np.sin(1.3 * time_s)[:, None] * np.ones(3)
    assert followed(readings, read, other, PERIOD_S) is None


def test_a_run_shorter_than_the_level_is_left_alone() -> None:
    _, _, readings, read, summed = flown(0.01, 0.0, seconds=1.5)
    assert followed(readings, read, summed, PERIOD_S) is None
