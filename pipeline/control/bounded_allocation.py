r"""Thrusts within limits for any arrangement of thrusters: weighted least squares, bounded steps.

Wanted is the wrench tau; with B (6, n) the wrench of one newton of each thruster and the weights w

.. math:: \min_T \| W (B T - \tau) \|^2, \qquad T_{lo} \le T \le T_{hi}

where w is one over the largest wrench of all thrusters together on that axis, so that errors of
force and moment count as shares of what the vehicle has. Within the limits the least thrusts that
give the wrench are W B's pseudo-inverse. Where a limit cuts, an active-set method follows: a step
to the solution with the thrusters at their limits held there, as far as the first limit in the way;
where none is, the held thruster that would gain most is let go (Harkegard 2002, Efficient active
set algorithms for solving constrained least squares problems in aircraft control allocation). The
step solves six equations however many thrusters there are,

.. math:: (A_F A_F^T + \epsilon I) \lambda = r, \qquad p = A_F^T \lambda

with A = W B scaled and r what is left of the demand; epsilon keeps it solvable for any set F of
free thrusters, and what it takes off is made up by the steps that follow. The firmware does the
same operations in the same order (`pipeline.export.fixed_arithmetic`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.types import BoolArray, FloatArray

#: The most steps of a call, and the epsilon of its equations.
MOST_STEPS = 32
EPSILON = 2.0**-12
#: A demand on an axis counts at most as this many times the largest thrust of a thruster, and a
#: step below this share of it is none.
LARGEST_DEMAND, SMALLEST_STEP = 4.0, 2.0**-14
#: An axis on which the thrusters have less than this together is out of their reach. [N/N], [m]
_NO_REACH = 1e-6
#: Singular values below this share of the largest are none.
_RANK = 1e-6

#: Arrays of one of the arithmetics: floats of either precision, or integers.
Floats = Any


@dataclass(frozen=True)
class Allocation:
    """The matrices of one arrangement of n thrusters.

    `matrix` (6, n) is B; `scale` (6,) makes newtons of a demand, r = scale tau, and is zero for an
    axis out of reach; `scaled` (6, n) = scale B with columns of at most 1 / sqrt(n); `inverse`
    (n, 6) the thrusts of a demand without limits; `release` (n,) one over the squared columns.
    """

    matrix: FloatArray
    scale: FloatArray
    scaled: FloatArray
    inverse: FloatArray
    release: FloatArray

    @property
    def count(self) -> int:
        """How many thrusters."""
        return int(self.matrix.shape[1])


def configuration(position_m: FloatArray, direction: FloatArray) -> FloatArray:
    """B (6, n): the wrench of one newton of each thruster, from positions, directions (n, 3)."""
    return np.concatenate([direction.T, np.cross(position_m, direction).T])


def allocation_of(position_m: FloatArray, direction: FloatArray) -> Allocation:
    """Work out the matrices of thrusters at positions (n, 3) [m] with unit directions (n, 3)."""
    matrix = configuration(position_m, direction)
    reach = np.abs(matrix).sum(axis=1)
    weight = np.where(reach > _NO_REACH, 1.0 / np.maximum(reach, _NO_REACH), 0.0)
    weighted = weight[:, None] * matrix
    columns = np.sum(weighted**2, axis=0)
    factor = 1.0 / np.sqrt(columns.max() * matrix.shape[1])
    scale, scaled = factor * weight, factor * weighted
    return Allocation(
        matrix=matrix,
        scale=scale,
        scaled=scaled,
        # round-off of the row of a thruster without direction would be cut by its limits of 0
        inverse=np.linalg.pinv(scaled, rcond=_RANK) * scale * (columns > 0.0)[:, None],
        release=1.0 / np.maximum(np.sum(scaled**2, axis=0), 2.0**-20),
    )


class Arithmetic:
    """Floating point; the firmware's fixed point has the same operations (`fixed_arithmetic`).

    Numbers of a demand, a limit or a thrust are *large*, entries of the matrices *small*; `bits`
    are those of a small number's fixed-point format, of no meaning here.
    """

    zero: Any
    one: Any
    epsilon: Any
    half_epsilon: Any

    def __init__(self, dtype: type[np.floating[Any]] = np.float64) -> None:
        self.dtype: type[Any] = dtype
        self.zero, self.one = dtype(0), dtype(1)
        self.epsilon, self.half_epsilon = dtype(EPSILON), dtype(EPSILON / 2)

    def small(self, values: object, bits: int) -> Floats:  # noqa: ARG002 (a format has bits)
        """Constants of a matrix."""
        return np.asarray(values, self.dtype)

    def large(self, values: object) -> Floats:
        """Constants in newtons or newton metres."""
        return np.asarray(values, self.dtype)

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

    @property
    def solution_bits(self) -> int:
        """Format of the product of the solution and an entry."""
        return 0

    def released(self, pull: Floats, release: Floats) -> Floats:
        """Step of a thruster let go by itself."""
        return np.asarray(pull * release)


def bounded_thrusts(
    allocation: Allocation,
    wrench: Floats,
    low: Floats,
    high: Floats,
    *,
    largest_n: float,
    arithmetic: Arithmetic | None = None,
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
    do = Arithmetic() if arithmetic is None else arithmetic
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


def largest_demand(allocation: Allocation, largest_n: float) -> FloatArray:
    """Most that a demand counts as on each axis (6,), 0 on one out of reach. [N], [N m]."""
    scale = allocation.scale
    return np.divide(LARGEST_DEMAND * largest_n, scale, out=np.zeros(6), where=scale > 0)


def _dot(do: Arithmetic, large: Floats, small: Floats, bits: int) -> Floats:
    """Sum of products in order, as C does it: columns (m, k) with a row (k,)."""
    total = do.times(large[:, 0], small[0], bits)
    for k in range(1, small.size):
        total = total + do.times(large[:, k], small[k], bits)
    return total


def _left(do: Arithmetic, a: Floats, target: Floats, thrust: Floats) -> Floats:
    """Take what the thrusts give off the demand, (m, 6)."""
    left = target.copy()
    for i in range(a.shape[1]):
        left = left - do.times(thrust[:, i : i + 1], a[:, i], 30)
    return left


def _step(do: Arithmetic, a: Floats, left: Floats, held: BoolArray) -> Floats:
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


def _solve(do: Arithmetic, gram: list[list[Floats]], left: Floats) -> Floats:
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
