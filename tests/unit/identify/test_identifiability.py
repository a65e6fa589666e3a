"""What runs cannot identify, and whether the manoeuvre that is named would."""

import numpy as np
import pytest

from evaluation.identification.coverage import Campaign, simulated_runs
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.identify import identifiability
from pipeline.identify.channel_noise import QUANTITIES
from pipeline.identify.identifiability import information_of_run
from pipeline.identify.parameter_intervals import NOT_IDENTIFIED
from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.identify.whole_vehicle import identify_vehicle
from pipeline.records.identification import VehicleIdentification
from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.sensors import measure
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.schema import Vehicle

ONLY = ("added_mass_surge", "added_mass_yaw", "quadratic_damping_surge", "quadratic_damping_yaw")


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return load_vehicle(bundled_vehicle("rov8"))


@pytest.fixture(scope="module")
def packed(vehicle: Vehicle) -> PackedVehicle:
    return pack_vehicle(vehicle)


def identified_from(
    vehicle: Vehicle, packed: PackedVehicle, *manoeuvres: str, suggest: bool = True
) -> VehicleIdentification:
    assert vehicle.sensors is not None
    runs = simulated_runs(Campaign(vehicle, packed, manoeuvres, 40.0), packed.vector, 5)
    return identify_vehicle(packed, vehicle.sensors, runs, only=ONLY, suggest=suggest)


@pytest.fixture(scope="module")
def straight_only(vehicle: Vehicle, packed: PackedVehicle) -> VehicleIdentification:
    """Suggestions from a short list, to be quick."""
    some = {name: MANOEUVRES[name] for name in ("hover", "surge_steps", "zig_zag")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(identifiability, "MANOEUVRES", some)
        return identified_from(vehicle, packed, "straight")


def test_yaw_cannot_be_identified_without_turning(straight_only: VehicleIdentification) -> None:
    verdict = {p.name: p.identified for p in straight_only.parameters}
    assert not verdict["quadratic_damping_yaw"]
    assert verdict["quadratic_damping_surge"]
    (sentence,) = [t for t in straight_only.cannot_identify if "quadratic_damping_yaw" in t]
    assert "hardly excite it" in sentence
    assert "zig_zag" in sentence


@pytest.mark.slow
def test_the_manoeuvre_that_is_named_does_identify(
    vehicle: Vehicle, packed: PackedVehicle, straight_only: VehicleIdentification
) -> None:
    """The prediction is kept when the suggested run is flown."""
    gains = {g.parameter: g for g in straight_only.next_manoeuvres}
    named = gains["quadratic_damping_yaw"]
    assert named.posterior_over_prior < NOT_IDENTIFIED
    then = identified_from(vehicle, packed, "straight", named.manoeuvre, suggest=False)
    after = {p.name: p for p in then.parameters}["quadratic_damping_yaw"]
    assert after.identified
    # the suggestion counts with a longer run than was flown here
    assert after.posterior_over_prior < 4 * named.posterior_over_prior


def test_a_prior_is_handed_back_where_nothing_is_known(
    straight_only: VehicleIdentification,
) -> None:
    yaw = {p.name: p for p in straight_only.parameters}["quadratic_damping_yaw"]
    assert yaw.std == pytest.approx(yaw.prior_std, rel=0.02)
    assert yaw.posterior_over_prior == pytest.approx(1.0, abs=0.02)
    assert yaw.value == pytest.approx(yaw.prior_value, abs=0.1 * yaw.prior_std)
    assert yaw.ci95[0] < yaw.prior_value < yaw.ci95[1]


def information(
    vehicle: Vehicle, packed: PackedVehicle, manoeuvre: str, scale: float = 1.0
) -> np.ndarray:
    """Diagonal of what half a minute of a manoeuvre holds."""
    assert vehicle.sensors is not None
    flown = fly(packed, MANOEUVRES[manoeuvre].plan(packed, 1.0, 28.0))
    found = information_of_run(
        packed,
        vehicle.sensors,
        measure(flown, packed, vehicle.sensors),
        free_parameters(packed, Uncertainty(), only=ONLY),
        scale=dict.fromkeys(QUANTITIES, scale),
    )
    assert np.linalg.eigvalsh(found).min() > -1e-6 * np.trace(found)
    return np.diag(found)


def test_more_excitation_is_more_information(vehicle: Vehicle, packed: PackedVehicle) -> None:
    rest, wild = (information(vehicle, packed, name) for name in ("hover", "multisine"))
    assert (wild > 10 * rest).all()


def test_noise_beyond_the_stated_one_leaves_less_information(
    vehicle: Vehicle, packed: PackedVehicle
) -> None:
    """A third of the accuracy is a ninth of the information, but for the starts' priors."""
    stated, more = (information(vehicle, packed, "zig_zag", scale) for scale in (1.0, 3.0))
    assert (more < 0.2 * stated).all()
