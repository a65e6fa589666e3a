r"""The gripper: a rigid latch that holds a payload, and what it does to the vehicle.

While the latch is closed the payload is a part of the vehicle: one rigid body with the mass matrix
of both. The latch then carries what the payload needs to follow,

.. math:: \tau_{latch} = -\left(M_p \dot\nu_r + C_p(\nu_r)\,\nu_r + g_p\right)

(force of the payload on the vehicle, about the body origin), M_p its inertia and
g_p its weight less buoyancy. It is an internal wrench: it tells whether the latch holds, and must
not be added to the equations of the joined body. When the latch opens the wrench vanishes with the
payload; no velocity changes. When it closes on a payload that moves otherwise, both come to a
common motion and the total momentum stays,

.. math:: (M + M_p)\,\nu^+ = M \nu + M_p \nu_p, \qquad P = M_p (\nu_p - \nu^+)

with the impulse P on the vehicle, spread over the time of closing. Voitasyk 2018 gives the gripper
as a wrench T_RMP on the carrier, without an expression; this is a rigid latch's.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.carried_body import cross_matrix
from pipeline.types import FloatArray


@dataclass(frozen=True)
class HeldPayload:
    """A payload in the latch, in body axes.

    `mass_kg` is dry; `volume_m3` displaced, its centre is the centre of mass `position_m`;
    `inertia_kgm2` the principal inertia about it, along the body axes.
    """

    mass_kg: float
    volume_m3: float
    position_m: tuple[float, float, float]
    inertia_kgm2: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def mass_matrix(self) -> FloatArray:
        """Inertia (6, 6) about the body origin; shape (6, 6). [kg, kg m^2].

        Fossen 2021, eq. (3.49).
        """
        translation = self.mass_kg * np.eye(3)
        lever = cross_matrix(np.array(self.position_m))
        matrix = np.zeros((6, 6))
        matrix[:3, :3] = translation
        matrix[:3, 3:] = -translation @ lever
        matrix[3:, :3] = lever @ translation
        matrix[3:, 3:] = np.diag(self.inertia_kgm2) - lever @ translation @ lever
        return matrix


@dataclass(frozen=True)
class Latch:
    """What a latch at `position_m` (body axes) can carry: force and, about its place, moment.

    `closing_s` is the time in which it closes on a payload.
    """

    position_m: tuple[float, float, float]
    strength_n: float = np.inf
    strength_nm: float = np.inf
    closing_s: float = 0.1

    def load_share(self, wrench: FloatArray) -> float:
        """Return load over strength, the larger of force and moment; above 1 the latch fails.

        The `wrench` (6,) is about the body origin, body axes. [N, N m]

        Examples
        --------
        50 N sideways, held 0.1 m away from where it pulls:

        >>> latch = Latch((0.0, 0.0, 0.0), strength_n=100.0, strength_nm=4.0)
        >>> latch.load_share(np.array([0.0, 50.0, 0.0, 0.0, 0.0, 5.0]))
        1.25
        """
        return float(self.load_shares(np.asarray(wrench, float)[None])[0])

    def load_shares(self, wrench: FloatArray) -> FloatArray:
        """Return load over strength for each of several wrenches (k, 6); shape (k,)."""
        force = np.asarray(wrench[:, :3], float)
        moment = np.asarray(wrench[:, 3:], float) - np.cross(self.position_m, force)
        shares: FloatArray = np.maximum(
            np.linalg.norm(force, axis=1) / self.strength_n,
            np.linalg.norm(moment, axis=1) / self.strength_nm,
        )
        return shares


def latch_reaction(
    payload: HeldPayload,
    *,
    nu_relative: FloatArray,
    nu_dot_relative: FloatArray,
    down_body: FloatArray,
    gravity_mps2: float,
    density_kgpm3: float,
) -> FloatArray:
    """Return the wrench of a held payload on the vehicle, (6,) or (k, 6), body axes. [N, N m].

    Parameters
    ----------
    nu_relative, nu_dot_relative : ndarray, shape (6,) or (k, 6)
        Velocity relative to the water and its rate, body axes, at the body origin.
        [m/s, rad/s; m/s^2, rad/s^2]
    down_body : ndarray, shape (3,) or (k, 3)
        Unit vector down, in body axes: the last row of R. [-]

    Examples
    --------
    At rest a payload hangs with its weight in water:

    >>> module = HeldPayload(30.0, 0.01, (0.5, 0.0, 0.0))
    >>> latch_reaction(module, nu_relative=np.zeros(6), nu_dot_relative=np.zeros(6),
    ...     down_body=np.array([0, 0, 1.0]), gravity_mps2=10.0, density_kgpm3=1000.0).tolist()
    [0.0, 0.0, 200.0, 0.0, -100.0, 0.0]
    """
    matrix = payload.mass_matrix()
    nu = np.asarray(nu_relative, float)
    momentum = nu @ matrix  # symmetric
    velocity, rate = nu[..., :3], nu[..., 3:]
    turned = np.concatenate(
        [
            np.cross(rate, momentum[..., :3]),
            np.cross(rate, momentum[..., 3:]) + np.cross(velocity, momentum[..., :3]),
        ],
        axis=-1,
    )
    net = gravity_mps2 * (payload.mass_kg - density_kgpm3 * payload.volume_m3)
    weight = net * np.asarray(down_body, float)
    wrench = np.concatenate([weight, np.cross(payload.position_m, weight)], axis=-1)
    wrench -= np.asarray(nu_dot_relative, float) @ matrix + turned
    return wrench + 0.0  # no negative zeros


def close_on(
    mass_matrix: FloatArray, payload: HeldPayload, nu: FloatArray, nu_payload: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the common motion after the latch has closed, and the impulse on the vehicle.

    Parameters
    ----------
    mass_matrix : ndarray, shape (6, 6)
        Of the vehicle without the payload, added mass included. [kg, kg m, kg m^2]
    nu, nu_payload : ndarray, shape (6,)
        Velocities of vehicle and payload, both taken at the vehicle's body origin and relative to
        the water. [m/s, rad/s]

    Returns
    -------
    nu_after, impulse : ndarray, shape (6,)
        About the body origin, body axes. [m/s, rad/s], [N s, N m s]

    Examples
    --------
    90 kg at 1 m/s take up 10 kg that lie still in the middle:

    >>> vehicle = np.diag([90.0, 90, 90, 1, 1, 1])
    >>> after, impulse = close_on(vehicle, HeldPayload(10.0, 0.0, (0.0, 0.0, 0.0)),
    ...     np.array([1.0, 0, 0, 0, 0, 0]), np.zeros(6))
    >>> after[0].round(12), impulse[0].round(12)
    (np.float64(0.9), np.float64(-9.0))
    """
    held = payload.mass_matrix()
    both = np.asarray(mass_matrix, float) + held
    total = np.asarray(mass_matrix, float) @ nu + held @ np.asarray(nu_payload, float)
    try:
        after = np.linalg.solve(both, total)
    except np.linalg.LinAlgError:
        after = np.full(6, np.nan)
    if not np.isfinite(after).all():
        raise CannotComputeError(
            "The gripper cannot close: mass matrix and velocities do not give a common motion.\n"
            "Expected a positive definite 6 x 6 mass matrix and finite velocities."
        )
    return after, held @ (np.asarray(nu_payload, float) - after)
