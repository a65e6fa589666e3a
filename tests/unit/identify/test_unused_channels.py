"""What to do about a channel that no window has: state its true rate, or see what it lost."""

import numpy as np
import pytest

from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.unused_channels import notes_on_unused
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray

TIME_S = np.arange(0.0, 60.0, 0.02)
DVL = ChannelNoise("velocity", "m/s", white=0.01, wander=0.0, bias=0.0, rate_hz=8.0)


def run(reading: BoolArray) -> RunTable:
    """One minute of a DVL of 8 Hz, of which these readings are valid."""
    return RunTable(
        "dive",
        TIME_S,
        {"velocity": np.zeros((TIME_S.size, 3)), "command": np.zeros((TIME_S.size, 1))},
        {"velocity": reading, "command": np.ones(TIME_S.size, bool)},
        reading={"velocity": reading},
    )


def every(samples: int) -> BoolArray:
    return np.arange(TIME_S.size) % samples == 0


def test_a_slow_channel_is_to_have_its_true_rate_stated() -> None:
    (note,) = notes_on_unused([run(every(50))], [DVL], set())
    assert "velocity (1 Hz in these runs, 8 Hz expected)" in note
    assert "state the sensor's true rate_hz" in note


@pytest.mark.parametrize("scattered", [False, True])
def test_a_channel_that_lost_its_readings_keeps_its_rate(*, scattered: bool) -> None:
    """No bottom but for six seconds of the minute, or one reading of five."""
    lost = np.random.default_rng(1).random(TIME_S.size) > 0.2 if scattered else TIME_S > 6.0
    (note,) = notes_on_unused([run(every(6) & ~lost)], [DVL], set())
    assert "rate_hz" not in note
    assert "% of the readings, 8 Hz expected)" in note
    assert "most of its readings are invalid or missing" in note


def test_runs_without_the_channel_take_no_part_in_its_rate() -> None:
    without = RunTable(
        "other", TIME_S, {"command": np.zeros((TIME_S.size, 1))}, {"command": every(1)}
    )
    alone = notes_on_unused([run(every(50))], [DVL], set())
    assert notes_on_unused([run(every(50)), without, without], [DVL], set()) == alone
    lost = run(every(6) & (TIME_S < 6.0))
    assert "(10 % of" in notes_on_unused([lost, without], [DVL], set())[0]


def test_a_channel_that_is_used_needs_no_note() -> None:
    assert notes_on_unused([run(every(50))], [DVL], {"velocity"}) == ()
    # two readings too few to have a rate
    (note,) = notes_on_unused([run(TIME_S == 0.0)], [DVL], set())
    assert "(0 % of the readings" in note
