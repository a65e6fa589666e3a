"""The rigid latch: Newton for the payload, momentum at closing, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pipeline.errors import CannotComputeError
from pipeline.physics.gripper import (
    HeldPayload,
    Latch,
    close_on,
    latch_reaction,
)

MODULE = HeldPayload(25.0, 0.01, (0.3, -0.2, 0.4), (0.5, 0.8, 0.7))
VEHICLE = np.diag([120.0, 180.0, 190.0, 8.0, 15.0, 14.0])
motions = arrays(float, 6, elements=st.floats(-2, 2))


@given(nu=motions, nu_dot=motions)
def test_reaction_is_newton_and_euler_of_the_payload(nu: np.ndarray, nu_dot: np.ndarray) -> None:
    """Acceleration of its centre and turning about it, by hand."""
    down = np.array([0.6, 0.0, 0.8])
    wrench = latch_reaction(
        MODULE,
        nu_relative=nu,
        nu_dot_relative=nu_dot,
        down_body=down,
        gravity_mps2=9.81,
        density_kgpm3=1000.0,
    )
    r, v, w, inertia = np.array(MODULE.position_m), nu[:3], nu[3:], np.diag(MODULE.inertia_kgm2)
    centre = nu_dot[:3] + np.cross(w, v) + np.cross(nu_dot[3:], r) + np.cross(w, np.cross(w, r))
    needed = 25.0 * centre - 9.81 * (25.0 - 10.0) * down  # what the latch gives the payload
    turning = inertia @ nu_dot[3:] + np.cross(w, inertia @ w)
    expected = -np.concatenate([needed, np.cross(r, needed) + turning])
    np.testing.assert_allclose(wrench, expected, atol=1e-9)


def test_a_falling_payload_needs_nothing_of_the_latch() -> None:
    """In air, free fall: force and moment vanish."""
    wrench = latch_reaction(
        MODULE,
        nu_relative=np.zeros(6),
        nu_dot_relative=np.array([0.0, 0.0, 9.81, 0, 0, 0]),
        down_body=np.array([0.0, 0.0, 1.0]),
        gravity_mps2=9.81,
        density_kgpm3=0.0,
    )
    np.testing.assert_allclose(wrench, 0.0, atol=1e-12)


def test_inertia_about_the_origin_is_steiners() -> None:
    matrix = MODULE.mass_matrix()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12)
    x, y, z = MODULE.position_m
    assert matrix[3, 3] == pytest.approx(0.5 + 25.0 * (y**2 + z**2))
    assert matrix[4, 4] == pytest.approx(0.8 + 25.0 * (x**2 + z**2))
    assert matrix[0, 4] == pytest.approx(25.0 * z)
    assert matrix[0, 5] == pytest.approx(-25.0 * y)


@given(nu=motions, other=motions)
def test_closing_keeps_the_momentum_and_loses_energy(nu: np.ndarray, other: np.ndarray) -> None:
    held = MODULE.mass_matrix()
    after, impulse = close_on(VEHICLE, MODULE, nu, other)
    np.testing.assert_allclose((VEHICLE + held) @ after, VEHICLE @ nu + held @ other, atol=1e-9)
    np.testing.assert_allclose(VEHICLE @ (after - nu), impulse, atol=1e-9)
    before = nu @ VEHICLE @ nu + other @ held @ other
    assert after @ (VEHICLE + held) @ after <= before * (1 + 1e-12) + 1e-12


def test_closing_on_a_payload_that_moves_along_changes_nothing() -> None:
    nu = np.array([0.5, 0.1, 0.0, 0.0, 0.0, 0.2])
    after, impulse = close_on(VEHICLE, MODULE, nu, nu)
    np.testing.assert_allclose(after, nu, atol=1e-12)
    np.testing.assert_allclose(impulse, 0.0, atol=1e-12)


def test_latch_load_is_taken_at_its_own_place() -> None:
    """A payload under the latch puts no moment on it."""
    hanging = latch_reaction(
        MODULE,
        nu_relative=np.zeros(6),
        nu_dot_relative=np.zeros(6),
        down_body=np.array([0.0, 0.0, 1.0]),
        gravity_mps2=9.81,
        density_kgpm3=1000.0,
    )
    net = 9.81 * 15.0
    above = Latch((0.3, -0.2, 0.1), strength_n=100.0, strength_nm=1e-3)
    assert above.load_share(hanging) == pytest.approx(net / 100.0)
    beside = Latch((0.2, -0.2, 0.1), strength_n=1e9, strength_nm=10.0)
    assert beside.load_share(hanging) == pytest.approx(0.1 * net / 10.0)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(CannotComputeError, match="not give a common motion"):
        close_on(np.full((6, 6), np.nan), MODULE, np.zeros(6), np.zeros(6))
