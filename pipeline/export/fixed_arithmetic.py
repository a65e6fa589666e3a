"""Arithmetic of the exported allocator's fixed-point variant, as the C code does it."""

import numpy as np

from pipeline.control.bounded_allocation import EPSILON, Arithmetic, Floats
from pipeline.types import IntArray

#: A demand of eq. (6) is held to this. [N], [N m]
LARGEST_PAPER = 30000.0
INT32_MAX = 2**31 - 1


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

    def times(self, large: Floats, small: Floats, bits: int) -> IntArray:
        """Product over 2^bits for |large| < 2^47, |small| < 2^31, in two parts as C does it."""
        high = _over(large, 16)
        return _over(high * small, bits - 16) + _over((large - (high << 16)) * small, bits)

    def square(self, x: Floats, y: Floats) -> IntArray:
        """Product of two entries of the scaled matrix, Q30."""
        return _over(x * y, 30)

    def share(self, room: Floats, size: Floats) -> IntArray:
        """Room over size, Q30."""
        return np.asarray((room << 30) // size)

    def factor(self, x: Floats, pivot: Floats) -> IntArray:
        """Entry of L, Q7.24."""
        return np.clip(_divided(x << 24, pivot), -INT32_MAX, INT32_MAX)

    def solved(self, y: Floats, pivot: Floats) -> IntArray:
        """Solution before the back substitution."""
        return _divided(y << (36 - self.shift), pivot)

    @property
    def solution_bits(self) -> int:
        """Format of the product of the solution and an entry."""
        return 36 - self.shift

    def released(self, pull: Floats, release: Floats) -> IntArray:
        """Step of a thruster let go by itself."""
        return _over(pull * release, 8)


def _over(x: Floats, bits: int) -> IntArray:
    """X / 2^bits towards zero, as C divides."""
    return np.asarray((x + ((x >> 63) & ((1 << bits) - 1))) >> bits)


def _divided(x: Floats, y: Floats) -> IntArray:
    return np.asarray(np.sign(x) * (np.abs(x) // y))
