"""The monotone thruster characteristic: code against thrust on a grid that follows T_max(V).

For each sign of thrust the grid holds, at a few speeds, the largest thrust and the code at equal
fractions of it. Between speeds and between fractions everything is linear, so the two directions
N(T, V) and T(N, V) are exact inverses of each other, both are monotone in T and N as long as the
rows rise, and a controller without a floating-point unit can evaluate them.

Speed is counted along the thrust: reverse thrust meets V = -speed. Against the motion the row at
rest holds (see docs/methods for why and how well).
"""

from dataclasses import dataclass

import numpy as np

from pipeline.types import ArrayLike, FloatArray


@dataclass(frozen=True)
class ThrustGrid:
    """One sign of thrust.

    `speed_mps` shape (v,), from 0, rising; `thrust_max_n` shape (v,), positive; `fraction` shape
    (f,), rising from 0 to 1; `code` shape (v, f), positive magnitudes, rows rising strictly, the
    first column the edge of the dead zone, the last the largest code.
    """

    speed_mps: FloatArray
    thrust_max_n: FloatArray
    fraction: FloatArray
    code: FloatArray

    def at_speed(self, speed_mps: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Interpolate to speeds shape (m,): T_max shape (m,) and code rows shape (m, f)."""
        speed = np.clip(speed_mps, self.speed_mps[0], self.speed_mps[-1])
        upper = np.clip(np.searchsorted(self.speed_mps, speed), 1, max(len(self.speed_mps) - 1, 1))
        if len(self.speed_mps) == 1:
            ones = np.ones_like(speed)
            return ones * self.thrust_max_n[0], ones[:, None] * self.code[0]
        low = self.speed_mps[upper - 1]
        share = (speed - low) / (self.speed_mps[upper] - low)
        largest = (1 - share) * self.thrust_max_n[upper - 1] + share * self.thrust_max_n[upper]
        rows = (1 - share)[:, None] * self.code[upper - 1] + share[:, None] * self.code[upper]
        return largest, rows


def _interpolate_rows(x: FloatArray, knots: FloatArray, values: FloatArray) -> FloatArray:
    """Linear interpolation with a row of knots and a row of values for every x, clamped."""
    upper = np.clip(np.sum(knots < x[:, None], axis=1), 1, knots.shape[1] - 1)
    rows = np.arange(len(x))
    x_low, x_high = knots[rows, upper - 1], knots[rows, upper]
    y_low, y_high = values[rows, upper - 1], values[rows, upper]
    share = np.clip((x - x_low) / (x_high - x_low), 0.0, 1.0)
    return np.asarray(y_low + share * (y_high - y_low))


def code_from_thrust(
    thrust_n: ArrayLike,
    speed_mps: ArrayLike,
    *,
    positive: ThrustGrid,
    negative: ThrustGrid,
    thrust_dead_n: float,
) -> FloatArray:
    """Inverse characteristic N(T, V), not yet rounded to an integer code.

    Parameters
    ----------
    thrust_n, speed_mps : array_like, broadcast together
        Wanted thrust and speed of the vehicle along the thruster's positive direction. [N], [m/s]
    positive, negative : ThrustGrid
        The two signs of thrust.
    thrust_dead_n : float
        At and below this thrust the code is zero (Kostenko 2023, eq. 8: 0.5 N). [N]

    Returns
    -------
    ndarray
        Signed code, clamped to the grid's range.
    """
    thrust, speed = np.broadcast_arrays(np.asarray(thrust_n, float), np.asarray(speed_mps, float))
    code = np.zeros(thrust.shape)
    for sign, grid in ((1.0, positive), (-1.0, negative)):
        mask = sign * thrust > thrust_dead_n
        if not mask.any():
            continue
        largest, rows = grid.at_speed(np.maximum(sign * speed[mask], 0.0))
        fraction = np.minimum(sign * thrust[mask] / largest, 1.0)
        knots = np.broadcast_to(grid.fraction, rows.shape)
        code[mask] = sign * _interpolate_rows(fraction, knots, rows)
    return code


def thrust_from_code(
    code: ArrayLike, speed_mps: ArrayLike, *, positive: ThrustGrid, negative: ThrustGrid
) -> FloatArray:
    """Forward characteristic T(N, V), the exact inverse of `code_from_thrust`.

    Parameters
    ----------
    code, speed_mps : array_like, broadcast together
        Signed code, and speed of the vehicle along the thruster's positive direction. [m/s]
    positive, negative : ThrustGrid
        The two signs of thrust.

    Returns
    -------
    ndarray
        Thrust; zero inside the dead zone. [N]
    """
    codes, speed = np.broadcast_arrays(np.asarray(code, float), np.asarray(speed_mps, float))
    thrust = np.zeros(codes.shape)
    for sign, grid in ((1.0, positive), (-1.0, negative)):
        mask = sign * codes > 0
        if not mask.any():
            continue
        largest, rows = grid.at_speed(np.maximum(sign * speed[mask], 0.0))
        values = np.broadcast_to(grid.fraction, rows.shape)
        thrust[mask] = sign * largest * _interpolate_rows(sign * codes[mask], rows, values)
    return thrust
