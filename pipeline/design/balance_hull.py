r"""Forces of water, weight and buoyancy on a hull in steady level motion.

Angle of attack alpha positive nose up; in the paper's flow axes: drag R_x against the motion, R_y
up, moment positive nose up.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from pipeline.design.balance_input import BalanceHullInput
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.model_schema import Model


@dataclass(frozen=True)
class PolarHull:
    r"""Kostenko 2017, eq. (4), scaled with speed squared.

    .. math:: R_x = (v/v_0)^2 (R_0 + c\,\alpha^2), \quad R_y = (v/v_0)^2 K_y \alpha, \quad
        M = -(v/v_0)^2 K_z \alpha, \quad M_r = -M_o \sin\alpha
    """

    law: BalanceHullInput
    metacentric_nm_per_rad: float

    def forces(self, speed_mps: float, alpha_rad: ArrayLike) -> tuple[FloatArray, ...]:
        """R_x [N], R_y [N] and the moment of the water [N m].

        >>> law = BalanceHullInput(at_speed_mps=3.0, drag_n=148.0, lift_n_per_rad=1375.0,
        ...                 righting_nm_per_rad=731.0)
        >>> [round(float(f), 1) for f in PolarHull(law, 0.7).forces(1.5, 0.1)]
        [37.0, 34.4, -18.3]
        """
        alpha = np.asarray(alpha_rad, float)
        scale = (speed_mps / self.law.at_speed_mps) ** 2
        drag = scale * (self.law.drag_n + self.law.drag_rise_n_per_rad2 * alpha**2)
        lift = scale * self.law.lift_n_per_rad * alpha
        return drag, lift, -scale * self.law.righting_nm_per_rad * alpha

    def restoring_nm(self, buoyancy_n: float, alpha_rad: ArrayLike) -> FloatArray:
        """Moment -M_o sin(alpha), whatever the buoyancy [N m]."""
        del buoyancy_n
        return np.asarray(-self.metacentric_nm_per_rad * np.sin(alpha_rad))


@dataclass(frozen=True)
class BodyHull:
    r"""A vehicle file's hull: damping, lift and the Munk moment in body axes, u ahead, w down.

    With u = v cos(alpha), w = v sin(alpha) and the added-mass matrix A,

    .. math:: X = -(d_1 + D_1 |u|) u, \quad Z = -(d_3 + D_3 |w|) w - k u w, \quad
        M = -K u w / v_0^2 [+ (u A_{3\cdot} - w A_{1\cdot}) \cdot (u, w)]

    The Munk term stands where the stated moment does not hold it already. Weight and buoyancy act
    at their centres; a residual buoyancy other than the file's acts at the centre of buoyancy.
    """

    linear: tuple[float, float]
    quadratic: tuple[float, float]
    lift: float
    moment: float
    munk: tuple[float, float, float]
    """A_11, A_13, A_33 counted in the moment."""
    weight_n: float
    centre_of_mass_m: tuple[float, float]
    centre_of_buoyancy_m: tuple[float, float]
    """x and z."""

    @classmethod
    def of_model(
        cls, model: Model, gravity_mps2: float, density_kgpm3: float
    ) -> tuple[Self, float]:
        """Return the hull of a vehicle file and its residual buoyancy. [N]."""
        body = model.rigid_body
        parts = [(body.mass_kg, body.centre_of_mass_m)]
        volumes = [(body.displaced_volume_m3, body.centre_of_buoyancy_m)]
        for one in model.on_board:
            parts.append((one.mass_kg, one.position_m))
            volumes.append((one.volume_m3, one.position_m))
        mass = sum(m for m, _ in parts)
        volume = sum(v for v, _ in volumes)
        mass_x, mass_z = (sum(m * r[i] for m, r in parts) / mass for i in (0, 2))
        volume_x, volume_z = (sum(v * r[i] for v, r in volumes) / volume for i in (0, 2))
        diagonal, matrix = model.added_mass.diagonal, model.added_mass.matrix
        a = np.array(matrix) if diagonal is None else np.diag(np.array(diagonal))
        lift = model.lift
        full = (0.0, 0.0, 0.0)
        if model.terms.coriolis:
            full = (float(a[0, 0]), float(a[0, 2]), float(a[2, 2]))
        if lift is not None and lift.includes_munk and model.terms.coriolis:
            full = (0.0, full[1], 0.0)
        per = 0.0 if lift is None else 1.0 / lift.speed_mps**2
        hull = cls(
            linear=(model.damping.linear[0], model.damping.linear[2]),
            quadratic=(model.damping.quadratic[0], model.damping.quadratic[2]),
            lift=0.0 if lift is None else lift.heave_n_per_rad * per,
            moment=0.0 if lift is None else -lift.pitch_nm_per_rad * per,
            munk=full,
            weight_n=mass * gravity_mps2,
            centre_of_mass_m=(mass_x, mass_z),
            centre_of_buoyancy_m=(volume_x, volume_z),
        )
        return hull, density_kgpm3 * gravity_mps2 * volume - hull.weight_n

    def forces(self, speed_mps: float, alpha_rad: ArrayLike) -> tuple[FloatArray, ...]:
        """R_x [N], R_y [N] and the moment of the water [N m]."""
        c, s = np.cos(alpha_rad), np.sin(alpha_rad)
        u, w = speed_mps * c, speed_mps * s
        ahead = -(self.linear[0] + self.quadratic[0] * np.abs(u)) * u
        down = -(self.linear[1] + self.quadratic[1] * np.abs(w)) * w - self.lift * u * w
        a11, a13, a33 = self.munk
        moment = self.moment * u * w + u * (a13 * u + a33 * w) - w * (a11 * u + a13 * w)
        return -(ahead * c + down * s), ahead * s - down * c, np.asarray(moment)

    def restoring_nm(self, buoyancy_n: float, alpha_rad: ArrayLike) -> FloatArray:
        """Moment of weight and buoyancy about the origin [N m]."""
        lifting = self.weight_n + buoyancy_n
        (gx, gz), (bx, bz) = self.centre_of_mass_m, self.centre_of_buoyancy_m
        along = self.weight_n * gx - lifting * bx
        below = self.weight_n * gz - lifting * bz
        return np.asarray(-below * np.sin(alpha_rad) - along * np.cos(alpha_rad))


Hull = PolarHull | BodyHull
