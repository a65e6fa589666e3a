"""Models of the exported allocator: single precision to the bit, fixed point to the integer.

Both take many calls at once and do for each what the C code does, in the same order.
"""

import numpy as np

from pipeline.control.bounded_allocation import EPSILON, Arithmetic, Floats, bounded_thrusts
from pipeline.export import fixed_point, single_precision
from pipeline.export.allocator_layout import AllocatorLayout, PaperConstants
from pipeline.export.fixed_point import FixedTables
from pipeline.export.grid_check import FLAG
from pipeline.export.single_precision import SingleTables
from pipeline.types import IntArray
from pipeline.vehicle.schema import Allocator

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


def allocate_single(
    layout: AllocatorLayout, tables: SingleTables, wrench: Floats, velocity: Floats
) -> tuple[Floats, IntArray, IntArray]:
    """Thrusts (m, n) [N], codes (m, n), flags (m,) of wrenches (m, 6), velocities (m, 3)."""
    do = Arithmetic(np.float32)
    nan = np.isnan(wrench).any(axis=1) | np.isnan(velocity).any(axis=1)
    held = [np.where(nan[:, None], do.zero, x.astype(np.float32)) for x in (wrench, velocity)]
    with np.errstate(invalid="ignore", over="ignore"):
        along = _along(do, layout, held[1])
    nan = nan | np.isnan(along).any(axis=1)
    held[0], along = (np.where(nan[:, None], do.zero, x) for x in (held[0], along))
    gain = do.small(layout.gain, 24)
    high, low = (
        single_precision.thrust_limit(tables, along, sign=sign) * gain[:, side]
        for sign, side in ((1, 0), (-1, 1))
    )
    thrust, flags = _divide(do, layout, held[0], low, high)
    divisor = do.small(layout.divisor, 24)
    own = thrust / np.where(thrust < 0, divisor[:, 1], divisor[:, 0])
    codes = _sent(layout, single_precision.code_from_thrust(tables, own, along), tables.code_min)
    flags = flags | _told(single_precision.thrust_flags(tables, own, along))
    return (
        np.where(nan[:, None], do.zero, thrust),
        np.where(nan[:, None], 0, codes),
        np.where(nan, FLAG["NOT_A_NUMBER"], flags),
    )


def allocate_fixed(
    layout: AllocatorLayout, tables: FixedTables, wrench_q16: IntArray, velocity_q16: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Thrusts (m, n) Q16.16 [N], codes (m, n), flags (m,); arguments in Q16.16."""
    do = FixedArithmetic(layout.shift)
    wrench, velocity = wrench_q16.astype(np.int64), velocity_q16.astype(np.int64)
    along = np.clip(_along(do, layout, velocity), -INT32_MAX, INT32_MAX)
    gain, over = do.small(layout.gain, 24), do.small(1.0 / layout.divisor, 24)
    high, low = (
        do.times(fixed_point.thrust_limit(tables, along, sign=sign), gain[:, side], 24)
        for sign, side in ((1, 0), (-1, 1))
    )
    thrust, flags = _divide(do, layout, wrench, low, high)
    own = do.times(thrust, np.where(thrust < 0, over[:, 1], over[:, 0]), 24)
    codes = _sent(layout, fixed_point.code_from_thrust(tables, own, along), tables.code_min)
    return thrust, codes, flags | _told(fixed_point.thrust_flags(tables, own, along))


def _sent(layout: AllocatorLayout, codes: IntArray, code_min: int) -> IntArray:
    """Codes beyond the dead zones that thrusters have of their own, as the C code rounds them."""
    lost, largest = layout.lost_q8, np.rint(layout.corrections.code_max).astype(np.int64)
    if not lost.any():
        return codes
    size = np.abs(codes.astype(np.int64))
    moved = (lost * largest + size * (256 * largest - lost) + 128 * largest) // (256 * largest)
    sent = np.where((size == 0) | (lost == 0), codes, np.sign(codes) * moved)
    return np.maximum(sent, code_min)


def _told(flags: IntArray) -> IntArray:
    """Collect what holds for any thruster; whether a limit cut, the division tells."""
    told: IntArray = np.bitwise_or.reduce(flags & ~FLAG["SATURATED"], axis=1)
    return told


def _along(do: Arithmetic, layout: AllocatorLayout, velocity: Floats) -> Floats:
    """Speed along each thruster, (m, n)."""
    d = do.small(layout.flow, 30)
    parts = [do.times(velocity[:, k : k + 1], d[:, k], 30) for k in range(3)]
    return np.asarray(parts[0] + parts[1] + parts[2])


def _divide(
    do: Arithmetic, layout: AllocatorLayout, wrench: Floats, low: Floats, high: Floats
) -> tuple[Floats, IntArray]:
    """Thrusts within limits, and the flags of what cut."""
    if layout.paper is not None:
        return _divide_by_paper(do, layout, layout.paper, wrench, (low, high))
    thrust, cut = bounded_thrusts(
        layout.allocation, wrench, low, high, largest_n=layout.largest_n, arithmetic=do
    )
    return thrust, FLAG["SATURATED"] * cut.astype(np.int64)


def _divide_by_paper(
    do: Arithmetic,
    layout: AllocatorLayout,
    geometry: Allocator,
    wrench: Floats,
    limits: tuple[Floats, Floats],
) -> tuple[Floats, IntArray]:
    """Divide by eqs. (5) and (6)."""
    low, high = limits
    one, largest = PaperConstants.of(geometry), do.large(LARGEST_PAPER)
    tau = np.clip(wrench, -largest, largest)

    def by(x: Floats, constant: float) -> Floats:
        return do.times(x, do.small(constant, 24), 24)

    flags = np.zeros(len(tau), np.int64)

    def held(x: Floats, least: Floats, most: Floats, flag: str) -> Floats:
        nonlocal flags
        flags = flags | np.where((x < least) | (x > most), FLAG[flag], 0)
        return np.clip(x, least, most)

    thrust, pitch = np.zeros_like(low), tau[:, 4]
    if layout.bow is not None:
        up = by(pitch - by(tau[:, 2], one.stern_arm_m), one.bow_share_1pm)
        pitch = by(tau[:, 2] + up, one.stern_arm_m)
        thrust[:, layout.bow] = held(up, low[:, layout.bow], high[:, layout.bow], "SATURATED")
    forward = high[:, layout.stern].min(axis=1)
    reverse = (-low[:, layout.stern]).min(axis=1)
    both = np.minimum(forward, reverse)
    scaled = geometry.form == "scaled"

    def channel(x: Floats, back: Floats, ahead: Floats, portion: float) -> Floats:
        share = 1.0 if scaled else portion
        flag = "SATURATED" if scaled else "LIMITED_BY_PORTION"
        kept = held(x, -by(back, share), by(ahead, share), flag)
        return by(kept, portion) if scaled else kept

    surge = channel(by(tau[:, 0], one.surge), reverse, forward, one.portions[0])
    heading = channel(-by(tau[:, 5], one.moment_1pm), both, both, one.portions[1])
    swing = channel(by(pitch, one.moment_1pm), both, both, one.portions[2])
    for place, value in zip(
        layout.stern, (surge - swing, surge + swing, surge - heading, surge + heading), strict=True
    ):
        thrust[:, place] = np.clip(value, low[:, place], high[:, place])
    return thrust, flags
