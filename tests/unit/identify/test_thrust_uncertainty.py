"""The unknowns of the thrust: what they do to the tables, and how far the prior lets them go."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.identify.thrust_uncertainty import (
    ALIKE,
    EXACT_THRUST,
    KNOTS,
    ThrustUncertainty,
    thrust_uncertainty,
)
from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import Uncertainty

SHARE = 0.04


@pytest.fixture(scope="module")
def packed() -> PackedVehicle:
    return pack_vehicle(load_vehicle(bundled_vehicle("rov8")))


@pytest.fixture(scope="module")
def doubt(packed: PackedVehicle) -> ThrustUncertainty:
    return thrust_uncertainty(packed, Uncertainty(thrust=SHARE))


def thrusts(packed: PackedVehicle, code: float) -> FloatArray:
    """Thrust of each thruster at rest at a code."""
    count = len(packed.thruster_names)
    wrench = [
        thruster_wrench(packed, code * row[None], np.zeros((1, 6)))[0][0] for row in np.eye(count)
    ]
    return np.asarray(np.linalg.norm(np.array(wrench)[:, :3], axis=1), float)


def test_every_thruster_has_a_factor_and_every_curve_its_knots(
    packed: PackedVehicle, doubt: ThrustUncertainty
) -> None:
    count = len(packed.thruster_names)
    assert doubt.names[:count] == tuple(f"thrust_{name}" for name in packed.thruster_names)
    assert doubt.size == count + 2 * len(KNOTS)
    assert doubt.units == ("1",) * count + ("N",) * (2 * len(KNOTS))
    np.testing.assert_allclose(doubt.precision @ doubt.correlation, np.eye(doubt.size), atol=1e-12)
    assert doubt.correlation[0, 1] == ALIKE
    assert doubt.correlation[0, count] == 0.0


def test_a_factor_is_of_one_thruster_alone(packed: PackedVehicle, doubt: ThrustUncertainty) -> None:
    steps = np.zeros(doubt.size)
    steps[2] = -1.5
    vector = packed.vector.copy()
    doubt.write(vector, steps)
    expected = np.ones(len(packed.thruster_names))
    expected[2] = 1.0 - 1.5 * SHARE
    np.testing.assert_allclose(read(vector, "thrust_gain")[: expected.size], expected)
    assert doubt.packed(packed, steps) is packed


def test_a_knot_moves_the_curve_where_it_is(
    packed: PackedVehicle, doubt: ThrustUncertainty
) -> None:
    steps = np.zeros(doubt.size)
    steps[-4] = 1.0  # at rest, the second of three
    largest = float(read(packed.vector, "code_max")[0])
    moved = doubt.packed(packed, steps)
    at_knot, at_next = KNOTS[1] * largest, KNOTS[2] * largest
    error = thrusts(moved, at_knot) - thrusts(packed, at_knot)
    full = float(packed.thrust_tables[0, 0, 0].max())
    assert error[0] == pytest.approx(SHARE / 4 * full, rel=0.15)
    assert error[0] == pytest.approx(doubt.scales[-4], rel=0.15)
    np.testing.assert_allclose(thrusts(moved, at_next), thrusts(packed, at_next), rtol=1e-3)


def test_a_dead_zone_stays_dead(packed: PackedVehicle, doubt: ThrustUncertainty) -> None:
    steps = np.zeros(doubt.size)
    steps[-2 * len(KNOTS) :] = 2.0
    moved = doubt.packed(packed, steps)
    assert (moved.thrust_tables[packed.thrust_tables == 0.0] == 0.0).all()
    steps[-2 * len(KNOTS) :] = -2.0
    assert (doubt.packed(packed, steps).thrust_tables >= -1e-12).all()


def test_draws_have_the_spread_that_is_stated(doubt: ThrustUncertainty) -> None:
    generator = np.random.default_rng(0)
    draws = np.array([doubt.drawn(generator, 9.0) for _ in range(4000)])
    found = np.cov(draws.T)
    np.testing.assert_allclose(found, doubt.correlation, atol=0.08)


def test_a_thrust_without_doubt_has_no_unknowns(packed: PackedVehicle) -> None:
    assert thrust_uncertainty(packed, Uncertainty(thrust=0.0)) is EXACT_THRUST
    assert EXACT_THRUST.packed(packed, np.zeros(0)) is packed
