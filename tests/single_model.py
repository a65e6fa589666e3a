"""A model of the floating-point firmware in numpy's float32, to the bit.

The model does the same operations in the same order and in single precision, so it gives the same
bits as the C code wherever the compiler neither fuses a multiplication with an addition
(``-ffp-contract=off``) nor keeps intermediate results wider than ``float`` (``FLT_EVAL_METHOD`` 0).
Elsewhere the two differ by a few units in the last place of T_max.

Between two knots the form a + share (b - a) is used and cut off at b: rounding is monotone, so the
code never falls when the thrust rises, not even by a last bit at a knot.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.export.c_text import (
    Float32Array,
    SingleBranch,
    SingleTables,
    single_tables,
)
from pipeline.export.grid_check import FLAG
from pipeline.types import IntArray

__all__ = ["code_from_thrust", "single_tables", "thrust_flags", "thrust_from_code", "thrust_limit"]

#: What the model accepts where the C code takes one float.
Float32Like = float | npt.NDArray[np.floating]


@dataclass(frozen=True)
class _Place:
    """Where arguments lie between two knots: indices and the share of the way."""

    low: IntArray
    high: IntArray
    share: Float32Array


def _between(low: Float32Array, high: Float32Array, share: Float32Array) -> Float32Array:
    mixed: Float32Array = low + share * (high - low)
    return mixed


def _between_rising(low: Float32Array, high: Float32Array, share: Float32Array) -> Float32Array:
    return np.minimum(_between(low, high, share), high)


def _locate(knots: Float32Array, x: Float32Array) -> _Place:
    """Find x among rows of knots, shape (m, k); at and beyond an end there is nothing to share."""
    last = knots.shape[1] - 1
    rows = np.arange(len(x))
    low = np.clip((knots <= x[:, None]).sum(axis=1) - 1, 0, max(last - 1, 0))
    high = np.minimum(low + 1, last)
    inside = (x > knots[:, 0]) & (x < knots[:, last])
    above = np.where(inside, x - knots[rows, low], np.float32(0)).astype(np.float32)
    width = np.where(inside, knots[rows, high] - knots[rows, low], np.float32(1)).astype(np.float32)
    end = np.where(x >= knots[:, last], last, 0)
    share: Float32Array = above / width
    return _Place(low=np.where(inside, low, end), high=np.where(inside, high, end), share=share)


def _row_at(branch: SingleBranch, along: Float32Array) -> tuple[Float32Array, Float32Array]:
    """T_max shape (m,) and codes shape (m, k) at speeds along the thrust, shape (m,)."""
    place = _locate(np.broadcast_to(branch.speed_mps, (len(along), len(branch.speed_mps))), along)
    largest = _at(branch.thrust_max_n, place)
    codes = _between(branch.code[place.low], branch.code[place.high], place.share[:, None])
    return largest, codes


def _at(values: Float32Array, place: _Place) -> Float32Array:
    return _between(values[place.low], values[place.high], place.share)


def _drag_at(branch: SingleBranch, speed: Float32Array) -> Float32Array:
    """Drag of the undriven propeller at speeds of either sign."""
    knots = np.broadcast_to(branch.speed_mps, (len(speed), len(branch.speed_mps)))
    return _at(branch.drag_n, _locate(knots, np.abs(speed)))


def _along(speed: Float32Array, sign: int) -> Float32Array:
    """Speed along the thrust; against the motion the row at rest holds."""
    return np.maximum(speed if sign > 0 else -speed, np.float32(0))


def code_from_thrust(
    tables: SingleTables, thrust_n: Float32Like, speed_mps: Float32Like
) -> npt.NDArray[np.int64]:
    """Do what ``<vehicle>_code_from_thrust_f32`` does, in the same arithmetic.

    Parameters
    ----------
    tables : SingleTables
        The tables in the C source.
    thrust_n, speed_mps : float or ndarray, broadcast together
        Arguments of the C function; rounded to single precision first. [N], [m/s]

    Returns
    -------
    ndarray of int64
        Code, rounded half away from zero, within code_min to code_max; zero where an argument is
        not a number.
    """
    thrust, speed = np.broadcast_arrays(
        np.asarray(thrust_n, np.float32), np.asarray(speed_mps, np.float32)
    )
    code = np.zeros(thrust.shape, np.int64)
    for sign, branch in ((1, tables.positive), (-1, tables.negative)):
        magnitude = thrust if sign > 0 else -thrust
        mask = (magnitude > tables.thrust_dead_n) & ~np.isnan(speed)
        largest, knots = _row_at(branch, _along(speed[mask], sign))
        with np.errstate(over="ignore"):
            fraction = magnitude[mask] / largest
        place = _locate(
            np.broadcast_to(branch.fraction, (len(fraction), len(branch.fraction))), fraction
        )
        rows = np.arange(len(fraction))
        exact = _between_rising(knots[rows, place.low], knots[rows, place.high], place.share)
        whole = np.floor(exact)
        rounded = whole + (exact - whole >= np.float32(0.5))
        code[mask] = sign * rounded.astype(np.int64)
    return np.maximum(code, tables.code_min)


def thrust_from_code(
    tables: SingleTables, code: int | IntArray, speed_mps: Float32Like
) -> Float32Array:
    """Do what ``<vehicle>_thrust_from_code_f32`` does, in the same arithmetic.

    Parameters
    ----------
    tables : SingleTables
        The tables in the C source.
    code, speed_mps : int and float, or ndarrays, broadcast together
        Arguments of the C function. [-], [m/s]

    Returns
    -------
    ndarray of float32
        Thrust; inside the dead zone the drag's share; zero where the speed is not a number. [N]
    """
    held = np.maximum(np.asarray(code, np.int64), tables.code_min)
    codes, speed = np.broadcast_arrays(held, np.asarray(speed_mps, np.float32))
    thrust = np.zeros(codes.shape, np.float32)
    for sign, branch in ((1, tables.positive), (-1, tables.negative)):
        mask = ((sign * codes > 0) | ((codes == 0) & (sign * speed > 0))) & ~np.isnan(speed)
        along = _along(speed[mask], sign)
        largest, knots = _row_at(branch, along)
        place = _locate(knots, (sign * codes[mask]).astype(np.float32))
        fraction = _between_rising(
            branch.fraction[place.low], branch.fraction[place.high], place.share
        )
        driven, drag = fraction * largest, _drag_at(branch, speed[mask])
        size, edge = (sign * codes[mask]).astype(np.float32), knots[:, 0]
        inside = size < edge
        share = size / np.where(inside, edge, np.float32(1))
        dragged = np.where(inside, -_between(drag, np.zeros_like(drag), share), driven)
        thrust[mask] = np.float32(sign) * np.where(along > 0, dragged, np.maximum(driven, drag))
    return thrust + np.float32(0)


def thrust_limit(tables: SingleTables, speed_mps: Float32Like, *, sign: int) -> Float32Array:
    """Do what ``<vehicle>_thrust_max_f32`` (sign 1) and ``_min_f32`` (sign -1) do."""
    speed = np.asarray(speed_mps, np.float32)
    if sign < 0:
        along, rest = (thrust_from_code(tables, tables.code_min, v) for v in (-np.abs(speed), 0.0))
        least = np.where(speed > 0, np.maximum(along, rest), along)
        return np.where(np.isnan(speed), np.float32(0), np.minimum(least, np.float32(0)))
    size = np.where(np.isnan(speed), np.float32(0), np.abs(speed)).reshape(-1)
    limit, at_rest = (
        _row_at(tables.positive, v)[0].reshape(speed.shape) for v in (size, np.zeros_like(size))
    )
    limit = np.where(speed < 0, np.minimum(limit, at_rest), limit)
    return np.where(np.isnan(speed), np.float32(0), limit)


def thrust_flags(
    tables: SingleTables, thrust_n: Float32Like, speed_mps: Float32Like
) -> npt.NDArray[np.int64]:
    """Do what ``<vehicle>_thruster_flags_f32`` does."""
    thrust, speed = np.broadcast_arrays(
        np.asarray(thrust_n, np.float32), np.asarray(speed_mps, np.float32)
    )
    most, least = (thrust_limit(tables, speed, sign=sign) for sign in (1, -1))
    live = np.abs(thrust) > tables.thrust_dead_n
    flags = (
        FLAG["SATURATED"] * ((thrust > most) | (thrust < least))
        + FLAG["OUT_OF_TESTED_RANGE"] * (np.abs(speed) > tables.tested_mps)
        + FLAG["IN_DEAD_ZONE"] * (~live & (thrust != 0))
        + FLAG["AGAINST_THE_MOTION"] * (live & (np.sign(thrust) * np.sign(speed) < 0))
    )
    return np.where(np.isnan(thrust) | np.isnan(speed), FLAG["NOT_A_NUMBER"], flags)
