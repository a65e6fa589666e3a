"""The monotone thruster characteristic: code against thrust on a grid that follows T_max(V).

For each sign of thrust the grid holds, at a few speeds, the largest thrust and the code at equal
fractions of it. Between speeds and between fractions everything is linear, so the two directions
N(T, V) and T(N, V) are exact inverses of each other, both are monotone in T and N as long as the
rows rise, and a controller without a floating-point unit can evaluate them.

Speed is counted along the thrust: reverse thrust meets V = -speed. A propeller that is driven
slower than the water goes drags: inside the dead zone the thrust falls straight from zero at its
edge to the drag of the freely turning propeller at code 0. Against the motion the row at rest
holds, or that drag where it is more (decision 0011 says why and how well).
"""

from dataclasses import dataclass, field

import numpy as np

from pipeline.types import ArrayLike, FloatArray


def dead_zone_code(coefficients: ArrayLike) -> float:
    r"""Code up to which the thrust is zero: the root of K_F0 + K_F1 N + K_F2 N^2 [N].

    The paper prints "T = 0 for |N| <= K_F0", but K_F0 is a (negative) thrust. 0 if the polynomial
    does not start below zero, inf if it never becomes positive.

    References
    ----------
    Kostenko 2023, eq. (4).

    >>> round(dead_zone_code([-4.0, 0.254, 8.82e-4]), 2)
    14.97
    """
    k0, k1, k2 = (float(k) for k in np.asarray(coefficients, float))
    if k0 >= 0.0:
        return 0.0
    discriminant = k1**2 - 4.0 * k2 * k0
    if discriminant < 0.0:
        return np.inf
    # the first root: the polynomial starts negative at N = 0 and rises through zero there
    denominator = k1 + np.sqrt(discriminant)
    return float(-2.0 * k0 / denominator) if denominator > 0.0 else np.inf


@dataclass(frozen=True)
class ThrustGrid:
    """One sign of thrust.

    `speed_mps` shape (v,), from 0, rising; `thrust_max_n` shape (v,), positive; `fraction` shape
    (f,), rising from 0 to 1; `code` shape (v, f), positive magnitudes, rows rising strictly, the
    first column the edge of the dead zone, the last the largest code; `drag_n` shape (v,), the drag
    at code 0, or empty for none.
    """

    speed_mps: FloatArray
    thrust_max_n: FloatArray
    fraction: FloatArray
    code: FloatArray
    drag_n: FloatArray = field(default_factory=lambda: np.zeros(0))

    def drag_at(self, speed_mps: FloatArray) -> FloatArray:
        """Drag of the undriven propeller at speeds of either sign; held beyond the last. [N]."""
        if not self.drag_n.size:
            return np.zeros_like(speed_mps)
        return np.asarray(np.interp(np.abs(speed_mps), self.speed_mps, self.drag_n))

    def at_speed(self, speed_mps: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Interpolate to speeds shape (m,): T_max shape (m,) and code rows shape (m, f)."""
        speed = _within(speed_mps, self.speed_mps[0], self.speed_mps[-1])
        upper = np.searchsorted(self.speed_mps, speed)
        upper = np.minimum(np.maximum(upper, 1), max(len(self.speed_mps) - 1, 1))
        if len(self.speed_mps) == 1:
            ones = np.ones_like(speed)
            return ones * self.thrust_max_n[0], ones[:, None] * self.code[0]
        low = self.speed_mps[upper - 1]
        share = (speed - low) / (self.speed_mps[upper] - low)
        largest = (1 - share) * self.thrust_max_n[upper - 1] + share * self.thrust_max_n[upper]
        rows = (1 - share)[:, None] * self.code[upper - 1] + share[:, None] * self.code[upper]
        return largest, rows


def _within(x: FloatArray, low: ArrayLike, high: ArrayLike) -> FloatArray:
    """Return `np.clip`, which takes three times as long for the few thrusters of a vehicle."""
    return np.minimum(np.maximum(x, low), high)


def _interpolate_rows(x: FloatArray, knots: FloatArray, values: FloatArray) -> FloatArray:
    """Linear interpolation with a row of knots and a row of values for every x, clamped."""
    upper = np.clip(np.sum(knots < x[:, None], axis=1), 1, knots.shape[1] - 1)
    rows = np.arange(len(x))
    x_low, x_high = knots[rows, upper - 1], knots[rows, upper]
    y_low, y_high = values[rows, upper - 1], values[rows, upper]
    share = _within((x - x_low) / (x_high - x_low), 0.0, 1.0)
    return np.asarray(y_low + share * (y_high - y_low))


def code_from_thrust(
    thrust_n: ArrayLike,
    speed_mps: ArrayLike,
    *,
    positive: ThrustGrid,
    negative: ThrustGrid,
    thrust_dead_n: float,
) -> FloatArray:
    """Inverse characteristic N(T, V), signed and clamped to the grid's range, not yet rounded.

    Thrust [N] and speed of the vehicle along the thruster's positive direction [m/s] broadcast
    together. At and below `thrust_dead_n` the code is zero (Kostenko 2023, eq. 8: 0.5 N).
    """
    thrust, speed = np.broadcast_arrays(np.asarray(thrust_n, float), np.asarray(speed_mps, float))
    code = np.zeros(thrust.shape)
    for sign, grid in ((1.0, positive), (-1.0, negative)):
        mask = sign * thrust > thrust_dead_n
        if not mask.any():
            continue
        largest, rows = grid.at_speed(np.maximum(sign * speed[mask], 0.0))
        fraction = np.minimum(sign * thrust[mask] / largest, 1.0)
        upper = np.searchsorted(grid.fraction, fraction)
        upper = np.minimum(np.maximum(upper, 1), len(grid.fraction) - 1)
        low, high, each = grid.fraction[upper - 1], grid.fraction[upper], np.arange(len(upper))
        share = _within((fraction - low) / (high - low), 0.0, 1.0)
        below, above = rows[each, upper - 1], rows[each, upper]
        code[mask] = sign * (below + share * (above - below))
    return code


def thrust_from_code(
    code: ArrayLike, speed_mps: ArrayLike, *, positive: ThrustGrid, negative: ThrustGrid
) -> FloatArray:
    """Forward characteristic T(N, V) [N], the inverse of `code_from_thrust` where the code drives.

    Inside the dead zone it is zero at rest and the drag's share under way.
    """
    codes, speed = np.broadcast_arrays(np.asarray(code, float), np.asarray(speed_mps, float))
    thrust = np.zeros(codes.shape)
    for sign, grid in ((1.0, positive), (-1.0, negative)):
        mask = (sign * codes > 0) | ((codes == 0) & (sign * speed > 0))
        if not mask.any():
            continue
        along, size = sign * speed[mask], sign * codes[mask]
        largest, rows = grid.at_speed(np.maximum(along, 0.0))
        values = np.broadcast_to(grid.fraction, rows.shape)
        driven = largest * _interpolate_rows(size, rows, values)
        drag, edge = grid.drag_at(along), rows[:, 0]
        idle = drag * (1.0 - size / np.maximum(edge, 1e-12))
        driven = np.where((along > 0) & (size < edge), -idle, driven)
        thrust[mask] = sign * np.where(along > 0, driven, np.maximum(driven, drag))
    return thrust + 0.0


def thrust_limits(
    speed_mps: ArrayLike, *, positive: ThrustGrid, negative: ThrustGrid, code_min: float
) -> tuple[FloatArray, FloatArray]:
    """Largest and most negative thrust that an allocator may ask for at a speed. [N].

    +-T_max(V) as the paper takes it: against the motion no more is promised than along it. In
    reverse the thrust at `code_min`.
    """
    speed = np.asarray(speed_mps, float).ravel()
    zero, size = np.zeros_like(speed), np.abs(speed)
    forward, at_rest = positive.at_speed(size)[0], positive.at_speed(zero)[0]
    forward = np.where(speed < 0, np.minimum(forward, at_rest), forward)
    reverse, rest = (
        thrust_from_code(code_min, v, positive=positive, negative=negative) for v in (-size, zero)
    )
    reverse = np.minimum(np.where(speed > 0, np.maximum(reverse, rest), reverse), 0.0)
    shape = np.shape(speed_mps)
    return forward.reshape(shape), reverse.reshape(shape) + 0.0
