"""The bounded allocation of the exported allocator, in any of its arithmetics."""

import numpy as np

from pipeline.control.bounded_allocation import (
    MOST_STEPS,
    SMALLEST_STEP,
    Allocation,
    Arithmetic,
    Floats,
    largest_demand,
)
from pipeline.export.fixed_point import INT32_MAX, FixedArithmetic
from pipeline.types import BoolArray, IntArray


class FloatModel(Arithmetic):
    """What the C code does in floating point; `bits` are of no meaning here."""

    def times(self, large: Floats, small: Floats, bits: int) -> Floats:  # noqa: ARG002
        """Product."""
        return np.asarray(large * small)

    def square(self, x: Floats, y: Floats) -> Floats:
        """Product of two entries of the scaled matrix."""
        return np.asarray(x * y)

    def share(self, room: Floats, size: Floats) -> Floats:
        """Room over a size that is larger."""
        return np.asarray(room / size)

    def factor(self, x: Floats, pivot: Floats) -> Floats:
        """Entry of L."""
        return np.asarray(x / pivot)

    def solved(self, y: Floats, pivot: Floats) -> Floats:
        """Solution before the back substitution."""
        return np.asarray(y / pivot)

    def released(self, pull: Floats, release: Floats) -> Floats:
        """Step of a thruster let go by itself."""
        return np.asarray(pull * release)


class FixedModel(FixedArithmetic):
    """What the C code does in integers."""

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

    def released(self, pull: Floats, release: Floats) -> IntArray:
        """Step of a thruster let go by itself."""
        return _over(pull * release, 8)


def _over(x: Floats, bits: int) -> IntArray:
    """X / 2^bits towards zero, as C divides."""
    return np.asarray((x + ((x >> 63) & ((1 << bits) - 1))) >> bits)


def _divided(x: Floats, y: Floats) -> IntArray:
    return np.asarray(np.sign(x) * (np.abs(x) // y))


Model = FloatModel | FixedModel


def bounded_thrusts(
    allocation: Allocation,
    wrench: Floats,
    low: Floats,
    high: Floats,
    *,
    largest_n: float,
    arithmetic: Model | None = None,
) -> tuple[Floats, BoolArray]:
    """Thrusts (m, n) for wrenches (m, 6) within limits (m, n), and where a limit cut (m,).

    Parameters
    ----------
    allocation : Allocation
        Of the arrangement.
    wrench : ndarray, shape (m, 6)
        SNAME. [N], [N m]
    low, high : ndarray, shape (m, n)
        Limits, low <= 0 <= high. [N]
    largest_n : float
        Largest limit of all: the unit of what is large and small. [N]
    arithmetic : Arithmetic, optional
        Double precision unless the firmware's is wanted.
    """
    do = FloatModel() if arithmetic is None else arithmetic
    a, count = do.small(allocation.scaled, 30), allocation.count
    inverse, scale = do.small(allocation.inverse, 24), do.small(allocation.scale, 24)
    release, smallest = do.small(allocation.release, 8), do.large(SMALLEST_STEP * largest_n)
    most = do.large(largest_demand(allocation, largest_n))
    tau = np.clip(wrench, -most, most)
    target = do.times(tau, scale, 24)
    thrust = np.stack([_dot(do, tau, inverse[i], 24) for i in range(count)], axis=1)
    held: BoolArray = np.asarray((thrust < low) | (thrust > high), bool)
    cut: BoolArray = np.asarray(held.any(axis=1), bool)
    work = np.flatnonzero(cut)
    thrust = np.where(cut[:, None], np.clip(thrust, low, high), thrust)
    for _ in range(MOST_STEPS):
        if not work.size:
            break
        t, lo, hi, fixed = thrust[work], low[work], high[work], held[work]
        step = _step(do, a, _left(do, a, target[work], t), fixed)
        size, room = np.abs(step), np.where(step > 0, hi - t, t - lo)
        blocked = ~fixed & (size > room)
        shares = np.where(blocked, do.share(room, np.where(blocked, size, do.one)), do.one)
        rows, first = np.arange(work.size), np.argmin(shares, axis=1)
        share = shares[rows, first]
        stopped = share < do.one
        moved = np.clip(t + do.times(step, share[:, None], 30), lo, hi)
        moved[rows[stopped], first[stopped]] = np.where(
            step[rows, first] > 0, hi[rows, first], lo[rows, first]
        )[stopped]
        fixed[rows[stopped], first[stopped]] = True
        left = _left(do, a, target[work], moved)
        pull = np.stack([_dot(do, left, a[:, i], 30) for i in range(count)], axis=1)
        pull = do.released(pull, release)
        at_high = moved >= hi
        inside = np.where(at_high, moved - lo, hi - moved) > smallest
        inward = np.where(fixed & inside, np.where(at_high, -pull, pull), do.zero)
        best = np.argmax(inward, axis=1)
        freed = ~stopped & (inward[rows, best] > smallest)
        fixed[rows[freed], best[freed]] = False
        thrust[work], held[work] = moved, fixed
        still = size.max(axis=1) <= smallest
        work = work[stopped | freed | ~still]
    return thrust, cut


def _dot(do: Model, large: Floats, small: Floats, bits: int) -> Floats:
    """Sum of products in order, as C does it: columns (m, k) with a row (k,)."""
    total = do.times(large[:, 0], small[0], bits)
    for k in range(1, small.size):
        total = total + do.times(large[:, k], small[k], bits)
    return total


def _left(do: Model, a: Floats, target: Floats, thrust: Floats) -> Floats:
    """Take what the thrusts give off the demand, (m, 6)."""
    left = target.copy()
    for i in range(a.shape[1]):
        left = left - do.times(thrust[:, i : i + 1], a[:, i], 30)
    return left


def _step(do: Model, a: Floats, left: Floats, held: BoolArray) -> Floats:
    """Step (m, n) of the free thrusters."""
    m, n = held.shape
    gram = [[np.full(m, do.epsilon if i == j else do.zero) for j in range(i + 1)] for i in range(6)]
    for k in range(n):
        for i in range(6):
            for j in range(i + 1):
                added = do.square(a[i, k], a[j, k])
                gram[i][j] = gram[i][j] + np.where(held[:, k], do.zero, added)
    found = _solve(do, gram, left)
    bits = do.solution_bits
    return np.stack(
        [np.where(held[:, i], do.zero, _dot(do, found, a[:, i], bits)) for i in range(n)], axis=1
    )


def _solve(do: Model, gram: list[list[Floats]], left: Floats) -> Floats:
    """Solve six symmetric equations (lower triangle of `gram`) by L D L^T, (m, 6)."""
    lower: list[list[Floats]] = [[do.zero] * 6 for _ in range(6)]
    for j in range(6):
        for i in range(j, 6):
            for k in range(j):
                product = do.times(do.times(gram[k][k], lower[i][k], 24), lower[j][k], 24)
                gram[i][j] = gram[i][j] - product
        gram[j][j] = np.maximum(gram[j][j], do.half_epsilon)
        for i in range(j + 1, 6):
            lower[i][j] = do.factor(gram[i][j], gram[j][j])
    x = [left[:, i] for i in range(6)]
    for i in range(6):
        for k in range(i):
            x[i] = x[i] - do.times(x[k], lower[i][k], 24)
    x = [do.solved(x[i], gram[i][i]) for i in range(6)]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            x[i] = x[i] - do.times(x[k], lower[k][i], 24)
    return np.stack(x, axis=1)
