"""Commands that change within a step: what they do to a drive is kept."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from pipeline.records.run_table import mean_held
from pipeline.types import FloatArray

STEP_S = 0.02
TIME_S = STEP_S * np.arange(200)


def sent(seed: int, rate_hz: float) -> tuple[FloatArray, FloatArray]:
    """Commands of two thrusters, about so many a second, from a little before the table on."""
    generator = np.random.default_rng(seed)
    count = int(5.0 * rate_hz)
    apart = generator.uniform(0.5, 1.5, count) / rate_hz
    return np.cumsum(apart) - 0.5, np.round(generator.uniform(-100, 100, (count, 2)))


@given(st.integers(0, 10_000), st.floats(2.0, 200.0))
def test_what_acts_over_a_run_is_kept(seed: int, rate_hz: float) -> None:
    sent_s, codes = sent(seed, rate_hz)
    held = mean_held(sent_s, codes, TIME_S, STEP_S)
    # a fine sum over what holds at the time, written anew
    fine_s = np.arange(0.0, TIME_S[-1] + STEP_S, 1e-4) + 5e-5
    index = np.clip(np.searchsorted(sent_s, fine_s, side="right") - 1, 0, None)
    assert_allclose(held.sum(axis=0) * STEP_S, codes[index].sum(axis=0) * 1e-4, atol=0.5)
    assert (held >= codes.min(axis=0) - 1e-6).all()
    assert (held <= codes.max(axis=0) + 1e-6).all()


def test_a_command_that_holds_for_the_step_is_itself() -> None:
    sent_s = 5 * STEP_S * np.arange(41)
    codes = np.random.default_rng(0).integers(-100, 100, (41, 3)).astype(float)
    held = mean_held(sent_s, codes, TIME_S, STEP_S)
    assert_array_equal(held, np.repeat(codes, 5, axis=0)[: len(TIME_S)])


def test_a_lagging_drive_is_left_where_the_commands_leave_it() -> None:
    """Commands every 50 ms on rows of 20 ms; one that is early or late is ten times as far off."""
    sent_s = 0.05 * np.arange(80)
    codes = np.random.default_rng(1).uniform(-100, 100, (80, 1))
    lag_s, fine_s = 0.1, 1e-4

    def end_of(commands: FloatArray, step_s: float) -> FloatArray:
        state, found = 0.0, []
        for code in commands[:, 0]:
            state += (1.0 - np.exp(-step_s / lag_s)) * (code - state)
            found.append(state)
        return np.array(found)

    each = np.arange(0.0, 4.0, fine_s) + 0.5 * fine_s
    true = end_of(codes[np.searchsorted(sent_s, each, side="right") - 1], fine_s)[199::200]
    off = np.abs(end_of(mean_held(sent_s, codes, TIME_S, STEP_S), STEP_S) - true).max()
    at_begin = codes[np.searchsorted(sent_s, TIME_S + 1e-9, side="right") - 1]
    assert off < 0.1 * np.abs(end_of(at_begin, STEP_S) - true).max()
