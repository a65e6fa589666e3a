"""Readings that do not stand in the rows of a table."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from pipeline.records.run_table import OffRow

TIME_S = 0.02 * np.arange(101)


@given(st.integers(0, 10_000), st.floats(3.0, 45.0))
def test_every_reading_is_had_back(seed: int, rate_hz: float) -> None:
    """At less than the rate of the table each reading has a row of its own."""
    generator = np.random.default_rng(seed)
    reading_s = generator.uniform(0.0, 0.01) + np.arange(0.0, 1.98, 1.0 / rate_hz)
    readings = generator.standard_normal((reading_s.size, 2))
    values = np.stack([np.interp(TIME_S, reading_s, one) for one in readings.T], axis=1)
    off = OffRow.of(TIME_S, values, reading_s, readings)
    assert off is not None
    row = np.rint(reading_s / 0.02).astype(int)
    assert_allclose(TIME_S[row] + off.late_s[row], reading_s, atol=1e-12)
    assert_allclose(values[row] + off.more[row], readings, atol=1e-12)
    assert np.abs(off.late_s).max() <= 0.01 + 1e-9


def test_readings_in_their_rows_need_nothing() -> None:
    values = np.arange(101.0)[:, None]
    assert OffRow.of(TIME_S, values, TIME_S[::5], values[::5]) is None
    assert OffRow.of(TIME_S[:1], values[:1], TIME_S[:1] + 0.005, values[:1]) is None


def test_of_several_readings_the_nearest_is_taken() -> None:
    readings = np.array([[1.0], [2.0], [3.0]])
    off = OffRow.of(TIME_S, np.zeros((101, 1)), np.array([0.995, 1.002, 1.007]), readings)
    assert off is not None
    assert_allclose([off.late_s[50], off.more[50, 0]], [0.002, 2.0])
    assert_array_equal(np.flatnonzero(off.late_s), [50])


def test_a_quaternion_may_have_the_other_sign() -> None:
    values = np.tile([1.0, 0.0, 0.0, 0.0], (101, 1))
    off = OffRow.of(TIME_S, values, np.array([1.005]), np.array([[-0.8, -0.6, 0.0, 0.0]]))
    assert off is not None
    assert_allclose(off.more[50], [-0.2, 0.6, 0.0, 0.0], atol=1e-15)


def test_nothing_is_made_up_where_the_table_has_nothing() -> None:
    off = OffRow.of(TIME_S, np.full((101, 1), np.nan), np.array([1.005]), np.array([[3.0]]))
    assert off is not None
    assert np.isfinite(off.more).all()
