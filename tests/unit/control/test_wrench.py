import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.control.wrench import (
    PaperWrench,
    configuration_matrix,
    paper_wrench,
    stern_matrix,
    thruster_matrix,
)
from pipeline.vehicle.schema import Allocator, Vehicle

thrusts = st.lists(st.floats(-50.0, 50.0), min_size=5, max_size=5)


def test_hand_worked_case(allocator: Allocator) -> None:
    """T = 10, 6, 3, 7 N and 2 N at the bow, delta 22.5 deg, L_s 1.2 m, L_b 0.9 m."""
    wrench = paper_wrench(np.array([10.0, 6.0, 3.0, 7.0]), allocator, 2.0)
    assert wrench.force_x == pytest.approx(26.0 * 0.9238795, abs=1e-5)
    assert wrench.force_y == pytest.approx(4.0 * 0.3826834 + 2.0, abs=1e-5)
    assert wrench.force_z == pytest.approx(4.0 * 0.3826834, abs=1e-5)
    assert wrench.moment_y == pytest.approx(4.0 * 0.3826834 * 1.2, abs=1e-5)
    assert wrench.moment_z == pytest.approx(2.0 * 0.9 - 4.0 * 0.3826834 * 1.2, abs=1e-5)


def test_sname_signs_by_meaning(allocator: Allocator) -> None:
    """The right thruster pushes the stern to starboard, so the bow turns to port: N < 0."""
    right = paper_wrench(np.array([0.0, 0.0, 0.0, 10.0]), allocator).to_sname()
    assert right[0] > 0
    assert right[1] > 0
    assert right[5] < 0
    upper = paper_wrench(np.array([10.0, 0.0, 0.0, 0.0]), allocator).to_sname()
    assert upper[2] < 0  # pushes up
    assert upper[4] < 0  # stern up: nose down
    bow = paper_wrench(np.zeros(4), allocator, 5.0).to_sname()
    assert bow[2] == -5.0
    assert bow[4] == pytest.approx(4.5)  # bow up: nose up


@given(thrusts)
def test_geometry_of_the_vehicle_file_gives_equation_5(values: list[float]) -> None:
    """Positions and directions, and eq. (5), are two ways to the same matrix."""
    delta, stern_arm, bow_arm = np.radians(22.5), 1.2, 0.9
    sine, cosine = np.sin(delta), np.cos(delta)
    general = configuration_matrix(
        [(-stern_arm, 0, 0)] * 4 + [(bow_arm, 0, 0)],
        [(cosine, 0, -sine), (cosine, 0, sine), (cosine, -sine, 0), (cosine, sine, 0), (0, 0, -1)],
    )
    allocator = Allocator.model_validate(
        {
            "delta_deg": 22.5,
            "stern_arm_m": stern_arm,
            "bow_arm_m": bow_arm,
            **{name: name for name in ("upper", "lower", "left", "right", "bow")},
            "portions": {"surge": 0.5, "heading": 0.5, "pitch": 0.5},
        }
    )
    thrust = np.array(values)
    printed = paper_wrench(thrust[:4], allocator, thrust[4]).to_sname()
    np.testing.assert_allclose(general @ thrust, printed, atol=1e-10)


def test_matrix_of_the_vehicle_file(mmt300: Vehicle, allocator: Allocator) -> None:
    np.testing.assert_allclose(
        thruster_matrix(mmt300.thrusters), stern_matrix(allocator), atol=1e-12
    )


def test_off_axis_thruster_has_a_longer_arm() -> None:
    """Above the axis by h, the pitch arm is a sin(delta) + h cos(delta), not L_s sin(delta)."""
    delta = np.radians(22.5)
    matrix = configuration_matrix([(-1.2, 0, -0.1)], [(np.cos(delta), 0, -np.sin(delta))])
    assert matrix[4, 0] == pytest.approx(-1.2 * np.sin(delta) - 0.1 * np.cos(delta))


@given(st.lists(st.floats(-100.0, 100.0), min_size=6, max_size=6))
def test_frames_are_inverse_of_each_other(values: list[float]) -> None:
    wrench = np.array(values)
    wrench[3] = 0.0  # the paper has no M_x
    np.testing.assert_array_equal(PaperWrench.from_sname(wrench).to_sname(), wrench)


def test_power_of_a_twist_is_the_same_in_both_frames(allocator: Allocator) -> None:
    """Force times velocity does not depend on the frame: checks all signs at once."""
    thrust = np.array([3.0, -4.0, 7.0, 1.0])
    printed = paper_wrench(thrust, allocator, 2.0)
    surge, up, starboard, turn_up, turn_starboard = 1.1, -0.4, 0.3, 0.2, -0.15
    in_paper = (
        printed.force_x * surge
        + printed.force_y * up
        + printed.force_z * starboard
        + printed.moment_y * turn_up
        + printed.moment_z * turn_starboard
    )
    twist = np.array([surge, starboard, -up, 0.0, turn_starboard, -turn_up])
    assert printed.to_sname() @ twist == pytest.approx(in_paper)
