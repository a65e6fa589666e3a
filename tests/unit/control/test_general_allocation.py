"""Allocation for any arrangement: the pseudo-inverse and its limits."""

import numpy as np
import pytest

from pipeline.control.bounded_allocation import GeneralAllocator
from pipeline.types import FloatArray

S = np.sqrt(0.5)
#: Four horizontal thrusters at 45 degrees at the corners of a square of 2 m.
POSITION = np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]], float)
DIRECTION = S * np.array([[1, -1, 0], [1, 1, 0], [1, 1, 0], [1, -1, 0]], float)


def in_newtons(thrust_n: FloatArray, _inflow_mps: FloatArray) -> FloatArray:
    """Let one code be one newton."""
    return thrust_n


def allocator(smallest: float = -50.0) -> GeneralAllocator:
    return GeneralAllocator(POSITION, DIRECTION, np.full(4, 50.0), np.full(4, smallest), in_newtons)


def test_configuration_by_hand() -> None:
    """Front right: ahead and to port, 1 m ahead and 1 m to starboard: yaw -2 S to port."""
    matrix = allocator().configuration()
    assert matrix[:, 0] == pytest.approx([S, -S, 0, 0, 0, -2 * S])
    assert matrix[5] == pytest.approx([-2 * S, 2 * S, -2 * S, 2 * S])


@pytest.mark.parametrize("axis", [0, 1])
def test_a_force_is_shared_evenly(axis: int) -> None:
    demand = np.zeros(6)
    demand[axis] = 40.0
    thrust, _, saturated = allocator().decide(demand, np.zeros(6))
    assert not saturated
    assert np.abs(thrust) == pytest.approx(40.0 / (4 * S))
    assert allocator().configuration() @ thrust == pytest.approx(demand, abs=1e-9)


def test_beyond_the_limits_the_direction_is_kept() -> None:
    demand = np.array([400.0, 100.0, 0, 0, 0, 0])
    thrust, _, saturated = allocator().decide(demand, np.zeros(6))
    assert saturated
    assert thrust.max() == pytest.approx(50.0)
    given = allocator().configuration() @ thrust
    assert given[1] / given[0] == pytest.approx(0.25)


def test_the_weaker_side_limits() -> None:
    thrust, _, saturated = allocator(-20.0).decide(np.array([-100.0, 0, 0, 0, 0, 0]), np.zeros(6))
    assert saturated
    assert thrust == pytest.approx([-20.0] * 4)


def test_an_axis_out_of_reach_is_left_alone() -> None:
    """No thruster pushes along z: the heave demand vanishes and disturbs nothing."""
    thrust, _, saturated = allocator().decide(np.array([10.0, 0, 500.0, 0, 0, 0]), np.zeros(6))
    assert not saturated
    assert allocator().configuration() @ thrust == pytest.approx([10, 0, 0, 0, 0, 0], abs=1e-9)


def test_inflow_is_that_at_the_thrusters_place() -> None:
    """1 m/s ahead gives S along the thruster; yaw at 1 rad/s adds r x p = (-y, x)."""
    seen: list[FloatArray] = []

    def keep(thrust_n: FloatArray, inflow_mps: FloatArray) -> FloatArray:
        seen.append(inflow_mps)
        return thrust_n

    one = GeneralAllocator(POSITION, DIRECTION, np.full(4, 50.0), np.full(4, -50.0), keep)
    one.decide(np.zeros(6), np.array([1.0, 0, 0, 0, 0, 1.0]))
    assert seen[0] == pytest.approx([S * (1 - 1) - S, S * (1 + 1) + S, S * (1 - 1) - S, 3 * S])
