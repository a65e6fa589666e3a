"""Smoothers: what they claim about bandwidth and noise, against signals and noise themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import CannotComputeError
from pipeline.identify.smoothing import (
    Method,
    local_polynomial,
    moving_average,
    smooth,
    smoother_of_bandwidth,
    white_noise_std,
)

METHODS: tuple[Method, ...] = ("moving_average", "local_polynomial")


def test_savitzky_golay_gains_by_their_formulas() -> None:
    """Slope of a cubic through seven points: (22, -67, -58, 0, 58, 67, -22) / (252 T)."""
    period = 0.2
    smoother = local_polynomial(7, period)
    known = np.array([22, -67, -58, 0, 58, 67, -22]) / (252 * period)
    np.testing.assert_allclose(smoother.derivative, known, atol=1e-12)
    assert smoother.derivative_noise_gain == pytest.approx(np.linalg.norm(known))


@pytest.mark.parametrize("method", METHODS)
def test_noise_that_is_left_is_what_was_promised(method: Method) -> None:
    smoother = smoother_of_bandwidth(method, 0.5, 0.05)
    noise = np.random.default_rng(0).standard_normal(200_000)
    found = smooth(0.3 * noise, smoother)
    left = 0.3 * smoother.derivative_noise_gain
    assert found.derivative[found.valid].std() == pytest.approx(left, rel=0.03)


@pytest.mark.parametrize("method", METHODS)
def test_a_sine_at_the_bandwidth_loses_three_decibels(method: Method) -> None:
    smoother = smoother_of_bandwidth(method, 0.4, 0.02)
    time_s = np.arange(0, 100, 0.02)
    turn = 2 * np.pi * smoother.derivative_bandwidth_hz
    found = smooth(np.sin(turn * time_s), smoother)
    amplitude = np.sqrt(2) * (found.derivative / turn)[found.valid].std()
    assert amplitude == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_at_equal_bandwidth_the_polynomial_leaves_less_noise_in_the_derivative() -> None:
    """The reason to put it beside the paper's mean, measured at one bandwidth."""
    mean = smoother_of_bandwidth("moving_average", 0.5, 0.02)
    polynomial = smoother_of_bandwidth("local_polynomial", 0.5, 0.02)
    assert polynomial.derivative_bandwidth_hz == pytest.approx(
        mean.derivative_bandwidth_hz, rel=0.05
    )
    assert polynomial.derivative_noise_gain < 0.8 * mean.derivative_noise_gain


@given(
    coefficients=st.lists(st.floats(-2, 2), min_size=4, max_size=4),
    half=st.integers(3, 12),
    period=st.floats(0.01, 0.5),
)
@settings(deadline=None)
def test_a_cubic_passes_a_local_polynomial_unchanged(
    coefficients: list[float], half: int, period: float
) -> None:
    smoother = local_polynomial(2 * half + 1, period)
    time_s = period * np.arange(-30, 31)
    cubic = np.polynomial.Polynomial(coefficients)
    found = smooth(cubic(time_s), smoother)
    scale = 1.0 + np.abs(cubic(time_s)).max()
    np.testing.assert_allclose(
        found.value[found.valid], cubic(time_s)[found.valid], atol=1e-9 * scale
    )
    np.testing.assert_allclose(
        found.derivative[found.valid],
        cubic.deriv()(time_s)[found.valid],
        atol=1e-8 * scale / period,
    )


def test_nothing_is_made_up_near_ends_and_gaps() -> None:
    values = np.ones((50, 2))
    values[20, 1] = np.nan
    found = smooth(values, local_polynomial(5, 0.1))
    assert np.flatnonzero(~found.valid).tolist() == [0, 1, *range(18, 23), 48, 49]
    np.testing.assert_allclose(found.value[found.valid], 1.0)


def test_noise_is_found_under_motion_and_outliers() -> None:
    generator = np.random.default_rng(1)
    time_s = np.arange(0, 60, 0.1)
    values = 2 * np.sin(0.5 * time_s) + 0.01 * generator.standard_normal(time_s.size)
    values[::97] += 5.0
    assert white_noise_std(values) == pytest.approx(0.01, rel=0.15)


@pytest.mark.parametrize(("samples", "period"), [(4, 0.1), (0, 0.1), (5, 0.0)])
def test_impossible_smoothers_are_refused(samples: int, period: float) -> None:
    with pytest.raises(CannotComputeError, match="odd number of samples"):
        moving_average(samples, period)


def test_a_bandwidth_beyond_the_samples_is_refused_with_what_they_carry() -> None:
    with pytest.raises(CannotComputeError, match=r"0\.2 s carry a derivative up to"):
        smoother_of_bandwidth("local_polynomial", 3.0, 0.2)
