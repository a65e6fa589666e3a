"""A made-up flight with known numbers."""

import dataclasses

import numpy as np
import pytest

from pipeline.simulate.applied_wrench import settled_thrust
from pipeline.simulate.fly import CONTROL_PERIOD_S
from pipeline.validate import plan
from pipeline.validate.campaign import _out_of_reach
from pipeline.validate.closed_loop import ClosedLoop
from pipeline.validate.flight import Course, Flight
from pipeline.validate.measures import keeping, stepping

ROWS = 30
RANGE = np.array([100.0, 50.0, 40.0, 20.0])


def flight(field: ClosedLoop, **changes: np.ndarray) -> Flight:
    """Fly at 1 m/s with code 60 on the stern thrusters, everything as wanted."""
    codes = np.tile([60.0, 60.0, 60.0, 60.0, 0.0], (ROWS, 1))
    inflow = np.tile([0.92388, 0.92388, 0.92388, 0.92388, 0.0], (ROWS, 1))
    thrust = settled_thrust(field.packed, codes, inflow)
    demand = np.zeros((ROWS, 6))
    demand[:, 0] = thrust[0].sum() * 0.92388
    motion = np.tile([1.0, 10.0, 0.0, 0.0], (ROWS, 1))
    parts = {
        "motion": motion,
        "reference": motion.copy(),
        "demand": demand,
        "wanted_n": thrust,
        "codes": codes,
        "actuator": codes,
        "inflow_mps": inflow,
        "thrust_n": thrust,
        "cut": np.zeros(ROWS, dtype=np.bool_),
    }
    return Flight(Course(1.0, ROWS * CONTROL_PERIOD_S, plan.calm), **(parts | changes))


def test_a_perfect_flight_has_no_errors(field: ClosedLoop) -> None:
    got = keeping(field.packed, "compensated", flight(field), range_n_nm=RANGE, power=None)
    assert got.speed_error_mps == got.depth_error_m == got.heading_error_deg == 0.0
    assert got.wrench_error == pytest.approx((0, 0, 0, 0), abs=1e-12)
    assert got.wrench_gain[0] == pytest.approx(1.0)
    assert got.wrench_gain[3] is None
    assert (got.cut_share, got.code_end_share, got.opposed_share) == (0.0, 0.0, 0.0)
    assert got.reached_mps == 1.0
    assert got.largest_code == 60.0
    assert got.shaft_power_w is None


def test_errors_are_root_mean_squares(field: ClosedLoop) -> None:
    motion = np.tile([1.0, 10.0, 0.0, 0.0], (ROWS, 1))
    motion[::2, 0], motion[1::2, 0] = 1.1, 0.9
    motion[: ROWS // 2, 2] = np.radians(2.0)
    got = keeping(
        field.packed, "mooring", flight(field, motion=motion), range_n_nm=RANGE, power=None
    )
    assert got.speed_error_mps == pytest.approx(0.1)
    assert got.heading_error_deg == pytest.approx(2.0 / np.sqrt(2.0))


def test_half_the_thrust_is_a_gain_of_a_half_and_an_error_of_the_rest(field: ClosedLoop) -> None:
    base = flight(field)
    other = dataclasses.replace(base, wanted_n=2.0 * base.wanted_n)
    got = keeping(field.packed, "mooring", other, range_n_nm=RANGE, power=None)
    force = base.demand[0, 0]
    assert got.wrench_gain[0] == pytest.approx(0.5)
    assert got.wrench_error[0] == pytest.approx(force / 100.0, rel=1e-4)


def test_cuts_ends_and_opposed_thrust_are_counted(field: ClosedLoop) -> None:
    base = flight(field)
    codes, cut = base.codes.copy(), base.cut.copy()
    codes[:3, 0], codes[:6, 1] = 127.0, -20.0
    cut[:15] = True
    demand = base.demand.copy()
    demand[:10, 0] += 5.0
    other = dataclasses.replace(base, codes=codes, cut=cut, demand=demand)
    got = keeping(field.packed, "mooring", other, range_n_nm=RANGE, power=None)
    assert got.code_end_share == pytest.approx(0.1)
    assert got.opposed_share == pytest.approx(0.2)
    assert got.cut_share == pytest.approx(0.5)
    assert got.cut_surge_share == pytest.approx(10 / 30)


def test_a_speed_is_out_of_reach_when_surge_is_cut_not_when_moments_are(field: ClosedLoop) -> None:
    base = dataclasses.replace(flight(field), cut=np.ones(ROWS, dtype=np.bool_))
    demand = base.demand.copy()
    demand[:, 5] = 2.0
    turning = dataclasses.replace(base, demand=demand)
    demand = base.demand.copy()
    demand[:, 0] += 5.0
    slow = dataclasses.replace(base, demand=demand)
    first, second = (
        keeping(field.packed, "mooring", one, range_n_nm=RANGE, power=None)
        for one in (turning, slow)
    )
    assert first.cut_share == second.cut_share == 1.0
    assert _out_of_reach((first,)) == ()
    assert "out of reach" in _out_of_reach((second,))[0]


def test_a_drive_that_turns_one_way_idles_at_no_end(field: ClosedLoop) -> None:
    """The bow thruster of the made-up flight stands still all the time."""
    limits = field.packed.code_limits.copy()
    limits[:, 0] = 0.0
    packed = dataclasses.replace(field.packed, code_limits=limits)
    got = keeping(packed, "mooring", flight(field), range_n_nm=RANGE, power=None)
    assert got.code_end_share == 0.0


def test_a_step_is_compared_with_the_flight_without_it(field: ClosedLoop) -> None:
    without = flight(field)
    course = dataclasses.replace(without.course, heading_rad=0.2)
    motion = without.motion.copy()
    motion[5, 0], motion[7, 3] = 0.97, np.radians(-0.5)
    motion[:, 2] = 0.2
    stepped = dataclasses.replace(without, course=course, motion=motion)
    turned = motion.copy()
    turned[:, 2] = 0.2 + np.radians(1.0)
    ideal = dataclasses.replace(stepped, motion=turned)
    got = stepping(field.packed, "mooring", stepped, without=without, ideal=ideal, range_n_nm=RANGE)
    assert got.step == "heading"
    assert got.speed_mps == pytest.approx(0.03)
    assert got.pitch_deg == pytest.approx(0.5)
    assert got.heading_deg == pytest.approx(1.0)
    assert got.wrench == pytest.approx((0, 0, 0, 0))
