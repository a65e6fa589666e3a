"""Velocity from positions, against the motion that made them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.position_speed import velocity_of_position
from pipeline.records.run_table import RunTable

PERIOD_S = 0.02
SURGE_MPS, YAW_RATE = 0.4, 0.3
POSITION = ChannelNoise("position", "m", 0.005, rate_hz=10.0)


def circle(noise_m: float = 0.0) -> RunTable:
    """Go ahead at constant speed in a circle; positions ten times a second, on a line between."""
    time = PERIOD_S * np.arange(1001)
    heading = YAW_RATE * time
    radius = SURGE_MPS / YAW_RATE
    place = np.column_stack(
        [radius * np.sin(heading), radius * (1 - np.cos(heading)), np.full(time.size, 2.0)]
    )
    read = place[::5] + noise_m * np.random.default_rng(1).standard_normal(place[::5].shape)
    position = np.column_stack([np.interp(time, time[::5], column) for column in read.T])
    attitude = np.column_stack([np.cos(heading / 2), np.zeros((time.size, 2)), np.sin(heading / 2)])
    known = np.ones(time.size, bool)
    return RunTable(
        "circle",
        time,
        {"position": position, "attitude": attitude},
        {"position": known, "attitude": known.copy()},
    )


@pytest.mark.parametrize(("noise_m", "within"), [(0.0, 0.002), (0.005, 0.045)])
def test_speed_ahead_is_found_in_body_axes(noise_m: float, within: float) -> None:
    found = velocity_of_position(circle(noise_m), [POSITION])
    assert found is not None
    velocity, known = found
    # nothing is made up within half the slope's length of the ends
    assert known.mean() == pytest.approx(1.0 - 0.7 / 20.0, abs=0.005)
    np.testing.assert_allclose(velocity[known], [[SURGE_MPS, 0.0, 0.0]] * known.sum(), atol=within)


def test_a_gap_of_the_positions_shows_no_speed() -> None:
    run = circle()
    run.valid["position"][400:450] = False
    found = velocity_of_position(run, [POSITION])
    assert found is not None
    assert not found[1][390:460].any()
    assert found[1][200:380].all()


def test_a_measured_velocity_or_a_position_not_sure_leaves_it() -> None:
    run = circle()
    assert velocity_of_position(run, [replace(POSITION, white=1.0)]) is None
    assert velocity_of_position(run, []) is None
    run.values["velocity"] = np.zeros((run.time_s.size, 3))
    run.valid["velocity"] = np.ones(run.time_s.size, bool)
    assert velocity_of_position(run, [POSITION]) is None
