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
same operations in the same order (`pipeline.export.allocator_model`).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

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

Floats = npt.NDArray[Any]


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
        return self.matrix.shape[1]

    def weighted_error(self, thrust_n: FloatArray, wrench: FloatArray) -> FloatArray:
        """Root of the sum of squared errors (m,) as scaled, of thrusts (m, n)."""
        left = wrench * self.scale - thrust_n @ self.scaled.T
        return np.asarray(np.sqrt(np.sum(left**2, axis=-1)))


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
        inverse=np.linalg.pinv(scaled, rcond=_RANK) * scale,
        release=1.0 / np.maximum(np.sum(scaled**2, axis=0), 2.0**-20),
    )


def bounded_thrusts(
    allocation: Allocation,
    wrench: Floats,
    low_n: Floats,
    high_n: Floats,
    *,
    largest_n: float,
    dtype: type[np.floating[Any]] = np.float64,
) -> tuple[Floats, BoolArray]:
    """Thrusts (m, n) for wrenches (m, 6) within limits (m, n), and where a limit cut (m,).

    Parameters
    ----------
    allocation : Allocation
        Of the arrangement.
    wrench : ndarray, shape (m, 6)
        SNAME. [N], [N m]
    low_n, high_n : ndarray, shape (m, n)
        Limits, low <= 0 <= high. [N]
    largest_n : float
        Largest limit of all: the unit of what is large and small. [N]
    dtype : type
        Arithmetic; single precision does what the C code does.
    """
    a, inverse = allocation.scaled.astype(dtype), allocation.inverse.astype(dtype)
    scale, release = allocation.scale.astype(dtype), allocation.release.astype(dtype)
    smallest = dtype(SMALLEST_STEP * largest_n)
    low, high = low_n.astype(dtype), high_n.astype(dtype)
    tau = limited_demand(allocation, wrench, largest_n, dtype)
    target = tau * scale
    thrust = np.stack([_dot(inverse[i], tau) for i in range(allocation.count)], axis=1)
    held = (thrust < low) | (thrust > high)
    cut: BoolArray = held.any(axis=1)
    work = np.flatnonzero(cut)
    thrust = np.where(cut[:, None], np.clip(thrust, low, high), thrust)
    for _ in range(MOST_STEPS):
        if not work.size:
            break
        t, lo, hi, fixed = thrust[work], low[work], high[work], held[work]
        step = _step(a, _left(a, target[work], t), fixed)
        room = np.where(step > 0, hi - t, lo - t)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            shares = np.where(~fixed & (np.abs(step) > np.abs(room)), room / step, dtype(1))
        rows, first = np.arange(work.size), np.argmin(shares, axis=1)
        share = shares[rows, first]
        stopped = (~fixed & (np.abs(step) > np.abs(room)))[rows, first] & (share < 1)
        moved = np.clip(t + share[:, None] * step, lo, hi)
        moved[rows[stopped], first[stopped]] = np.where(
            step[rows, first] > 0, hi[rows, first], lo[rows, first]
        )[stopped]
        fixed[rows[stopped], first[stopped]] = True
        left = _left(a, target[work], moved)
        pull = np.stack([_dot(a[:, i], left) for i in range(allocation.count)], axis=1) * release
        inward = np.where(moved >= hi, -pull, pull)
        inside = np.where(moved >= hi, moved - lo, hi - moved) > smallest
        inward = np.where(fixed & inside, inward, dtype(0))
        best = np.argmax(inward, axis=1)
        freed = ~stopped & (inward[rows, best] > smallest)
        fixed[rows[freed], best[freed]] = False
        thrust[work], held[work] = moved, fixed
        still = np.abs(step).max(axis=1) <= smallest
        work = work[stopped | freed | ~still]
    return thrust, cut


def limited_demand(
    allocation: Allocation, wrench: Floats, largest_n: float, dtype: type[np.floating[Any]]
) -> Floats:
    """Demands held to what an axis could use; nothing of an axis out of reach."""
    with np.errstate(divide="ignore"):
        most = np.where(
            allocation.scale > 0, LARGEST_DEMAND * largest_n / allocation.scale, 0.0
        ).astype(dtype)
    return np.clip(wrench.astype(dtype), -most, most)


def _dot(row: Floats, columns: Floats) -> Floats:
    """Sum of products in order, as C does it: row (k,) with columns (m, k)."""
    total = row[0] * columns[:, 0]
    for k in range(1, row.size):
        total = total + row[k] * columns[:, k]
    return np.asarray(total)


def _left(a: Floats, target: Floats, thrust: Floats) -> Floats:
    """What is left of the demand, (m, 6)."""
    left = target.copy()
    for i in range(a.shape[1]):
        left = left - a[:, i] * thrust[:, i : i + 1]
    return left


def _step(a: Floats, left: Floats, held: BoolArray) -> Floats:
    """Solve for the step (m, n) of the free thrusters by L D L^T of six equations."""
    one = a.dtype.type
    m, n = held.shape
    gram = [[np.full(m, one(EPSILON if i == j else 0)) for j in range(i + 1)] for i in range(6)]
    for k in range(n):
        free = np.where(held[:, k], one(0), one(1))
        for i in range(6):
            for j in range(i + 1):
                gram[i][j] = gram[i][j] + free * (a[i, k] * a[j, k])
    lower = [[np.zeros(m, a.dtype)] * 6 for _ in range(6)]
    pivot: list[Floats] = []
    for j in range(6):
        column = {}
        for i in range(j, 6):
            value = gram[i][j]
            for k in range(j):
                value = value - (lower[i][k] * pivot[k]) * lower[j][k]
            column[i] = value
        pivot.append(np.maximum(column[j], one(EPSILON / 2)))
        for i in range(j + 1, 6):
            lower[i][j] = column[i] / pivot[j]
    y: list[Floats] = []
    for i in range(6):
        value = left[:, i]
        for k in range(i):
            value = value - lower[i][k] * y[k]
        y.append(value)
    solved = [y[i] / pivot[i] for i in range(6)]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            solved[i] = solved[i] - lower[k][i] * solved[k]
    found = np.stack(solved, axis=1)
    return np.stack([np.where(held[:, i], one(0), _dot(a[:, i], found)) for i in range(n)], axis=1)
