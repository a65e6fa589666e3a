r"""Steady level motion with residual buoyancy: Kostenko 2017, eqs. (1) to (9).

Level and steady, eq. (1) reads, with the righting sign of M_o (only the minus rights the vehicle;
the paper prints a plus in (1) and (3) and the minus in (6)),

.. math::

    -R_x + T_x \cos\alpha - T_y \sin\alpha = 0, \qquad
    R_y + P + T_y \cos\alpha + T_x \sin\alpha = 0, \qquad
    -M_o \sin\alpha + M_z - T_y L_\psi = 0

T_x ahead and T_y up are the thrusters' forces in body axes. The first two give them at any alpha;
the third is then an equation for alpha alone.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from pipeline.design.balance_hull import Hull
from pipeline.errors import CannotComputeError
from pipeline.types import ArrayLike, FloatArray

THRUSTERS = ("left", "right", "upper", "lower")
#: Largest angle of attack that is looked for. [rad]
LARGEST_ALPHA_RAD = np.radians(30.0)


@dataclass(frozen=True)
class Condition:
    """Speed [m/s], residual buoyancy [N, up], angle of the thrusters [deg], their arms [m]."""

    speed_mps: float
    residual_buoyancy_n: float
    angle_deg: float
    pitch_arm_m: float
    heading_arm_m: float
    heading_moment_nm: float = 0.0


@dataclass(frozen=True)
class Balance:
    """Angle of attack, body forces (ahead, up) and the thrusts left, right, upper, lower. [N]."""

    alpha_rad: float
    surge_n: float
    vertical_n: float
    loads_n: tuple[float, float, float, float]


def control_forces(
    hull: Hull, condition: Condition, alpha_rad: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Body forces that hold the vehicle level at an angle of attack, T_x and T_y. [N]."""
    drag, lift, _ = hull.forces(condition.speed_mps, alpha_rad)
    up = lift + condition.residual_buoyancy_n
    c, s = np.cos(alpha_rad), np.sin(alpha_rad)
    return drag * c - up * s, -drag * s - up * c


def moment_left_nm(
    hull: Hull, condition: Condition, alpha_rad: ArrayLike, without_nm: float = 0.0
) -> FloatArray:
    """Pitching moment that is left over, nose up, less a constant one. [N m]."""
    _, _, moment = hull.forces(condition.speed_mps, alpha_rad)
    _, vertical = control_forces(hull, condition, alpha_rad)
    restoring = hull.restoring_nm(condition.residual_buoyancy_n, alpha_rad) - without_nm
    return np.asarray(restoring + moment - vertical * condition.pitch_arm_m)


def thruster_loads(
    surge_n: float, vertical_n: float, condition: Condition
) -> tuple[float, float, float, float]:
    """Thrusts left, right, upper, lower, eq. (9). [N].

    >>> pilgrim = Condition(3.0, 60.0, 22.5, 2.0, 2.0)
    >>> [round(f, 1) for f in thruster_loads(146.0, 19.0, pilgrim)]
    [39.5, 39.5, 64.3, 14.7]
    """
    delta = np.radians(condition.angle_deg)
    along = surge_n / (4.0 * np.cos(delta))
    turn = condition.heading_moment_nm / (2.0 * condition.heading_arm_m * np.sin(delta))
    lift = vertical_n / (2.0 * np.sin(delta))
    return tuple(float(f) for f in (along - turn, along + turn, along + lift, along - lift))  # type: ignore[return-value]  # four of them


def inflows_mps(speed_mps: float, alpha_rad: float, angle_deg: float) -> tuple[float, ...]:
    """Speed of the water along each thruster, left, right, upper, lower. [m/s].

    >>> [round(v, 3) for v in inflows_mps(3.0, 0.0, 22.5)]
    [2.772, 2.772, 2.772, 2.772]
    """
    delta = np.radians(angle_deg)
    side = float(speed_mps * np.cos(alpha_rad) * np.cos(delta))
    return (
        side,
        side,
        float(speed_mps * np.cos(alpha_rad + delta)),
        float(speed_mps * np.cos(alpha_rad - delta)),
    )


def exact_balance(hull: Hull, condition: Condition) -> Balance:
    """Solve the exact steady form of (1): the angle of attack nearest to zero.

    Raises
    ------
    CannotComputeError
        When no angle of attack up to 30 deg balances force and moment; the text gives the largest
        buoyancy of that sign that can be carried at this speed.
    """
    alpha = balanced_angle_rad(hull, condition)
    if alpha is None:
        raise CannotComputeError(_not_carried(hull, condition))
    surge, vertical = control_forces(hull, condition, alpha)
    surge_n, vertical_n = float(surge), float(vertical)
    return Balance(alpha, surge_n, vertical_n, thruster_loads(surge_n, vertical_n, condition))


def balanced_angle_rad(hull: Hull, condition: Condition, without_nm: float = 0.0) -> float | None:
    """Angle of attack nearest to zero that balances, up to 30 deg, without a constant moment."""
    grid = np.linspace(-LARGEST_ALPHA_RAD, LARGEST_ALPHA_RAD, 121)
    left = moment_left_nm(hull, condition, grid, without_nm)
    crossings = np.flatnonzero(left[:-1] * left[1:] <= 0.0)
    if not crossings.size:
        return None
    at = int(crossings[np.argmin(np.abs(grid[crossings] + grid[crossings + 1]))])
    return float(
        brentq(
            lambda a: float(moment_left_nm(hull, condition, a, without_nm)),
            grid[at],
            grid[at + 1],
            xtol=1e-13,
        )
    )


def _not_carried(hull: Hull, condition: Condition) -> str:
    """Say how much buoyancy can be carried at this speed, by halving; or why not even none can."""
    neutral = replace(condition, residual_buoyancy_n=0.0)
    if balanced_angle_rad(hull, neutral) is None:
        moment = constant_moment_nm(hull, neutral)
        return (
            f"A residual buoyancy of {condition.residual_buoyancy_n:g} N cannot be carried at "
            f"{condition.speed_mps:g} m/s with an angle of attack up to "
            f"{np.degrees(LARGEST_ALPHA_RAD):.0f} deg, and neither can none: a moment of "
            f"{moment:.3g} N m, nose up, is left at zero angle of attack.\n"
            "Trim the vehicle: put its centre of mass below its centre of buoyancy, or go faster."
        )
    low, high = 0.0, condition.residual_buoyancy_n
    for _ in range(40):
        middle = 0.5 * (low + high)
        tried = replace(condition, residual_buoyancy_n=middle)
        held = balanced_angle_rad(hull, tried) is not None
        low, high = (middle, high) if held else (low, middle)
    return (
        f"A residual buoyancy of {condition.residual_buoyancy_n:g} N cannot be carried at "
        f"{condition.speed_mps:g} m/s with an angle of attack up to "
        f"{np.degrees(LARGEST_ALPHA_RAD):.0f} deg: at most {low:.3g} N can.\n"
        "Go faster, ballast the vehicle, or use a thruster that pushes vertically."
    )


@dataclass(frozen=True)
class Slopes:
    """R_x(0) [N], K_y [N/rad], K_z [N m/rad] and M_o [N m/rad] at one speed."""

    drag_n: float
    lift_n_per_rad: float
    righting_nm_per_rad: float
    metacentric_nm_per_rad: float


def slopes(hull: Hull, condition: Condition, step_rad: float = 1e-5) -> Slopes:
    """Linearise a hull about zero angle of attack, eq. (4)."""
    both = np.array([-step_rad, step_rad])
    _, lift, moment = hull.forces(condition.speed_mps, both)
    restoring = hull.restoring_nm(condition.residual_buoyancy_n, both)
    drag, _, _ = hull.forces(condition.speed_mps, 0.0)
    return Slopes(
        float(drag),
        float(np.diff(lift)[0] / (2 * step_rad)),
        float(-np.diff(moment)[0] / (2 * step_rad)),
        float(-np.diff(restoring)[0] / (2 * step_rad)),
    )


def small_angle_balance(linear: Slopes, condition: Condition) -> Balance:
    r"""Solve the small-angle form, eqs. (7) to (9) as printed.

    .. math:: \alpha = -P / (R_0 + K_y - (M_o + K_z) / L_\psi), \quad
        T_y = -(M_o + K_z) \alpha / L_\psi, \quad T_x = R_0 - T_y \alpha

    Raises
    ------
    CannotComputeError
        When the denominator is not positive: the hull's moment outweighs its lift at this arm, or
        the hull does not lift.

    >>> pilgrim = Condition(3.0, 60.0, 22.5, 2.0, 2.0)
    >>> found = small_angle_balance(Slopes(148.0, 1375.0, 731.0, 0.70), pilgrim)
    >>> round(float(np.degrees(found.alpha_rad)), 2), round(found.vertical_n), round(found.surge_n)
    (-2.97, 19, 149)
    """
    moment = (linear.metacentric_nm_per_rad + linear.righting_nm_per_rad) / condition.pitch_arm_m
    lift = linear.drag_n + linear.lift_n_per_rad
    below = lift - moment
    if below <= 0.0 and lift <= 0.0:  # then no arm is long enough
        raise CannotComputeError(
            f"Drag and lift of the hull make {lift:.4g} N/rad: an angle of attack nose up does not "
            "push it up, so none carries a buoyancy as (7) takes it.\n"
            "Check the sign of the lift; expected above zero, upwards at a positive angle of "
            "attack."
        )
    if below <= 0.0:
        raise CannotComputeError(
            f"The hull rights itself with {moment:.4g} N/rad at the thrusters' arm and lifts with "
            f"only {lift:.4g} N/rad (drag and lift): pitching the "
            "vehicle costs more vertical thrust than the angle of attack gains.\n"
            f"An arm above {moment * condition.pitch_arm_m / lift:.3g} m is needed."
        )
    alpha = -condition.residual_buoyancy_n / below
    vertical = -moment * alpha
    surge = linear.drag_n - vertical * alpha
    return Balance(alpha, surge, vertical, thruster_loads(surge, vertical, condition))


def constant_moment_nm(hull: Hull, condition: Condition) -> float:
    """Moment at zero angle of attack, nose up, of which (7) knows nothing. [N m]."""
    _, _, moment = hull.forces(condition.speed_mps, 0.0)
    return float(moment + hull.restoring_nm(condition.residual_buoyancy_n, 0.0))
