"""Identification of a measured vehicle without velocity: what its pool runs can tell, they do."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.identify.whole_vehicle import identify_vehicle
from pipeline.inputs.runs_to_identify import read_run
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.records.identification import VehicleIdentification
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import actuator_states, thruster_wrench
from pipeline.simulate.context import model_of

YAW = ("added_mass_yaw", "linear_damping_yaw", "quadratic_damping_yaw", "thruster_lag")


@pytest.fixture(scope="module")
def rov(repository: Path) -> SimulatedVehicle:
    return load_simulated(str(repository / "tests/acceptance/exjobbrov"), Path("raw"), Path())


@pytest.fixture(scope="module")
def yaw_run(shared_data: Path, rov: SimulatedVehicle) -> RunTable:
    """Sines of the yaw moment; the gyroscope alone, as the attitude is a filter's estimate."""
    paths = sorted((shared_data / "exjobbrov_pool").glob("sinPsi*.mcap"))
    if not paths:
        pytest.skip(f"no pool runs in {shared_data}")
    left_out = ("attitude", "specific_force", "depth")
    return read_run(paths[0], rov, shared_data, left_out)[1]


@pytest.fixture(scope="module")
def fit(rov: SimulatedVehicle, yaw_run: RunTable) -> VehicleIdentification:
    assert rov.vehicle.sensors is not None
    return identify_vehicle(
        rov.packed,
        rov.vehicle.sensors,
        [yaw_run],
        uncertainty=model_of(rov.vehicle).uncertainty,
        only=YAW,
        window_s=4.0,
        suggest=False,
    )


def test_the_fit_predicts_better_than_the_file_and_the_last_value(
    fit: VehicleIdentification,
) -> None:
    """On a window that took no part; still an order above the sensor's noise, and that is said."""
    assert fit.converged
    (rates,) = fit.quality
    assert rates.rmse_identified is not None
    assert rates.rmse_vehicle_file is not None
    assert rates.rmse_last_value is not None
    assert rates.rmse_identified < 0.8 * rates.rmse_vehicle_file
    assert rates.rmse_identified < 0.5 * rates.rmse_last_value
    assert rates.rmse_identified > 5 * rates.sensor_noise
    assert any("the model lacks something" in note for note in fit.notes)


def test_yaw_inertia_is_that_of_a_plain_regression(
    rov: SimulatedVehicle, yaw_run: RunTable, fit: VehicleIdentification
) -> None:
    """Another way to the same number: moment over smoothed yaw acceleration with linear drag."""
    known = yaw_run.valid["angular_velocity"] & yaw_run.valid["command"]
    time_s = yaw_run.time_s[known]
    state = actuator_states(rov.packed, np.nan_to_num(yaw_run.values["command"]), 0.02)
    moment = thruster_wrench(rov.packed, state[: known.size], np.zeros((known.size, 6)))[0][:, 5]
    rate = yaw_run.values["angular_velocity"][known, 2]
    # both sides as means over a fifth of a second
    width = 11
    smooth = np.convolve(rate, np.ones(width) / width, "same")
    slope = np.gradient(smooth, time_s)
    push = np.convolve(moment[known], np.ones(width) / width, "same")
    inner = slice(width, -width)
    design = np.column_stack([push, smooth, smooth * np.abs(smooth), np.ones(smooth.size)])[inner]
    found = np.linalg.lstsq(design, slope[inner], rcond=None)[0]
    added = next(p for p in fit.parameters if p.name == "added_mass_yaw")
    own = model_of(rov.vehicle).rigid_body.inertia_kgm2[2]
    assert own + added.value == pytest.approx(1.0 / found[0], rel=0.35)
