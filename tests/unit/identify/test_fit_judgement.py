"""What a fit is judged by: runs that took no part, the file that is handed out, what was unused."""

from dataclasses import replace

import numpy as np
import pytest

from evaluation.identification.coverage import Campaign, simulated_runs
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.commands.identify import _quality
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.corrected_file import file_changes
from pipeline.identify.whole_vehicle import identify_vehicle
from pipeline.identify.window_outputs import turn_between
from pipeline.physics.parameters import read
from pipeline.records.identification import VehicleIdentification
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

HEAVE = (
    *("added_mass_heave", "linear_damping_heave", "quadratic_damping_heave"),
    *("residual_buoyancy", "metacentric_height", "trim_x", "trim_y"),
)
MASSES = ("added_mass_surge", "added_mass_heave")


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle(bundled_vehicle("rov8"))


@pytest.fixture(scope="module")
def sensors(vehicle: Vehicle) -> Sensors:
    assert vehicle.sensors is not None
    return vehicle.sensors


@pytest.fixture(scope="module")
def packed(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


@pytest.fixture(scope="module")
def two_runs(vehicle: Vehicle, packed: PackedVehicle) -> tuple[RunTable, RunTable]:
    """One to fit and one to judge by."""
    campaign = Campaign(vehicle, packed, ("multisine",), 40.0, thrust=False)
    first, second = (simulated_runs(campaign, packed.vector, seed)[0] for seed in (4, 5))
    return first, second


def identified(
    packed: PackedVehicle,
    sensors: Sensors,
    run: RunTable,
    holdout: tuple[RunTable, ...] = (),
    *,
    only: tuple[str, ...] = MASSES,
    doubt: float = 0.0,
) -> VehicleIdentification:
    uncertainty = Uncertainty(thrust=doubt)
    return identify_vehicle(
        packed, sensors, [run], only=only, uncertainty=uncertainty, holdout=holdout, suggest=False
    )


def test_the_file_that_is_handed_out_has_the_thrust_that_was_fitted(
    vehicle: Vehicle, packed: PackedVehicle, sensors: Sensors
) -> None:
    """A vertical thruster gives 85 %: the fit says so, warns, and so does the file it writes."""
    vector = packed.vector.copy()
    vertical = int(np.argmax(np.abs(read(vector, "thruster_direction")[:, 2])))
    read(vector, "thrust_gain")[vertical] *= 0.85
    campaign = Campaign(vehicle, packed, ("heave_steps",), 24.0, thrust=False)
    run, other = (simulated_runs(campaign, vector, seed)[0] for seed in (4, 5))
    found = identified(packed, sensors, run, (other,), only=HEAVE, doubt=0.03)
    rates = next(q for q in found.quality if q.channel == "angular_velocity")
    assert rates.rmse_identified is not None
    assert rates.rmse_corrected_file is not None
    assert rates.rmse_vehicle_file is not None
    assert rates.rmse_identified < 0.2 * rates.rmse_vehicle_file
    assert rates.rmse_corrected_file < 0.25 * rates.rmse_vehicle_file
    assert found.why_no_file == ""
    (weak,) = [one for one in found.thrust if one.widths > 3.0 and one.unit == "1"]
    assert weak.name == f"thrust_{packed.thruster_names[vertical]}"
    # all of them together are only as well known as the dry mass tells
    upright = np.flatnonzero(np.abs(read(vector, "thruster_direction")[:, 2]) > 0.9)
    names = [f"thrust_{packed.thruster_names[i]}" for i in upright if i != vertical]
    others = np.mean([one.value for one in found.thrust if one.name in names])
    assert weak.value / others == pytest.approx(0.85, abs=0.04)
    (note,) = [text for text in found.notes if "times its stated uncertainty off" in text]
    assert note.startswith(packed.thruster_names[vertical])
    # what is written is the vehicle of that fit
    assert vehicle.model is not None
    changes = file_changes(vehicle, vehicle.model, packed, found.parameters, found.thrust)
    written = changes[f"model.thrust_deduction.thrusters.{packed.thruster_names[vertical]}"]
    assert written == pytest.approx(1.0 - (weak.file_value or 0.0))
    (line,) = [text for text in _quality(found.quality, found.holdout) if "angular_vel" in text]
    assert line.split()[1:4] == [
        f"{value:.3g}"
        for value in (rates.rmse_identified, rates.rmse_corrected_file, rates.rmse_vehicle_file)
    ]


def test_without_a_doubt_in_the_thrust_both_are_one(
    packed: PackedVehicle, sensors: Sensors, two_runs: tuple[RunTable, RunTable]
) -> None:
    found = identified(packed, sensors, two_runs[0], two_runs[1:])
    assert all(q.rmse_corrected_file == q.rmse_identified for q in found.quality)
    assert found.thrust == ()


@pytest.mark.parametrize(("quantity", "lacking"), [("depth", 0), ("velocity", 1)])
def test_a_hold_out_run_may_have_other_channels(
    packed: PackedVehicle,
    sensors: Sensors,
    two_runs: tuple[RunTable, RunTable],
    quantity: str,
    lacking: int,
) -> None:
    tables = list(two_runs)
    values = {name: v for name, v in tables[lacking].values.items() if name != quantity}
    tables[lacking] = replace(tables[lacking], values=values)
    found = identified(packed, sensors, tables[0], (tables[1],))
    channels = {q.channel for q in found.quality}
    assert channels == {
        *("angular_velocity", "specific_force", "attitude", "velocity", "depth", "position")
    } - {quantity}
    assert all(q.rmse_identified is not None for q in found.quality)


def test_a_channel_slower_than_stated_is_named_and_its_true_rate_brings_it_in(
    packed: PackedVehicle, sensors: Sensors, two_runs: tuple[RunTable, RunTable]
) -> None:
    run = two_runs[0]
    slow = np.zeros(run.time_s.size, bool)
    slow[np.flatnonzero(run.reading["velocity"])[::5]] = True
    thinned = replace(run, reading={**run.reading, "velocity": slow})
    found = identified(packed, sensors, thinned)
    assert "velocity" not in {n.channel for n in found.noise}
    (note,) = [text for text in found.notes if "not used" in text]
    assert "velocity (1.6 Hz in these runs, 8 Hz expected)" in note
    assert "rate_hz" in note
    assert sensors.dvl is not None
    dvl = sensors.dvl.model_copy(update={"rate_hz": 1.6})
    stated = identified(packed, sensors.model_copy(update={"dvl": dvl}), thinned)
    assert "velocity" in {n.channel for n in stated.noise}
    assert not any("not used" in text for text in stated.notes)


def test_the_noise_of_a_reading_has_its_offset_where_that_was_not_taken_off(
    packed: PackedVehicle, sensors: Sensors, two_runs: tuple[RunTable, RunTable]
) -> None:
    channel = ChannelNoise("depth", "m", white=0.03, wander=0.04, bias=0.12)
    assert channel.of_reading(offset=True) == pytest.approx(0.13)
    assert channel.of_reading(offset=False) == pytest.approx(0.05)
    # offsets of a run that took no part are not known
    found = identified(packed, sensors, two_runs[0], two_runs[1:])
    force = next(q for q in found.quality if q.channel == "specific_force")
    assert sensors.imu is not None
    expected = np.hypot(sensors.imu.force_noise_mps2, sensors.imu.force_bias_mps2)
    assert force.sensor_noise == pytest.approx(expected)


def test_difference_of_attitudes_is_the_turn_between_them() -> None:
    half = np.array([0.2, 1.4]) / 2
    turned = np.column_stack([np.cos(half), np.zeros(2), np.zeros(2), np.sin(half)])
    # either sign is the same attitude
    found = turn_between(np.broadcast_to(-turned[:1], turned.shape), turned)
    np.testing.assert_allclose(found, [[0, 0, 0], [0, 0, 1.2]], atol=1e-12)
