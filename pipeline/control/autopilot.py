"""The bundled autopilot: surge, depth, heading and pitch, each a PID on its own axis, and roll.

Gains follow from the vehicle's inertia by pole placement, so that one autopilot flies every
vehicle: for m x'' + d x' = tau the law tau = m (w^2 e + 2 zeta w e') + d_0 x' + integral puts the
closed loop at bandwidth w (Fossen 2021, section 15.3). Roll is held, without an integral, where the
reference asks for it.

Under way the Munk moment turns a hull broadside with a stiffness that grows with speed squared. A
blunt vehicle needs more than its bandwidth at rest for that: pitch and heading take twice the
stiffness that this moment has at the present speed on top.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from pipeline.types import FloatArray


@dataclass(frozen=True)
class Setpoint:
    """What is wanted; None leaves an axis alone (no force)."""

    surge_mps: float | None = None
    depth_m: float | None = None
    heading_rad: float | None = None
    pitch_rad: float | None = None
    roll_rad: float | None = None


@dataclass(frozen=True)
class MeasuredState:
    """What is measured: relative surge speed, depth and its rate, attitude and body rates."""

    surge_mps: float
    depth_m: float
    depth_rate_mps: float
    heading_rad: float
    pitch_rad: float
    pitch_rate_radps: float
    yaw_rate_radps: float
    roll_rad: float = 0.0
    roll_rate_radps: float = 0.0


@dataclass(frozen=True)
class Design:
    """Inertias and damping that the gains are made from, and the wanted bandwidths [rad/s].

    Masses and inertias are totals with added mass. `pitch_upset_kg` and `yaw_upset_kg` times the
    speed squared are the stiffness with which the hull turns away from its course [N m/rad], not
    below zero: Munk's moment net of lift.
    """

    surge_mass_kg: float
    heave_mass_kg: float
    pitch_inertia_kgm2: float
    yaw_inertia_kgm2: float
    surge_linear: float
    surge_quadratic: float
    roll_inertia_kgm2: float = 0.0
    pitch_upset_kg: float = 0.0
    yaw_upset_kg: float = 0.0
    surge_bandwidth: float = 0.6
    depth_bandwidth: float = 0.4
    pitch_bandwidth: float = 1.0
    heading_bandwidth: float = 0.8
    roll_bandwidth: float = 1.5
    damping_ratio: float = 0.9
    integral_share: float = 0.15
    """Integral gain as a share of bandwidth times proportional gain."""
    depth_in_reach_m: float = 0.5
    angle_in_reach_rad: float = 0.1
    """A larger error grows the integral no faster: a step would wind it up."""


@dataclass(frozen=True)
class Autopilot:
    """The controller and its integrals (surge, depth, pitch, heading); `step` gives a new one."""

    design: Design
    integral: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def step(
        self, motion: MeasuredState, reference: Setpoint, dt_s: float, *, saturated: bool = False
    ) -> tuple[FloatArray, Self]:
        """Return the wanted wrench X Y Z K M N (6,) in body axes and the next autopilot.

        `dt_s` [s] since the last step; `saturated`: the last demand was not reached, and the
        integrals wait (conditional integration).
        """
        d = self.design
        surge, depth, pitch, heading = self.integral
        demand = np.zeros(6)
        grow = 0.0 if saturated else dt_s
        if reference.surge_mps is not None:
            error = reference.surge_mps - motion.surge_mps
            w = d.surge_bandwidth
            surge += grow * error * d.integral_share * w * w * d.surge_mass_kg
            # the drag at the wanted speed is known: the loop has only its error to carry
            drag = d.surge_linear + d.surge_quadratic * abs(reference.surge_mps)
            demand[0] = d.surge_mass_kg * w * error + surge + drag * reference.surge_mps
        if reference.depth_m is not None:
            force, depth = self._second_order(
                reference.depth_m - motion.depth_m,
                -motion.depth_rate_mps,
                inertia=d.heave_mass_kg,
                w=d.depth_bandwidth,
                integral=depth,
                grow=grow,
                in_reach=d.depth_in_reach_m,
            )
            demand[2] = force * np.cos(motion.pitch_rad)
        if reference.pitch_rad is not None:
            demand[4], pitch = self._second_order(
                reference.pitch_rad - motion.pitch_rad,
                -motion.pitch_rate_radps,
                inertia=d.pitch_inertia_kgm2,
                w=_raised(
                    d.pitch_bandwidth, d.pitch_upset_kg, d.pitch_inertia_kgm2, motion.surge_mps
                ),
                integral=pitch,
                grow=grow,
                in_reach=d.angle_in_reach_rad,
            )
        if reference.heading_rad is not None:
            demand[5], heading = self._second_order(
                wrapped(reference.heading_rad - motion.heading_rad),
                -motion.yaw_rate_radps,
                inertia=d.yaw_inertia_kgm2,
                w=_raised(
                    d.heading_bandwidth, d.yaw_upset_kg, d.yaw_inertia_kgm2, motion.surge_mps
                ),
                integral=heading,
                grow=grow,
                in_reach=d.angle_in_reach_rad,
            )
        if reference.roll_rad is not None:
            demand[3], _ = self._second_order(
                reference.roll_rad - motion.roll_rad,
                -motion.roll_rate_radps,
                inertia=d.roll_inertia_kgm2,
                w=d.roll_bandwidth,
                integral=0.0,
                grow=0.0,
                in_reach=0.0,
            )
        return demand, replace(self, integral=(surge, depth, pitch, heading))

    def _second_order(
        self,
        error: float,
        rate: float,
        *,
        inertia: float,
        w: float,
        integral: float,
        grow: float,
        in_reach: float,
    ) -> tuple[float, float]:
        d = self.design
        held = min(max(error, -in_reach), in_reach)
        integral += grow * held * d.integral_share * w**3 * inertia
        return inertia * (w * w * error + 2.0 * d.damping_ratio * w * rate) + integral, integral


def _raised(bandwidth: float, upset_kg: float, inertia_kgm2: float, speed_mps: float) -> float:
    """Bandwidth [rad/s] whose stiffness carries the hull's upset at a speed twice over as well."""
    return float(np.sqrt(bandwidth**2 + 2.0 * upset_kg * speed_mps**2 / inertia_kgm2))


def wrapped(angle_rad: float) -> float:
    """Bring an angle into (-pi, pi].

    >>> wrapped(3 * np.pi / 2) == -np.pi / 2
    True
    """
    return float(np.pi - (np.pi - angle_rad) % (2.0 * np.pi))
