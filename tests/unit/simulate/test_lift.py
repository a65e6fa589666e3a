"""Lift opposes the drift whichever end is first, and the Munk moment is counted once."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.effects.library import apply_effects, parse_effect
from pipeline.physics.parameters import neutral_vector, read, write
from pipeline.simulate.kernel_hull import add_damping
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.pack_hull import hull_end_m
from pipeline.simulate.run import initial_state, run
from pipeline.vehicle.model_schema import Lift
from pipeline.vehicle.schema import Vehicle

SPEEDS = st.floats(-3.0, 3.0)
NO_STRIPS = np.zeros((0, 3))


def lift_force(velocity: list[float], **slopes: object) -> np.ndarray:
    vector, force = neutral_vector(), np.zeros(6)
    for name, slope in slopes.items():
        write(vector, name, np.asarray(slope, float))
    add_damping.py_func(vector, np.array([*velocity, 0.0, 0.0, 0.0]), 1.0, NO_STRIPS, force)
    return force


@given(u=SPEEDS, v=SPEEDS, w=SPEEDS, heave=st.floats(0, 300), sway=st.floats(0, 300))
def test_lift_never_gives_energy(u: float, v: float, w: float, heave: float, sway: float) -> None:
    slopes = {"heave_lift_slope": heave, "sway_lift_slope": sway}
    force = lift_force([u, v, w], **slopes, pitch_lift_slope=-40.0, yaw_lift_slope=30.0)
    assert force[:3] @ [u, v, w] <= 0.0


@given(u=SPEEDS, v=SPEEDS, w=SPEEDS)
def test_the_moment_is_that_of_the_force_at_its_place(u: float, v: float, w: float) -> None:
    """A fin at x = -0.8 m: M = -x Z, N = x Y, ahead and astern."""
    force = lift_force(
        [u, v, w],
        heave_lift_slope=30.0,
        sway_lift_slope=20.0,
        pitch_lift_slope=-0.8 * 30.0,
        yaw_lift_slope=0.8 * 20.0,
    )
    np.testing.assert_allclose(force[4:], [0.8 * force[2], -0.8 * force[1]], atol=1e-12)


def test_munks_moment_turns_over_with_the_course() -> None:
    """A free stream from astern turns a hull broadside as one from ahead does."""
    whole = {"pitch_lift_slope": 90.0, "yaw_lift_slope": -80.0, "turnover_slope": [90.0, -80.0]}
    ahead, astern = (lift_force([u, 0.1, 0.2], **whole) for u in (1.5, -1.5))
    np.testing.assert_allclose(ahead[4:], [90.0 * 1.5 * 0.2, -80.0 * 1.5 * 0.1])
    np.testing.assert_allclose(astern, -ahead)


def test_the_moment_that_the_effect_adds_turns_over_too(
    packed_vehicles: dict[str, PackedVehicle],
) -> None:
    """What a hull's moment differs by is what its lee end takes off Munk's."""
    packed = packed_vehicles["rov8"]
    added = parse_effect("lift:pitch_slope=40,yaw_slope=-25,heave_slope=30")
    vector = apply_effects(packed.vector, [added], packed.context)
    for surge in (1.5, -1.5):
        velocity, force, plain = np.array([surge, 0.1, 0.2, 0, 0, 0]), np.zeros(6), np.zeros(6)
        add_damping.py_func(vector, velocity, 1.0, NO_STRIPS, force)
        add_damping.py_func(packed.vector, velocity, 1.0, NO_STRIPS, plain)
        more = force - plain
        np.testing.assert_allclose(more[4:], [40 * surge * 0.2, -25 * surge * 0.1], atol=1e-12)
        assert more[2] == pytest.approx(-30 * 1.5 * 0.2)


def test_the_force_keeps_what_it_can_make_at_the_end_of_the_hull(
    vehicles: dict[str, Vehicle], packed_vehicles: dict[str, PackedVehicle]
) -> None:
    """mmt300 ahead: -7.4 N m s^2 in all; of the -101.2 beside Munk's the force makes 30.9 x_end."""
    vector, vehicle = packed_vehicles["mmt300"].vector, vehicles["mmt300"]
    assert vehicle.model is not None
    end = hull_end_m(vehicle, vehicle.model)
    assert 0.8 < end < 1.3
    net, turned = float(read(vector, "pitch_lift_slope")), read(vector, "turnover_slope")
    assert net - turned[0] == pytest.approx(-278.4 / 9.0 * end)
    assert float(read(vector, "yaw_lift_slope")) - turned[1] == pytest.approx(278.4 / 9.0 * end)
    added = read(vector, "added_mass")
    astern = (added[2, 2] - added[0, 0]) - net + 2.0 * turned[0]
    assert 20.0 < astern < 80.0  # upset, less than the Munk moment of an ideal fluid


@pytest.mark.parametrize("surge", [1.5, -1.5])
def test_a_passive_hull_loses_energy_ahead_and_astern(
    packed_vehicles: dict[str, PackedVehicle], surge: float
) -> None:
    """mmt300 without surge drag: the drift alone can lose energy, and it does."""
    packed = packed_vehicles["mmt300"]
    p = packed.vector.copy()
    write(p, "buoyancy", float(read(p, "weight")))
    write(p, "centre_of_mass", np.zeros(3))
    damping = read(p, "linear_damping")
    damping[0, 0], read(p, "quadratic_damping")[0] = 0.0, 0.0
    write(p, "inertia", 1e6 * np.eye(3))  # it does not turn
    start = initial_state(position_ned_m=(0, 0, 10), nu=(surge, 0.01, 0.01, 0, 0, 0))
    flown = run(packed, np.zeros((1500, 5)), dt_s=0.004, vector=p, start=start)
    mass = float(read(p, "mass")) + np.diag(read(p, "added_mass"))[:3]
    energy = 0.5 * (mass * flown.nu[:, :3] ** 2).sum(axis=1)
    assert np.diff(energy).max() < 1e-9
    assert np.abs(flown.nu[-1, 1:3]).max() < 0.003


@pytest.fixture
def carrier(vehicles: dict[str, Vehicle]) -> Callable[[bool, bool], PackedVehicle]:
    """cargo_carrier with a lift section: (coriolis, includes_munk)."""
    vehicle = vehicles["cargo_carrier"]
    assert vehicle.model is not None
    model = vehicle.model

    def make(coriolis: bool, includes_munk: bool) -> PackedVehicle:
        lift = Lift(
            speed_mps=1.0,
            heave_n_per_rad=100.0,
            pitch_nm_per_rad=50.0,
            yaw_nm_per_rad=30.0,
            includes_munk=includes_munk,
        )
        terms = model.terms.model_copy(update={"coriolis": coriolis})
        changed = model.model_copy(update={"lift": lift, "terms": terms})
        return pack_vehicle(vehicle.model_copy(update={"model": changed}))

    return make


@pytest.mark.parametrize("includes_munk", [True, False])
def test_the_effect_brings_back_what_the_file_left_out(
    carrier: Callable[[bool, bool], PackedVehicle], includes_munk: bool
) -> None:
    """Coriolis on is Coriolis off with the effect at 1, astern too."""
    whole, lacking = carrier(True, includes_munk), carrier(False, includes_munk)
    specs = [parse_effect("coriolis_omitted:fraction=1")]
    back = apply_effects(lacking.vector, specs, lacking.context)
    np.testing.assert_allclose(back, whole.vector, rtol=1e-12, atol=1e-9)
    commands = np.zeros((500, 8))
    commands[:, :4], commands[:, 4:] = [-80.0, -60.0, -70.0, -75.0], 20.0
    one, other = (
        run(lacking, commands, dt_s=0.02, vector=back),
        run(whole, commands, dt_s=0.02),
    )
    np.testing.assert_allclose(one.nu, other.nu, atol=1e-9)


def test_half_of_the_terms_leave_half_of_munk_in_the_slope(
    carrier: Callable[[bool, bool], PackedVehicle],
) -> None:
    packed = carrier(False, True)
    half = parse_effect("coriolis_omitted:fraction=0.5")
    vector = apply_effects(packed.vector, [half], packed.context)
    surge, sway, heave = np.diag(read(packed.vector, "added_mass"))[:3]
    names = ("pitch_lift_slope", "yaw_lift_slope")
    stated = np.array([float(read(packed.vector, name)) for name in names])
    np.testing.assert_allclose(stated, [-50.0, 30.0])
    munk = 0.5 * np.array([heave - surge, surge - sway])
    left = np.array([float(read(vector, name)) for name in names])
    np.testing.assert_allclose(left, stated - munk)
    turned = read(packed.vector, "turnover_slope") - read(vector, "turnover_slope")
    np.testing.assert_allclose(turned, munk)
