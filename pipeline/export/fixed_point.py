r"""The fixed-point firmware: its tables and a bit-exact model of its C code.

Formats, all 32 bits wide:

======================  ==========  =========================  ====================
quantity                format      range                      resolution
======================  ==========  =========================  ====================
thrust                  Q16.16      -32768 to 32768 N          1.5e-5 N
speed                   Q16.16      -32768 to 32768 m/s        1.5e-5 m/s
code inside the tables  UQ16.16     0 to 32767                 1.5e-5 codes
share, fraction         UQ2.30      0 to 1                     9.3e-10
======================  ==========  =========================  ====================

Everything inside is unsigned, so no shift of a negative number is left to the compiler. Products
are 32 by 32 to 64 bits. A division is thirty steps of shift and subtract in C, which gives the
floor of the quotient, as ``//`` does here; no processor needs a divider for it.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.control.bounded_allocation import EPSILON, Arithmetic
from pipeline.export.grid_check import largest_negative
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic
from pipeline.types import IntArray

#: A demand of eq. (6) is held to this. [N], [N m]
LARGEST_PAPER = 30000.0
INT32_MAX = 2**31 - 1

Q16_ONE = 1 << 16
Q16_HALF = 1 << 15
Q30_ONE = 1 << 30
Q30_HALF = 1 << 29

#: What the model accepts where the C code takes one int32_t or int16_t.
IntLike = int | npt.NDArray[np.integer]


class FixedArithmetic(Arithmetic):
    """Large numbers Q16.16 in 64 bits, small ones in 32 with the bits that are named.

    `shift`: the unit of the bounded allocation as a power of two of newtons; the solution of its
    equations is Q(22 - shift).
    """

    def __init__(self, shift: int) -> None:
        super().__init__()
        self.shift = shift
        self.zero, self.one = np.int64(0), np.int64(1 << 30)
        self.epsilon = np.int64(round(EPSILON * (1 << 30)))
        self.half_epsilon = self.epsilon // 2

    def small(self, values: object, bits: int) -> IntArray:
        """Constants of a matrix, rounded."""
        rounded: IntArray = np.rint(np.asarray(values, float) * (1 << bits)).astype(np.int64)
        return rounded

    def large(self, values: object) -> IntArray:
        """Constants in newtons or newton metres, Q16.16 within an int32_t."""
        return np.minimum(self.small(values, 16), INT32_MAX)

    @property
    def solution_bits(self) -> int:
        """Format of the product of the solution and an entry."""
        return 36 - self.shift


@dataclass(frozen=True)
class FixedBranch:
    """One sign of thrust: speeds and T_max in Q16.16, fractions in UQ2.30, codes in UQ16.16."""

    speed_q16: IntArray
    thrust_max_q16: IntArray
    fraction_q30: IntArray
    code_q16: IntArray
    drag_q16: IntArray


@dataclass(frozen=True)
class FixedTables:
    """Both signs; `thrust_dead_q16` is rounded down so that `>` decides as in real numbers."""

    thrust_dead_q16: int
    code_min: int
    code_max: int
    tested_q16: int
    positive: FixedBranch
    negative: FixedBranch


def fixed_tables(characteristic: FirmwareCharacteristic) -> FixedTables:
    """Quantise a characteristic that `check_characteristic` accepted."""
    return FixedTables(
        thrust_dead_q16=int(np.floor(characteristic.thrust_dead_n * Q16_ONE)),
        code_min=characteristic.code_min,
        code_max=characteristic.code_max,
        tested_q16=int(np.rint(characteristic.fastest_tested_mps * Q16_ONE)),
        positive=_fixed_branch(characteristic.positive, characteristic.code_max),
        negative=_fixed_branch(characteristic.negative, largest_negative(characteristic)),
    )


def _fixed_branch(branch: FirmwareBranch, code_max: int) -> FixedBranch:
    def quantised(values: object, one: int) -> IntArray:
        return np.rint(np.asarray(values, dtype=np.float64) * one).astype(np.int64)

    return FixedBranch(
        speed_q16=quantised(branch.speed_mps, Q16_ONE),
        thrust_max_q16=quantised(branch.thrust_max_n, Q16_ONE),
        fraction_q30=quantised(branch.fraction, Q30_ONE),
        code_q16=quantised(np.clip(branch.code, 0.0, code_max), Q16_ONE),
        drag_q16=quantised(branch.drag_n or np.zeros(len(branch.speed_mps)), Q16_ONE),
    )


@dataclass(frozen=True)
class _Place:
    """Where arguments lie between two knots: indices and the share of the way, UQ2.30."""

    low: IntArray
    high: IntArray
    share: IntArray


def _between(low: IntArray, high: IntArray, share: IntArray) -> IntArray:
    """Mix two unsigned numbers and round to nearest: the only place where precision is lost."""
    mixed: IntArray = (low * (Q30_ONE - share) + high * share + Q30_HALF) >> 30
    return mixed


def _ratio(numerator: IntArray, denominator: IntArray) -> IntArray:
    """Floor of numerator / denominator in UQ2.30, for numerator < denominator < 2^31."""
    ratio: IntArray = (numerator << 30) // denominator
    return ratio


def _locate(knots: IntArray, x: IntArray) -> _Place:
    """Find x among rows of knots, shape (m, k); at and beyond an end there is nothing to share."""
    last = knots.shape[1] - 1
    rows = np.arange(len(x))
    low = np.clip((knots <= x[:, None]).sum(axis=1) - 1, 0, max(last - 1, 0))
    high = np.minimum(low + 1, last)
    width = np.maximum(knots[rows, high] - knots[rows, low], 1)
    inside = (x > knots[:, 0]) & (x < knots[:, last])
    share = _ratio(np.where(inside, x - knots[rows, low], 0), width)
    end = np.where(x >= knots[:, last], last, 0)
    return _Place(
        low=np.where(inside, low, end),
        high=np.where(inside, high, end),
        share=np.where(inside, share, 0),
    )


def _at(values: IntArray, place: _Place) -> IntArray:
    return _between(values[place.low], values[place.high], place.share)


def _along(speed: IntArray, sign: int) -> IntArray:
    """Speed along the thrust; against the motion the row at rest holds."""
    return np.maximum(sign * speed, 0)


def _row_at(branch: FixedBranch, along: IntArray) -> tuple[IntArray, IntArray]:
    """T_max shape (m,) and codes shape (m, k) at speeds along the thrust, shape (m,)."""
    place = _locate(np.broadcast_to(branch.speed_q16, (len(along), len(branch.speed_q16))), along)
    largest = _at(branch.thrust_max_q16, place)
    codes = _between(branch.code_q16[place.low], branch.code_q16[place.high], place.share[:, None])
    return largest, codes


def code_from_thrust(
    tables: FixedTables, thrust_q16: IntLike, speed_q16: IntLike
) -> npt.NDArray[np.int64]:
    """Do what ``<vehicle>_code_from_thrust_q`` does, to the bit; arguments broadcast together.

    Thrust and speed are Q16.16 in the range of an int32_t [N, m/s]; the code is rounded half away
    from zero, within code_min to code_max.
    """
    thrust, speed = np.broadcast_arrays(
        np.asarray(thrust_q16, np.int64), np.asarray(speed_q16, np.int64)
    )
    code = np.zeros(thrust.shape, np.int64)
    for sign, branch in ((1, tables.positive), (-1, tables.negative)):
        mask = sign * thrust > tables.thrust_dead_q16
        largest, knots = _row_at(branch, _along(speed[mask], sign))
        magnitude = sign * thrust[mask]
        saturated = magnitude >= largest
        fraction = np.where(saturated, Q30_ONE, _ratio(np.where(saturated, 0, magnitude), largest))
        place = _locate(
            np.broadcast_to(branch.fraction_q30, (len(fraction), len(branch.fraction_q30))),
            fraction,
        )
        rows = np.arange(len(fraction))
        exact = _between(knots[rows, place.low], knots[rows, place.high], place.share)
        code[mask] = sign * ((exact + Q16_HALF) >> 16)
    return np.maximum(code, tables.code_min)
