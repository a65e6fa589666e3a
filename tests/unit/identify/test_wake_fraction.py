"""An inflow that is not the stated one: found with its interval, and written."""

import numpy as np
import pytest

from evaluation.identification.coverage import Campaign, simulated_runs
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.identify.corrected_file import file_changes
from pipeline.identify.thrust_uncertainty import thrust_uncertainty
from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.identify.whole_vehicle import identify_vehicle
from pipeline.physics.parameters import read
from pipeline.records.identification import VehicleIdentification
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import ThrustDeduction, Uncertainty, WakeFraction
from pipeline.vehicle.schema import Vehicle

SURGE = ("wake_fraction", "linear_damping_surge", "quadratic_damping_surge")


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle(bundled_vehicle("cargo_carrier"))


@pytest.fixture(scope="module")
def found(vehicle: Vehicle) -> VehicleIdentification:
    """Flown with 0.7 of the inflow; the file says all of it, within 0.1."""
    packed = pack_vehicle(vehicle)
    truth = parse_effect("advance_speed_loss:inflow_fraction=0.7", packed.thruster_names)
    vector = apply_effects(packed.vector, [truth], packed.context)
    campaign = Campaign(vehicle, packed, ("surge_steps",), 26.0, thrust=False)
    (run,), (other,) = (simulated_runs(campaign, vector, seed) for seed in (1, 2))
    assert vehicle.sensors is not None
    return identify_vehicle(
        packed,
        vehicle.sensors,
        [run],
        uncertainty=Uncertainty(thrust=0.0),
        only=SURGE,
        holdout=[other],
        suggest=False,
    )


def test_the_wake_fraction_is_found(found: VehicleIdentification) -> None:
    wake = next(one for one in found.parameters if one.name == "wake_fraction")
    assert (wake.prior_value, wake.prior_std) == (0.0, 0.1)
    assert wake.stands
    assert wake.ci95[0] < 0.3 < wake.ci95[1]
    assert wake.std < 0.03


def test_the_file_that_has_it_predicts_as_well_as_the_truth(
    vehicle: Vehicle, found: VehicleIdentification
) -> None:
    velocity = next(one for one in found.quality if one.channel == "velocity")
    assert velocity.rmse_corrected_file is not None
    assert velocity.rmse_vehicle_file is not None
    assert velocity.rmse_corrected_file < 1.3 * velocity.sensor_noise
    assert velocity.rmse_vehicle_file > 1.8 * velocity.rmse_corrected_file
    assert vehicle.model is not None
    changes = file_changes(
        vehicle, vehicle.model, pack_vehicle(vehicle), found.parameters, found.thrust
    )
    value = changes["model.wake_fraction.value"]
    assert isinstance(value, float)
    assert value == pytest.approx(0.3, abs=0.05)


def with_shares(vehicle: Vehicle, wake: WakeFraction, deduction: ThrustDeduction) -> PackedVehicle:
    assert vehicle.model is not None
    update = {"wake_fraction": wake, "thrust_deduction": deduction}
    model = vehicle.model.model_copy(update=update)
    return pack_vehicle(vehicle.model_copy(update={"model": model}))


@pytest.mark.parametrize(("sigma", "free"), [(None, True), (0.2, True), (0.0, False)])
def test_its_width_is_that_of_the_file(
    vehicle: Vehicle, sigma: float | None, *, free: bool
) -> None:
    wake = WakeFraction(value=0.1, sigma=sigma, thrusters={vehicle.thrusters[0].name: 0.3})
    packed = with_shares(vehicle, wake, ThrustDeduction())
    own = [p for p in free_parameters(packed, Uncertainty()) if p.name == "wake_fraction"]
    assert bool(own) == free
    for parameter in own:
        assert parameter.prior_std == (0.1 if sigma is None else sigma)
        vector = packed.vector.copy()
        parameter.write(vector, parameter.nominal)
        np.testing.assert_allclose(vector, packed.vector, rtol=1e-12)
        # twice the mean inflow lost, each thruster in proportion
        parameter.write(vector, 2.0 * parameter.nominal)
        count = len(packed.thruster_names)
        shares = (read(one, "inflow_fraction")[:count] for one in (vector, packed.vector))
        ratio = np.divide(*shares)
        assert ratio == pytest.approx((1 - 2 * parameter.nominal) / (1 - parameter.nominal))


def test_a_width_of_the_deduction_moves_all_thrusters_together(vehicle: Vehicle) -> None:
    """sqrt(0.02^2 + 0.1^2), and what is common to all is all but the bench's own half."""
    packed = with_shares(vehicle, WakeFraction(), ThrustDeduction(sigma=0.1))
    doubt = thrust_uncertainty(packed, Uncertainty(thrust=0.02))
    assert doubt.share == pytest.approx(np.hypot(0.02, 0.1))
    off = doubt.share**2 * doubt.correlation[0, 1]
    assert off == pytest.approx(0.1**2 + 0.5 * 0.02**2)
    plain = thrust_uncertainty(pack_vehicle(vehicle), Uncertainty(thrust=0.02))
    assert doubt.errors_n == plain.errors_n
