"""Which time a reading gets."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pool_logs import SECOND_NS, START_NS, imu_topic, rov, ticks, write_log

from pipeline.ingest.message_fields import NO_STAMP
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_clocks import choose_time, share_clocks
from pipeline.types import IntArray


def logged(stamps: IntArray, seed: int = 0, latency_s: float = 0.01) -> IntArray:
    """Times of the log: a little late, unsteadily."""
    late = latency_s + np.random.default_rng(seed).exponential(0.002, stamps.size)
    return stamps + np.rint(late * SECOND_NS).astype(np.int64)


def test_stamps_of_the_recorders_own_clock_are_taken_as_they_are() -> None:
    stamps = ticks(500, 100.0)
    timing = choose_time(logged(stamps), stamps, None)
    np.testing.assert_array_equal(timing.time_ns, stamps)
    assert timing.clock.used == "header"
    assert timing.clock.offset_s == 0.0
    assert timing.clock.latency_s == pytest.approx(0.0114, abs=0.001)
    assert not timing.marks


def test_a_known_delay_is_no_difference_of_clocks() -> None:
    stamps = ticks(100, 2.0)
    log = logged(stamps, latency_s=1.5)
    assert choose_time(log, stamps, None).clock.offset_s != 0.0
    assert choose_time(log, stamps, None, expected_delay_s=1.5).clock.offset_s == 0.0


@given(
    drift_ppm=st.floats(-5000, 5000),
    offset_s=st.integers(-2_000_000_000, -5) | st.integers(5, 10_000_000),
    seed=st.integers(0, 100),
)
def test_a_boards_clock_is_laid_onto_the_log(drift_ppm: float, offset_s: int, seed: int) -> None:
    """The true times are found but for the median latency, whatever the clock's start and pace."""
    true = ticks(2000, 100.0)
    elapsed = (true - true[0]).astype(float)
    stamps = true + offset_s * SECOND_NS + np.rint(1e-6 * drift_ppm * elapsed).astype(np.int64)
    stamps = stamps - stamps.min() + SECOND_NS if stamps.min() < 0 else stamps
    log = logged(true, seed)
    log[::97] += SECOND_NS // 20  # messages that were held up do not bend the line
    timing = choose_time(log, stamps, "field")
    error = (timing.time_ns - true) / 1e9
    assert np.ptp(error) < 5e-4
    assert np.median(error) == pytest.approx(0.0114, abs=5e-4)
    assert timing.clock.used == "field"
    assert timing.clock.drift_ppm == pytest.approx(-drift_ppm, abs=60.0)


def test_a_clock_that_begins_anew_is_aligned_in_parts() -> None:
    true = ticks(2000, 100.0)
    stamps = true - START_NS + SECOND_NS
    stamps[1200:] -= stamps[1200] - SECOND_NS  # the board restarts
    timing = choose_time(logged(true), stamps, "field")
    assert np.abs((timing.time_ns - true) / 1e9 - 0.0114).max() < 2e-3
    assert np.flatnonzero(timing.marks["reset"]).tolist() == [1200]
    assert timing.clock.segments == 2
    assert "jumps by -12" in timing.warnings[0]
    assert "at 12.0" in timing.warnings[0]


def test_single_wild_stamps_are_marked_and_change_nothing_else() -> None:
    stamps = ticks(1000, 100.0)
    wild = stamps.copy()
    wild[[100, 500]] += 3600 * SECOND_NS
    timing = choose_time(logged(stamps), wild, None)
    assert np.flatnonzero(timing.marks["clock_jump"]).tolist() == [100, 500]
    np.testing.assert_array_equal(timing.time_ns, wild)  # nothing is repaired
    assert timing.clock.segments == 1


def test_messages_without_stamp_take_the_time_of_the_log() -> None:
    stamps = ticks(100, 100.0)
    log = logged(stamps)
    some = stamps.copy()
    some[10] = NO_STAMP
    timing = choose_time(log, some, None)
    assert timing.time_ns[10] == log[10]
    assert np.flatnonzero(timing.marks["no_stamp"]).tolist() == [10]
    for none in (np.full(100, NO_STAMP), np.zeros(100, np.int64), None):
        timing = choose_time(log, none, "header")
        assert timing.clock.used == "log"
        assert timing.warnings
        np.testing.assert_array_equal(timing.time_ns, log)


@pytest.mark.parametrize(("factor", "says"), [(1000, "1000 times"), (0.001, "0.001 times")])
def test_a_clock_in_the_wrong_unit_is_not_believed(factor: float, says: str) -> None:
    true = ticks(1000, 100.0)
    stamps = np.rint((true - START_NS + SECOND_NS) * factor).astype(np.int64)
    timing = choose_time(logged(true), stamps, "field")
    assert timing.clock.used == "log"
    assert says in timing.warnings[0]


def test_stamps_that_stand_still_are_not_used() -> None:
    timing = choose_time(ticks(100, 100.0), np.full(100, START_NS), None)
    assert timing.clock.used == "log"
    assert "never move on" in timing.warnings[0]


def test_the_log_can_be_asked_for() -> None:
    stamps = ticks(100, 100.0)
    log = logged(stamps)
    np.testing.assert_array_equal(choose_time(log, stamps, "log").time_ns, log)


def test_messages_that_were_held_up_are_marked_late() -> None:
    stamps = ticks(1000, 100.0)
    log = logged(stamps)
    log[700:705] += SECOND_NS // 2
    timing = choose_time(log, stamps, None)
    assert np.flatnonzero(timing.marks["late"]).tolist() == [700, 701, 702, 703, 704]


def test_topics_of_one_other_clock_keep_their_times_to_each_other() -> None:
    """A line each would hide that one sensor's messages take longer."""
    true = ticks(1000, 100.0)
    stamps = true - 1000 * SECOND_NS
    logs = {"/quick": logged(true, 1, 0.01), "/slow": logged(true, 2, 0.3)}
    alone = {topic: choose_time(log, stamps, None) for topic, log in logs.items()}
    shared = share_clocks(alone, dict.fromkeys(logs, stamps))
    apart = alone["/slow"].time_ns - alone["/quick"].time_ns
    together = shared["/slow"].time_ns - shared["/quick"].time_ns
    assert np.median(apart) / 1e9 == pytest.approx(0.29, abs=0.01)
    assert np.abs(together).max() == 0


@pytest.mark.parametrize("count", [0, 1, 2, 3, 12])
def test_short_channels_do_not_break_it(count: int) -> None:
    stamps = ticks(count, 100.0)
    timing = choose_time(logged(stamps), stamps, None)
    assert timing.time_ns.size == count
    far = choose_time(logged(stamps), stamps - 500 * SECOND_NS, "field")
    assert far.time_ns.size == count


def test_stamps_of_a_counter_that_begins_anew_are_counted_on(tmp_path: Path) -> None:
    times = ticks(400, 20.0)
    board = [(2**32 - 5_000 + 50 * k) % 2**32 * 10**6 for k in range(400)]
    rates = np.stack([np.sin(0.1 * np.arange(400))] * 3, axis=1)
    path = write_log(tmp_path / "run.mcap", [imu_topic(times, rates, stamps_ns=board)])
    run = read_pool_run(path, rov(), tmp_path)
    assert run.channels["angular_velocity"].clock.segments == 1
    assert not run.channels["angular_velocity"].marks.keys() & {"reset", "clock_jump"}
    said = [one for one in run.problems if "begin anew (/imu/data after 2^32 ms)" in one.what]
    assert [one.severity for one in said] == ["note"]
