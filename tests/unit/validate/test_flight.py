"""Flights on the compiled kernel: the thesis, and where it must not hold."""

import dataclasses
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from flight_cases import bollard_vehicle

from pipeline.errors import CannotComputeError
from pipeline.records.validation import KeepingFlight
from pipeline.simulate.pack import pack_vehicle
from pipeline.validate import plan
from pipeline.validate.campaign import validate_allocator
from pipeline.validate.closed_loop import ClosedLoop


def both(field: ClosedLoop, speed_mps: float) -> tuple[KeepingFlight, KeepingFlight]:
    """Keeping flights with the inverse at rest and with the compensated one."""
    return (
        field.keeping("mooring", field.fly(field.controllers.mooring, speed_mps)),
        field.keeping("compensated", field.fly(field.controllers.compensated, speed_mps)),
    )


def test_compensation_keeps_the_speed_and_the_inverse_at_rest_does_not(field: ClosedLoop) -> None:
    moored, compensated = both(field, 1.5)
    assert compensated.speed_error_mps < moored.speed_error_mps / 5
    assert compensated.wrench_error[0] < moored.wrench_error[0] / 5
    gain = moored.wrench_gain[0]
    assert gain is not None
    assert gain < 0.75
    assert compensated.cut_share == 0.0


def test_without_compensation_the_speed_error_grows_with_speed(field: ClosedLoop) -> None:
    errors = [
        field.keeping("mooring", field.fly(field.controllers.mooring, v)).speed_error_mps
        for v in (0.0, 0.5, 1.0, 1.5)
    ]
    assert all(high > 1.5 * low for low, high in pairwise(errors))


def test_at_rest_both_fly_alike(field: ClosedLoop) -> None:
    moored, compensated = both(field, 0.0)
    assert moored.heading_error_deg == pytest.approx(compensated.heading_error_deg, rel=0.02)
    assert moored.depth_error_m == pytest.approx(compensated.depth_error_m, rel=0.02)


def test_speed_along_the_axis_takes_away_what_compensation_leaves(field: ClosedLoop) -> None:
    told_along = field.keeping("compensated", field.fly(field.controllers.compensated, 1.5))
    (ahead,) = (one for text, one in field.controllers.settings if "V_x" in text)
    told_ahead = field.keeping("compensated", field.fly(ahead, 1.5))
    assert told_along.wrench_error[0] < told_ahead.wrench_error[0] / 5


def test_thrust_that_does_not_fall_leaves_nothing_to_compensate(repository: Path) -> None:
    vehicle = bollard_vehicle(repository, 1e9)
    field = ClosedLoop.of(vehicle, pack_vehicle(vehicle), None, None)
    moored, compensated = both(field, field.speeds[-1])
    assert moored.speed_error_mps == pytest.approx(compensated.speed_error_mps, abs=1e-6)
    assert moored.wrench_error == pytest.approx(compensated.wrench_error, abs=1e-4)


def test_a_bollard_vehicle_whose_thrust_falls_gains_by_compensation(repository: Path) -> None:
    vehicle = bollard_vehicle(repository, 3.8)
    field = ClosedLoop.of(vehicle, pack_vehicle(vehicle), None, None)
    moored, compensated = both(field, field.speeds[-1])
    assert compensated.speed_error_mps < moored.speed_error_mps / 5
    assert any("thrust_falls_with_speed" in text for text in field.explanations)


def test_ideal_thrusters_leave_the_autopilots_error_alone(field: ClosedLoop) -> None:
    got = field.keeping("ideal", field.fly(None, 1.0))
    assert got.speed_error_mps < 1e-3
    assert got.wrench_error == ()


def test_the_same_flight_twice_is_the_same(field: ClosedLoop) -> None:
    one, two = (field.fly(field.controllers.compensated, 0.5) for _ in range(2))
    assert np.array_equal(one.motion, two.motion)


def test_thrust_known_at_rest_only_is_no_case(repository: Path) -> None:
    vehicle = bollard_vehicle(repository, 3.8)
    packed = pack_vehicle(vehicle)
    at_rest = dataclasses.replace(packed, thrust_tables=packed.thrust_tables[:, :, :1])
    with pytest.raises(CannotComputeError, match="at rest only"):
        validate_allocator(vehicle, at_rest)


def test_the_push_is_capped_by_the_range(field: ClosedLoop) -> None:
    design = field.autopilot.design
    free = plan.push(design, np.full(4, 1e6))
    assert free[0] == free[2] == 0.0
    assert free[3] == pytest.approx(
        design.yaw_inertia_kgm2 * design.heading_bandwidth**2 * np.radians(5.0)
    )
    assert plan.push(design, np.full(4, 1.0)).max() == pytest.approx(plan.LARGEST_PUSH)
