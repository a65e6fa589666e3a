"""Forces that a vehicle file lacks, by known values."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose.linear.rest import RestForces, RestTerm, rest_forces, rest_terms
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle

STEPS, STEP_S = 8, 0.25
UNIT = np.array([2.0, 2.0, 2.0, 0.5, 0.5, 0.5])


@pytest.fixture(scope="module")
def packed() -> PackedVehicle:
    return pack_vehicle(load_vehicle(bundled_vehicle("rov8")))


def motion(packed: PackedVehicle) -> FloatArray:
    """One window of two pieces: heading east, surging at 0.4 m/s, the thrusters stepped up."""
    state = np.zeros((STEPS, STATE))
    state[:, 3] = state[:, 6] = np.sqrt(0.5)
    state[:, 7] = 0.4
    state[STEPS // 2 :, BODY : BODY + len(packed.thruster_names)] = 200.0
    return state


def along(packed: PackedVehicle, *terms: RestTerm) -> FloatArray:
    found = rest_forces(
        packed, terms, motion(packed), np.full(STEPS, STEP_S), np.array([0, 4, 8]), UNIT, 1
    )
    return np.asarray(found.shape.reshape(2, 6, len(terms)) * UNIT[:, None])


def test_a_constant_is_its_unit_on_its_axis(packed: PackedVehicle) -> None:
    found = along(packed, RestTerm("constant", 4, -1, 0.3))[:, :, 0]
    np.testing.assert_allclose(found, np.tile([0, 0, 0, 0, 0.3, 0], (2, 1)), atol=1e-12)


def test_a_force_to_the_north_pushes_to_port_of_a_vehicle_that_heads_east(
    packed: PackedVehicle,
) -> None:
    found = along(packed, RestTerm("earth", -1, 0, 1.5))[0, :, 0]
    np.testing.assert_allclose(found, [0, -1.5, 0, 0, 0, 0], atol=1e-9)


def test_a_share_of_thrust_and_late_thrust(packed: PackedVehicle) -> None:
    thrust, late = RestTerm("thrust", 2, 0, 1.0), RestTerm("late", 0, -1, 0.1)
    found = along(packed, thrust, late)
    codes = np.full((1, len(packed.thruster_names)), 200.0)
    wrench, each = thruster_wrench(packed, codes, np.zeros((1, 6)))
    assert found[0, 2, 0] == pytest.approx(0.0, abs=1e-9)
    assert found[1, 2, 0] == pytest.approx(each[0, 0])
    # the step is one of four of its piece
    assert found[1, 0, 1] == pytest.approx(-0.1 * wrench[0, 0] / STEP_S / 4, abs=1e-9)


def test_damping_couples_axes_and_pushes_against(packed: PackedVehicle) -> None:
    found = along(packed, RestTerm("damping", 5, 0, 3.0))[0, :, 0]
    np.testing.assert_allclose(found, [0, 0, 0, 0, 0, -3.0 * 0.4], atol=1e-12)


def test_no_term_says_again_what_the_file_can_say(packed: PackedVehicle) -> None:
    terms = rest_terms(packed, UNIT)
    assert not [one for one in terms if one.kind == "damping" and one.axis == one.column]
    vertical = packed.thruster_names.index("vertical_front_right")
    axes = {one.axis for one in terms if one.kind == "thrust" and one.column == vertical}
    assert 2 not in axes
    assert 0 in axes


def test_forces_add_up() -> None:
    shape = np.arange(24.0).reshape(1, 12, 2)
    found = RestForces((RestTerm("constant", 0, -1, 1.0),) * 2, shape).of(np.array([1.0, -1.0]))
    np.testing.assert_allclose(found, np.full((1, 12), -1.0))
