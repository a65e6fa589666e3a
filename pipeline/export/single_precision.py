"""The floating-point firmware: its tables and a model of its C code in numpy's float32.

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

from pipeline.export.grid_check import largest_negative
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic
from pipeline.types import IntArray

Float32Array = npt.NDArray[np.float32]
#: What the model accepts where the C code takes one float.
Float32Like = float | npt.NDArray[np.floating]


@dataclass(frozen=True)
class SingleBranch:
    """One sign of thrust, every number rounded to single precision."""

    speed_mps: Float32Array
    thrust_max_n: Float32Array
    fraction: Float32Array
    code: Float32Array


@dataclass(frozen=True)
class SingleTables:
    """Both signs; `thrust_dead_n` is rounded down so that `>` decides as in real numbers."""

    thrust_dead_n: np.float32
    code_min: int
    code_max: int
    positive: SingleBranch
    negative: SingleBranch


def single_tables(characteristic: FirmwareCharacteristic) -> SingleTables:
    """Round a characteristic that `check_characteristic` accepted to single precision."""
    dead = np.float32(characteristic.thrust_dead_n)
    if float(dead) > characteristic.thrust_dead_n:
        dead = np.nextafter(dead, np.float32(-np.inf))
    return SingleTables(
        thrust_dead_n=dead,
        code_min=characteristic.code_min,
        code_max=characteristic.code_max,
        positive=_single_branch(characteristic.positive, characteristic.code_max),
        negative=_single_branch(characteristic.negative, largest_negative(characteristic)),
    )


def _single_branch(branch: FirmwareBranch, code_max: int) -> SingleBranch:
    return SingleBranch(
        speed_mps=np.asarray(branch.speed_mps, np.float32),
        thrust_max_n=np.asarray(branch.thrust_max_n, np.float32),
        fraction=np.asarray(branch.fraction, np.float32),
        code=np.clip(branch.code, 0.0, code_max).astype(np.float32),
    )


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
    largest = _between(branch.thrust_max_n[place.low], branch.thrust_max_n[place.high], place.share)
    codes = _between(branch.code[place.low], branch.code[place.high], place.share[:, None])
    return largest, codes


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
        Thrust; zero inside the dead zone and where the speed is not a number. [N]
    """
    held = np.maximum(np.asarray(code, np.int64), tables.code_min)
    codes, speed = np.broadcast_arrays(held, np.asarray(speed_mps, np.float32))
    thrust = np.zeros(codes.shape, np.float32)
    for sign, branch in ((1, tables.positive), (-1, tables.negative)):
        mask = (sign * codes > 0) & ~np.isnan(speed)
        largest, knots = _row_at(branch, _along(speed[mask], sign))
        place = _locate(knots, (sign * codes[mask]).astype(np.float32))
        fraction = _between_rising(
            branch.fraction[place.low], branch.fraction[place.high], place.share
        )
        thrust[mask] = np.float32(sign) * (fraction * largest)
    return thrust


def thrust_limit(tables: SingleTables, speed_mps: Float32Like, *, sign: int) -> Float32Array:
    """Do what ``<vehicle>_thrust_max_f32`` (sign 1) and ``_min_f32`` (sign -1) do."""
    if sign < 0:
        return thrust_from_code(tables, tables.code_min, speed_mps)
    speed = np.atleast_1d(np.asarray(speed_mps, np.float32))
    known = ~np.isnan(speed)
    limit = np.zeros(speed.shape, np.float32)
    limit[known] = _row_at(tables.positive, _along(speed[known], 1))[0]
    return limit.reshape(np.shape(speed_mps))
