"""Where a window starts, by what was measured there."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.windows import cut
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import pack_vehicle
from pipeline.vehicle.load import load_vehicle

PERIOD_S = 0.02
SURGE_MPS, YAW_RATE = 0.4, 0.3


def circle() -> RunTable:
    """Go ahead at constant speed in a circle; positions ten times a second, on a line between."""
    time = PERIOD_S * np.arange(1001)
    heading = YAW_RATE * time
    radius = SURGE_MPS / YAW_RATE
    place = np.column_stack(
        [radius * np.sin(heading), radius * (1 - np.cos(heading)), np.full(time.size, 2.0)]
    )
    place = np.column_stack([np.interp(time, time[::5], column) for column in place[::5].T])
    attitude = np.column_stack([np.cos(heading / 2), np.zeros((time.size, 2)), np.sin(heading / 2)])
    values = {"position": place, "attitude": attitude, "command": np.zeros((time.size, 8))}
    return RunTable("circle", time, values, {name: np.ones(time.size, bool) for name in values})


@pytest.mark.parametrize(("white_m", "surge_mps"), [(0.005, SURGE_MPS), (1.0, 0.0)])
def test_a_sure_position_shows_the_speed_and_is_no_measurement_of_it(
    white_m: float, surge_mps: float
) -> None:
    packed = pack_vehicle(load_vehicle(bundled_vehicle("rov8")))
    channel = ChannelNoise("position", "m", white_m, rate_hz=10.0)
    windows = cut(packed, [circle()], [channel, ChannelNoise("attitude", "rad", 1e-3)])
    for window in windows:
        assert window.start[7] == pytest.approx(surge_mps, abs=0.01)
        assert abs(window.start[8]) < 0.05
        assert not window.known[:3].any()
