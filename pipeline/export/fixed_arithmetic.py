"""Arithmetic of the exported allocator's fixed-point variant, as the C code does it."""

import numpy as np

from pipeline.control.bounded_allocation import EPSILON, Arithmetic
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

    @property
    def solution_bits(self) -> int:
        """Format of the product of the solution and an entry."""
        return 36 - self.shift
