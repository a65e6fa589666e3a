"""Attitude errors against a rotation library, and readings between the steps of a simulation."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.identify.channel_noise import ChannelNoise, channel_noise
from pipeline.identify.window_outputs import (
    Rows,
    innovations,
    lines_of,
    stack_windows,
    turn_between,
)
from pipeline.identify.windows import cut
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import fly
from pipeline.simulate.kernel import STATE
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.sensor_schema import Depth, Dvl, Imu, Sensors


def test_turns_are_those_of_a_rotation_library() -> None:
    generator = np.random.default_rng(0)
    first = generator.standard_normal((300, 4))
    second = np.concatenate(
        [generator.standard_normal((100, 4)), -2.0 * first[100:200], first[200:] + 1e-9]
    )
    expected = (
        Rotation.from_quat(first[:, [1, 2, 3, 0]]).inv()
        * Rotation.from_quat(second[:, [1, 2, 3, 0]])
    ).as_rotvec()
    assert_allclose(turn_between(first, second), expected, atol=1e-14)


def test_only_what_is_not_finite_stays_so() -> None:
    first = np.array([[1.0, 0.0, 0.0, 0.0], [np.nan, 0.0, 0.0, 0.0]])
    found = turn_between(first, np.tile([1.0, 0.0, 0.0, 0.0], (2, 1)))
    assert_allclose(found[0], 0.0)
    assert np.isnan(found[1]).all()


def test_readings_lie_on_the_line_and_no_line_crosses_stretches() -> None:
    motion = np.array([0.0, 10.0, 20.0, 0.0, -10.0, -20.0, 5.0])[:, None]
    stretch = np.array([0, 0, 0, 1, 1, 1, 2])
    sample = np.array([0, 1, 2, 2, 3, 6])
    late = np.array([0.3, -0.2, -0.1, 0.4, -0.5, 0.3])
    channel = ChannelNoise("depth", "m", 0.1)
    rows = Rows(channel, sample, late, stretch[sample], np.zeros((6, 1)), ())
    found = lines_of(rows, np.array([0, 3, 6, 7])).at(motion)
    # the last window is a single sample: there is no line
    assert_allclose(found[:, 0], [3.0, 8.0, 19.0, 24.0, 5.0, 5.0])


def test_a_model_that_is_right_is_off_by_little_whenever_it_is_read() -> None:
    """Sensors without noise whose readings never meet a row; left in the rows they miss by more."""
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    packed = pack_vehicle(vehicle)
    sensors = Sensors(
        command_rate_hz=50.0,
        imu=Imu(rate_hz=35.0, position_m=(0.1, 0.0, -0.05)),
        dvl=Dvl(rate_hz=7.0, position_m=(-0.15, 0.0, 0.12)),
        depth=Depth(rate_hz=9.0),
    )
    flown = fly(packed, MANOEUVRES["multisine"].plan(packed, 1.0, 12.0))
    table = table_of_log(measure(flown, packed, sensors, seed=0), sensors)
    channels = channel_noise(sensors, [table])

    def worst(run: RunTable) -> dict[str, float]:
        windows = cut(packed, [run], channels, 4.0)
        starts = np.zeros((len(windows), STATE))
        for number, window in enumerate(windows):
            at = round(window.begin_s / 0.02)
            starts[number] = window.start
            starts[number, :13] = np.concatenate(
                [flown.position_ned_m[at], flown.quaternion[at], flown.nu[at]]
            )
        stack = stack_windows(packed, windows, channels)
        found = innovations(stack, packed.vector, starts)
        return {
            rows.channel.quantity: float(np.abs(values).max())
            for rows, values in zip(stack.rows, found, strict=True)
        }

    right, in_rows = worst(table), worst(replace(table, off_row={}))
    assert {"velocity", "depth"} <= set(table.off_row)
    for quantity in table.off_row:
        assert right[quantity] < 0.3 * in_rows[quantity], quantity
