"""Finite-difference derivatives against complex steps, and against a formula."""

import numpy as np
import pytest

from benchmarks import cases
from benchmarks.derivatives import complex_step_jacobian, relative_errors
from benchmarks.sensitivity import body_states, jacobian, parameter_scale
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import offset, read, write
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Method, Trajectory, initial_state

DT_S = 0.02
PARAMETERS = (
    ("mass", 0),
    ("buoyancy", 0),
    ("centre_of_mass", 2),
    ("added_mass", 7),
    ("added_mass", 4),
    ("inertia", 1),
    ("linear_damping", 28),
    ("quadratic_damping", 0),
    ("current", 1),
    ("crossflow_fraction", 0),
    ("thrust_gain", 3),
    ("dead_zone", 2),
    ("lag", 0),
    ("load_drop", 0),
    ("misalignment_elevation", 2),
)


@pytest.mark.parametrize("method", ["rk4", "semi_implicit"])
def test_derivatives_agree_with_complex_steps(method: Method) -> None:
    packed = cases.vehicle(effects=True)
    commands = cases.multisine(50)
    found = jacobian(packed, commands, PARAMETERS, dt_s=DT_S, start=cases.START, method=method)
    exact = complex_step_jacobian(
        packed, commands, PARAMETERS, dt_s=DT_S, start=cases.START, method=method
    )
    assert found.shape == exact.shape == (51, 13, len(PARAMETERS))
    scale = [parameter_scale(packed.vector, *parameter) for parameter in PARAMETERS]
    errors = relative_errors(found, exact, np.array(scale))
    assert errors.max() < 1e-5
    assert np.median(errors) < 1e-7


def falling(drag: float) -> PackedVehicle:
    """Vehicle that only sinks, with linear drag: u' = (F - d u) / m has a closed form."""
    packed = cases.vehicle()
    for name in ("quadratic_damping", "centre_of_mass", "centre_of_buoyancy"):
        write(packed.vector, name, 0.0)
    write(packed.vector, "added_mass", np.diag([5.0, 50.0, 55.0, 0.5, 9.0, 8.0]))
    write(packed.vector, "inertia", np.diag([1.0, 9.0, 9.5]))
    write(packed.vector, "linear_damping", drag * np.eye(6))
    return packed


def test_derivative_by_drag_has_its_closed_form() -> None:
    """Semi-implicit: w_(k+1) = w_k + h (F - d w_k) / m, so dw/dd follows by its own recursion."""
    drag, steps = 20.0, 200
    packed = falling(drag)
    force = float(read(packed.vector, "weight") - read(packed.vector, "buoyancy"))
    mass = 60.0 + 55.0
    found = jacobian(
        packed,
        np.zeros((steps, 5)),
        [("linear_damping", 14), ("buoyancy", 0)],
        dt_s=DT_S,
        start=initial_state(),
        method="semi_implicit",
    )[:, 9]
    speed, by_drag, by_buoyancy = np.zeros(steps + 1), np.zeros(steps + 1), np.zeros(steps + 1)
    for k in range(steps):
        speed[k + 1] = speed[k] + DT_S * (force - drag * speed[k]) / mass
        by_drag[k + 1] = by_drag[k] - DT_S * (speed[k] + drag * by_drag[k]) / mass
        by_buoyancy[k + 1] = by_buoyancy[k] - DT_S * (1.0 + drag * by_buoyancy[k]) / mass
    np.testing.assert_allclose(found[:, 0], by_drag, rtol=0, atol=1e-8 * np.abs(by_drag).max())
    np.testing.assert_allclose(
        found[:, 1], by_buoyancy, rtol=0, atol=1e-8 * np.abs(by_buoyancy).max()
    )


def test_a_dead_zone_of_zero_is_moved_up_only() -> None:
    """A code of zero stays without thrust: below zero the dead zone would push."""
    packed = cases.vehicle()
    commands = np.tile([40.0, 0.0, 40.0, 40.0, 0.0], (50, 1))
    found = jacobian(packed, commands, [("dead_zone", 0), ("dead_zone", 1)], dt_s=DT_S)
    assert np.abs(found[:, :, 1]).max() == 0.0
    assert found[-1, 7, 0] < -1e-5


def test_threads_change_nothing() -> None:
    packed, commands = cases.vehicle(effects=True), cases.multisine(60)
    one, two = (
        jacobian(packed, commands, PARAMETERS, dt_s=DT_S, threads=threads) for threads in (1, 2)
    )
    assert one.tobytes() == two.tobytes()


def test_other_outputs_can_be_asked_for() -> None:
    def thrust(trajectory: Trajectory) -> np.ndarray:
        return trajectory.thrust_n

    packed, commands = cases.vehicle(), np.full((20, 5), 60.0)
    found = jacobian(packed, commands, [("thrust_gain", 2)], dt_s=DT_S, outputs=thrust)
    assert found.shape == (21, 5, 1)
    # the thrust at rest is gain times the table
    assert found[0, 2, 0] == pytest.approx(42.0 * (60.0 / 127.0) ** 2, rel=1e-9)


def test_the_vector_is_left_alone() -> None:
    packed = cases.vehicle(effects=True)
    before = packed.vector.tobytes()
    jacobian(packed, cases.multisine(10), PARAMETERS, dt_s=DT_S)
    assert packed.vector.tobytes() == before


@pytest.mark.parametrize(
    ("parameter", "message"),
    [
        (("drag", 0), "no parameter called drag"),
        (("quadratic_damping", 6), "entries 0 to 5, not 6"),
        (("thruster_count", 0), "a count or an index"),
        (("lag", 1), "lag of thruster lower is 0, which switches it off"),
        (("rotor_inertia", 0), "give it a value"),
    ],
)
def test_parameters_without_a_derivative_are_refused(
    parameter: tuple[str, int], message: str
) -> None:
    with pytest.raises(CannotComputeError, match=message):
        jacobian(cases.vehicle(), cases.multisine(5), [parameter], dt_s=DT_S)


def test_scales_of_small_and_of_mixed_entries() -> None:
    vector = cases.nominal_vector(5)
    assert parameter_scale(vector, "mass", 0) == 60.0
    assert parameter_scale(vector, "current", 0) == 0.1
    # off the diagonal: between surge [kg] and pitch [kg m^2]
    added = vector[offset("added_mass") : offset("added_mass") + 36].reshape(6, 6)
    assert parameter_scale(vector, "added_mass", 4) == pytest.approx(
        float(np.sqrt(added[0, 0] * added[4, 4]))
    )


def test_body_states_are_named_in_their_order() -> None:
    from benchmarks.sensitivity import BODY_CHANNELS
    from pipeline.simulate.run import run

    trajectory = run(cases.vehicle(), cases.multisine(3), dt_s=DT_S, start=cases.START)
    table = body_states(trajectory)
    assert table.shape == (4, len(BODY_CHANNELS))
    np.testing.assert_array_equal(table[:, BODY_CHANNELS.index("r")], trajectory.nu[:, 5])
    np.testing.assert_array_equal(table[:, BODY_CHANNELS.index("qw")], trajectory.quaternion[:, 0])
