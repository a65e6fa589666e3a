"""The truth simulator against analytic limits and conservation laws."""

import dataclasses

import numpy as np
import pytest

from pipeline.blind.subject import BlindSubject
from pipeline.blind.truth.craft import Craft, craft_of, rigid_of
from pipeline.blind.truth.faults import with_fault
from pipeline.blind.truth.flight import TruthFlight, fly_craft, still
from pipeline.blind.truth.kernel_flight import CONTROL_S
from pipeline.blind.truth.manoeuvres import belief_of, configuration, pilot_axes
from pipeline.vehicle.model_schema import Lift


def coast(
    craft: Craft, seconds: float, start: np.ndarray, codes: np.ndarray | None = None
) -> TruthFlight:
    count = round(seconds / CONTROL_S)
    given = np.zeros(len(craft.names)) if codes is None else codes
    return fly_craft(craft, belief_of(craft), commands=np.tile(given, (count, 1)), start=start)


def ideal(craft: Craft) -> Craft:
    """No weight, no drag: body and water alone."""
    return craft.changed(
        buoyancy_n=craft.mass_kg * craft.gravity,
        centre_b=craft.centre_g,
        linear=np.zeros((6, 6)),
        quadratic=np.zeros(6),
    )


def tumbling(place: tuple[float, float, float] = (0.0, 0.0, 1.5)) -> np.ndarray:
    start = still(np.array(place), 0.4)
    start[12:18] = (0.6, -0.3, 0.2, 0.5, -0.7, 0.4)
    return start


def momenta(craft: Craft, flight: TruthFlight) -> np.ndarray:
    return flight.ground @ (rigid_of(craft) + craft.added)


def test_without_forces_energy_and_momentum_stay(rov8_craft: Craft) -> None:
    craft = ideal(rov8_craft).changed(centre_g=np.array([0.03, -0.01, 0.05]))
    craft = ideal(craft)
    flight = coast(craft, 20.0, tumbling())
    body = momenta(craft, flight)
    energy = 0.5 * (body * flight.ground).sum(axis=1)
    linear = np.einsum("kij,kj->ki", flight.turn, body[:, :3])
    angular = np.einsum("kij,kj->ki", flight.turn, body[:, 3:]) + np.cross(flight.place, linear)
    # five significant digits over twenty seconds of tumbling
    np.testing.assert_allclose(energy, energy[0], rtol=2e-5)
    np.testing.assert_allclose(linear, np.tile(linear[0], (len(linear), 1)), atol=2e-4)
    np.testing.assert_allclose(angular, np.tile(angular[0], (len(angular), 1)), atol=1e-3)
    np.testing.assert_allclose(
        flight.turn @ flight.turn.transpose(0, 2, 1),
        np.tile(np.eye(3), (len(body), 1, 1)),
        atol=1e-9,
    )


def test_near_a_wall_energy_stays_too(rov8_craft: Craft) -> None:
    craft = ideal(rov8_craft).changed(wall_strength=2.0)
    start = still(np.array([0.0, 0.0, 2.0]))
    start[12:18] = (0.02, 0.0, 0.12, 0.0, 0.0, 0.0)
    flight = coast(craft, 5.0, start)
    rigid, added = rigid_of(craft), craft.added
    factor = np.ones(len(flight.place))
    for wall in craft.walls:
        away = (flight.place - wall[:3]) @ wall[3:]
        factor += 2.0 * (craft.wall_radius_m / away) ** 3
    energy = [0.5 * v @ (rigid + f * added) @ v for v, f in zip(flight.ground, factor, strict=True)]
    assert factor.max() > 1.1 * factor.min()
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5)


def test_terminal_speed_balances_thrust_and_drag(rov8_craft: Craft) -> None:
    # weight and buoyancy at the origin: no trim, so the vehicle stays level
    craft = rov8_craft.changed(
        buoyancy_n=rov8_craft.mass_kg * rov8_craft.gravity,
        centre_g=np.array([0.0, 0.0, 0.05]),
        centre_b=np.array([0.0, 0.0, -0.5]),
        place=rov8_craft.place * np.array([1.0, 1.0, 0.0]),
    )
    codes = np.array([200.0, 200.0, 200.0, 200.0, 0.0, 0.0, 0.0, 0.0])
    flight = coast(craft, 40.0, still(np.array([0.0, 0.0, 1.5])), codes)
    share = ((200.0 - 28.0) / (400.0 - 28.0)) ** 1.33
    force = 4.0 * 51.4 * share * np.sqrt(0.5)
    speed = (-13.7 + np.sqrt(13.7**2 + 4.0 * 141.0 * force)) / (2.0 * 141.0)
    assert flight.ground[-1, 0] == pytest.approx(speed, rel=2e-3)
    np.testing.assert_allclose(flight.thrust[-1, :4], 51.4 * share, rtol=1e-6)


def test_small_roll_has_the_period_of_the_pendulum(rov8_craft: Craft) -> None:
    # neither sinks: speed along z would stiffen the roll by Munk's moment
    craft = ideal(rov8_craft).changed(centre_b=np.array([0.0, 0.0, -0.01]))
    start = still(np.array([0.0, 0.0, 1.5]))
    c, s = np.cos(0.02), np.sin(0.02)
    start[3:12] = (1, 0, 0, 0, c, -s, 0, s, c)
    flight = coast(craft, 20.0, start)
    roll = np.arctan2(flight.turn[:, 2, 1], flight.turn[:, 2, 2])
    downward = np.flatnonzero((roll[:-1] > 0) & (roll[1:] <= 0))
    crossing = [k + roll[k] / (roll[k] - roll[k + 1]) for k in downward]
    period = float(np.mean(np.diff(crossing))) * 0.02
    # rolling does not couple with sway: the centre of mass is the origin
    inertia = 0.26 + 0.189
    stiffness = craft.buoyancy_n * 0.01
    assert period == pytest.approx(2.0 * np.pi * np.sqrt(inertia / stiffness), rel=2e-3)


def test_a_current_carries_a_floating_vehicle_along(rov8_craft: Craft) -> None:
    craft = rov8_craft.changed(
        current=np.array([0.2, -0.1, 0.0]), buoyancy_n=rov8_craft.mass_kg * rov8_craft.gravity
    )
    flight = coast(craft, 120.0, still(np.array([0.0, 0.0, 1.5]), 0.7))
    velocity = flight.turn[-1] @ flight.ground[-1, :3]
    np.testing.assert_allclose(velocity, craft.current, atol=5e-3)


def test_the_rate_of_the_velocity_is_its_derivative(rov8_craft: Craft) -> None:
    flight = coast(rov8_craft.changed(current=np.array([0.1, 0.2, 0.0])), 5.0, tumbling())
    v = flight.ground
    slope = (v[:-4] - 8.0 * v[1:-3] + 8.0 * v[3:-1] - v[4:]) / 0.24
    np.testing.assert_allclose(flight.rate[2:-2], slope, atol=2e-3)


def test_a_step_of_the_code_is_followed_with_the_stated_lag(rov8_craft: Craft) -> None:
    codes = np.full(8, 300.0)
    flight = coast(rov8_craft, 1.0, still(np.array([0.0, 0.0, 1.5])), codes)
    ramped = 300.0 * (1.0 - np.exp(-flight.time_s / 0.076))
    np.testing.assert_allclose(flight.samples[:, 24 + 16], ramped, atol=0.05)
    share = np.maximum(ramped - 28.0, 0.0) / (400.0 - 28.0)
    np.testing.assert_allclose(flight.thrust[:, 0], 51.4 * share**1.33, atol=0.02)


def test_the_allocation_gives_the_wrench_that_is_asked_for(rov8_craft: Craft) -> None:
    belief = belief_of(rov8_craft)
    axes = pilot_axes(rov8_craft)
    assert axes.all()
    np.testing.assert_allclose(configuration(rov8_craft) @ belief.inverse, np.eye(6), atol=1e-9)


def test_a_run_depends_on_nothing_but_its_inputs(rov8_craft: Craft) -> None:
    first, second = (coast(rov8_craft, 2.0, tumbling()) for _ in range(2))
    np.testing.assert_array_equal(first.samples, second.samples)
    assert dataclasses.is_dataclass(first)


@pytest.mark.parametrize("surge", [0.8, -0.8])
def test_lift_takes_energy_out_ahead_and_astern(rov8_craft: Craft, surge: float) -> None:
    """Without drag and weight the drift of a hull that cannot turn can only lose energy."""
    craft = ideal(rov8_craft).changed(lift=np.array([40.0, -10.0, 30.0, 8.0]))
    craft = craft.changed(inertia=1e6 * np.eye(3))
    start = still(np.array([0.0, 0.0, 1.5]), 0.4)
    start[12:15] = (surge, 0.1, 0.05)
    flight = coast(craft, 5.0, start)
    energy = 0.5 * (momenta(craft, flight) * flight.ground).sum(axis=1)
    assert np.diff(energy).max() < 1e-6
    assert np.abs(flight.ground[-1, 1:3]).max() < 0.08


def test_a_munk_moment_in_the_slopes_is_counted_once(carrier: BlindSubject) -> None:
    """Coriolis terms on is off with the fault at one."""
    model = carrier.vehicle.model
    assert model is not None
    lift = Lift(speed_mps=1.0, pitch_nm_per_rad=50.0, yaw_nm_per_rad=30.0, heave_n_per_rad=9.0)

    def craft(coriolis: bool) -> Craft:
        terms = model.terms.model_copy(update={"coriolis": coriolis})
        changed = model.model_copy(update={"lift": lift, "terms": terms})
        return craft_of(carrier.vehicle.model_copy(update={"model": changed}))

    whole = craft(True)
    back = with_fault(craft(False), "coriolis_omitted", {"fraction": 1.0})
    np.testing.assert_array_equal(back.lift, whole.lift)
    np.testing.assert_allclose(back.turning, whole.turning, atol=1e-9)
    assert back.coriolis == whole.coriolis == 1.0
    assert not np.allclose(craft(False).turning, whole.turning)
