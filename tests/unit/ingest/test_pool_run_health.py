"""What is wrong with readings: injected faults are found where they are, clean data are left."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pool_logs import SECOND_NS, ticks

from pipeline.ingest.pool_run_health import command_marks, rhythm_of, time_marks, value_marks
from pipeline.types import BoolArray, FloatArray


def motion(count: int = 2000, seed: int = 0) -> FloatArray:
    """Three rates at 100 Hz: slow motion with noise."""
    time_s = np.arange(count) / 100.0
    slow = np.stack([np.sin(0.7 * time_s), np.cos(1.1 * time_s), np.sin(2.0 * time_s)], axis=1)
    return slow + 0.01 * np.random.default_rng(seed).standard_normal((count, 3))


def where(marks: dict[str, BoolArray], name: str) -> list[int]:
    return np.flatnonzero(marks[name]).tolist() if name in marks else []


@given(seed=st.integers(0, 10_000))
def test_clean_data_have_no_marks(seed: int) -> None:
    assert value_marks(motion(seed=seed), 0.01) == {}


@given(
    at=st.integers(40, 1900),
    size=st.floats(0.5, 1e6) | st.floats(-1e6, -0.5),
    column=st.integers(0, 2),
)
def test_one_spike_is_found_where_it_is(at: int, size: float, column: int) -> None:
    values = motion()
    values[at, column] += size
    assert where(value_marks(values, 0.01), "spike") == [at]


def test_a_step_is_no_spike() -> None:
    values = motion()
    values[1000:] += 5.0
    assert value_marks(values, 0.01) == {}


def test_noise_that_grows_has_no_spikes() -> None:
    values = motion()
    values[1500:] += 0.3 * np.random.default_rng(1).standard_normal((500, 3))
    assert value_marks(values, 0.01) == {}


def test_an_attitude_that_changes_its_sign_is_no_spike() -> None:
    angle = np.linspace(0.0, 8.0, 2000)
    q = np.stack([np.cos(angle), np.sin(angle), 0 * angle, 0 * angle], axis=1)
    q += 1e-4 * np.random.default_rng(0).standard_normal(q.shape)
    q[500:600] *= -1.0
    q[900] *= -1.0
    assert where(value_marks(q, 0.01, is_quaternion=True), "spike") == []
    assert where(value_marks(q, 0.01), "spike") == [900]


def test_not_a_number_is_marked() -> None:
    values = motion()
    values[10, 1] = np.nan
    values[11, 2] = np.inf
    assert where(value_marks(values, 0.01), "not_a_number") == [10, 11]


def test_a_frozen_sensor_is_found_from_the_reading_that_it_repeats() -> None:
    values = motion()
    values[501:700] = values[500]
    marks = value_marks(values, 0.01)
    assert where(marks, "frozen") == list(range(500, 700))
    assert "saturated" not in marks


def test_zeros_in_the_midst_of_motion_are_a_dropout() -> None:
    values = motion()
    values[300:330] = 0.0
    assert where(value_marks(values, 0.01), "dropout") == list(range(300, 330))


def test_a_vehicle_that_starts_at_rest_has_no_dropout() -> None:
    time_s = np.arange(2000) / 100.0
    speed = np.where(time_s < 5.0, 0.0, 1.0 - np.exp(-(time_s - 5.0)))
    values = np.stack([speed, 0.5 * speed, 0.1 * speed], axis=1)
    assert "dropout" not in value_marks(values, 0.01)


def test_readings_that_stick_to_the_end_of_the_range_are_saturated() -> None:
    values = np.clip(motion()[:, :1], -0.95, 0.95)
    marks = value_marks(values, 0.01)
    at_the_end = np.abs(values[:, 0]) == 0.95
    np.testing.assert_array_equal(marks["saturated"], at_the_end)
    assert "frozen" not in marks
    assert value_marks(motion()[:, :1], 0.01) == {}


def test_a_stated_range_marks_what_is_at_and_beyond_it() -> None:
    values = np.array([[-2.0], [-1.0], [0.0], [1.0], [1.5]])
    marks = value_marks(values, 0.01, lowest=-1.0, highest=1.0)
    assert where(marks, "outside_range") == [0, 4]
    assert where(marks, "saturated") == [1, 3]


def test_commands_at_and_beyond_the_range_of_their_drives() -> None:
    values = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 60.0], [np.nan, 0.0]])
    marks = command_marks(values, np.array([-100.0, -50.0]), np.array([100.0, 50.0]))
    assert where(marks, "saturated") == [1]
    assert where(marks, "outside_range") == [2]
    assert where(marks, "not_a_number") == [3]


def test_gaps_duplicates_and_order() -> None:
    time_ns = ticks(1000, 100.0)
    values = motion(1000)
    time_ns[500:] += SECOND_NS  # a gap before 500
    time_ns[200] = time_ns[199]
    values[200] = values[199]  # a duplicate
    time_ns[300] = time_ns[299]  # two readings of one time
    time_ns[[700, 701]] = time_ns[[701, 700]]  # out of order
    rhythm = rhythm_of(time_ns)
    marks = time_marks(time_ns, values, rhythm)
    assert where(marks, "after_gap") == [500]
    assert where(marks, "duplicate") == [200]
    assert where(marks, "same_stamp") == [300]
    assert where(marks, "out_of_order") == [701]
    assert rhythm.period_s == pytest.approx(0.01)
    assert rhythm.longest_gap_s == pytest.approx(1.01)


def test_commands_sent_on_change_have_no_gaps() -> None:
    steps = np.random.default_rng(0).exponential(1.0, 300)
    time_ns = (np.cumsum(steps) * SECOND_NS).astype(np.int64)
    rhythm = rhythm_of(time_ns)
    assert not rhythm.is_regular
    assert not rhythm.gaps.any()


def test_bursts_of_a_serial_line_are_regular() -> None:
    """Two messages at once, then nothing for a while: the mean says the rate."""
    time_ns = np.repeat(ticks(500, 50.0), 2)
    time_ns[1::2] += 200_000
    rhythm = rhythm_of(time_ns)
    assert rhythm.is_regular
    assert rhythm.period_s == pytest.approx(0.01, rel=0.05)
    assert not rhythm.gaps.any()


@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_short_channels(count: int) -> None:
    values, time_ns = motion(count), ticks(count, 100.0)
    rhythm = rhythm_of(time_ns)
    assert time_marks(time_ns, values, rhythm) == {}
    assert value_marks(values, rhythm.period_s) == {}


def test_a_level_attitude_is_not_saturated() -> None:
    """Level is w = 1, the very end of its range, however many readings say so."""
    tilt = 3e-3 * np.random.default_rng(0).standard_normal((400, 3))
    q = np.rint(np.hstack([np.sqrt(1.0 - (tilt**2).sum(axis=1))[:, None], tilt]) * 2**14) / 2**14
    assert value_marks(q, 0.04, is_quaternion=True) == {}
    assert "saturated" in value_marks(q, 0.04)


def test_a_shaft_that_jumps_with_its_command_has_no_spike() -> None:
    speed = 500.0 + np.random.default_rng(0).standard_normal((400, 1))
    speed[200] = 1200.0
    assert value_marks(speed, 0.2)["spike"].sum() == 1
    assert value_marks(speed, 0.2, jumps=True) == {}
