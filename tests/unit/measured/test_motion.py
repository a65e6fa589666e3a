"""The motion that a run shows."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.measured.motion import _rates_are_steadier, _steadied, measured_motion
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.sensor_schema import Imu

PERIOD_S = 0.05
TIME_S = PERIOD_S * np.arange(2400)


def turning() -> tuple[Rotation, FloatArray]:
    """Roll, pitch and turn for two minutes; rates half a period later are those between rows."""
    roll, pitch = 0.02 * np.sin(1.9 * TIME_S), 0.03 * np.sin(1.1 * TIME_S)
    true = Rotation.from_euler("ZYX", np.stack([3.0 + 0.4 * TIME_S, pitch, roll], axis=1))
    between = (true[:-1].inv() * true[1:]).as_rotvec() / PERIOD_S
    rates = np.concatenate([between[:1], 0.5 * (between[1:] + between[:-1]), between[-1:]])
    return true, rates


def change_of_error(found: Rotation, true: Rotation) -> float:
    """Standard deviation of how the error of roll and pitch changes within a second [rad]."""
    off = (found * true.inv()).as_rotvec()[:, :2]
    return float(np.std(np.diff(off[:: round(1.0 / PERIOD_S)], axis=0)))


def test_a_wandering_attitude_is_steadied_by_the_rates() -> None:
    true, rates = turning()
    generator = np.random.default_rng(5)
    wander = np.zeros((TIME_S.size, 3))
    keep = np.exp(-PERIOD_S / 20.0)
    for row in range(1, TIME_S.size):
        step = np.sqrt(1.0 - keep**2) * 5e-3 * generator.standard_normal(3)
        wander[row] = keep * wander[row - 1] + step
    read = Rotation.from_rotvec(wander) * true
    bias = np.array([6e-4, -6e-4, 3e-4])
    noise = 1.2e-3 * generator.standard_normal(rates.shape)
    steady = _steadied(read, rates + bias + noise, PERIOD_S, 60.0)
    assert change_of_error(steady, true) < 0.4 * change_of_error(read, true)


def test_an_attitude_that_does_not_wander_stays() -> None:
    true, rates = turning()
    steady = _steadied(true, rates, PERIOD_S, 60.0)
    assert np.abs((steady * true.inv()).as_rotvec()).max() < 5e-4


def test_rates_that_walk_more_than_the_attitude_wanders_steady_nothing() -> None:
    good = Imu(
        rate_hz=50.0, rate_noise_radps=1.2e-3, attitude_wander_rad=5e-3, attitude_wander_s=25.0
    )
    assert _rates_are_steadier(good)
    # of motion capture, by differences
    poor = good.model_copy(update={"rate_hz": 5.0, "rate_noise_radps": 1.6e-2})
    assert not _rates_are_steadier(poor)
    assert not _rates_are_steadier(good.model_copy(update={"attitude_wander_rad": 0.0}))


@pytest.mark.parametrize("name", ["rov8", "cargo_carrier"])
def test_a_velocity_follows_the_accelerometer(name: str) -> None:
    vehicle = load_vehicle(bundled_vehicle(name))
    packed, sensors = pack_vehicle(vehicle), vehicle.sensors
    assert sensors is not None
    flown = fly(packed, MANOEUVRES["multisine"].plan(packed, 1.0, 40.0))
    run = table_of_log(measure(flown, packed, sensors, seed=2), sensors, name="run")
    true = np.stack(
        [np.interp(run.time_s - run.time_s[0], flown.time_s, one) for one in flown.nu[:, :3].T], 1
    )
    alone = replace(run, values={k: v for k, v in run.values.items() if k != "specific_force"})
    found = {with_it: measured_motion(one, sensors) for with_it, one in ((1, run), (0, alone))}
    assert found[1].follows
    assert not found[0].follows
    inside = slice(100, -100)
    error = {k: np.std((one.nu[:, :3] - true)[inside], axis=0) for k, one in found.items()}
    assert (error[1] < 0.75 * error[0]).all(), error
