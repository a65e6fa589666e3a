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
same operations in the same order (`pipeline.export.fixed_point`).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from pipeline.types import FloatArray

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
    """Floating point; the firmware's fixed point is `pipeline.export.fixed_point`.

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

    @property
    def solution_bits(self) -> int:
        """Format of the product of the solution and an entry."""
        return 0


def largest_demand(allocation: Allocation, largest_n: float) -> FloatArray:
    """Most that a demand counts as on each axis (6,), 0 on one out of reach. [N], [N m]."""
    scale = allocation.scale
    return np.divide(LARGEST_DEMAND * largest_n, scale, out=np.zeros(6), where=scale > 0)


class CodeFromThrust(Protocol):
    """Inverse characteristic of the thrusters of a vehicle."""

    def __call__(self, thrust_n: FloatArray, inflow_mps: FloatArray) -> FloatArray:
        """Codes (n,) for thrusts (n,) [N] at the inflow speeds (n,) [m/s]."""
        ...


@dataclass(frozen=True)
class GeneralAllocator:
    """Thrusts by the Moore-Penrose inverse of the configuration matrix B (6, n).

    `position_m`, `direction` (n, 3); `largest_n`, `smallest_n` (n,) thrust limits at rest;
    `code_from_thrust` the inverse characteristic. A demand beyond the limits is scaled as a whole,
    so that its direction is kept (Fossen 2021, section 11.2).
    """

    position_m: FloatArray
    direction: FloatArray
    largest_n: FloatArray
    smallest_n: FloatArray
    code_from_thrust: CodeFromThrust

    def configuration(self) -> FloatArray:
        """B (6, n): the wrench of one newton of each thruster."""
        return configuration(self.position_m, self.direction)

    @cached_property
    def thrust_of_wrench(self) -> FloatArray:
        """Thrusts (n, 6) of a wrench of one, the least that give it."""
        return np.asarray(np.linalg.pinv(self.configuration(), rcond=1e-6))

    def decide(
        self,
        demand: FloatArray,
        nu_relative: FloatArray,
        limits: tuple[FloatArray, FloatArray] | None = None,
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Codes (n,) for a wrench (6,) at a relative velocity (6,), and whether a limit cut it.

        Beside the codes the thrusts (n,) [N] that they are meant to give. `limits` take the place
        of `smallest_n` and `largest_n`.
        """
        smallest, largest = limits or (self.smallest_n, self.largest_n)
        thrust = self.thrust_of_wrench @ demand
        share = np.max(np.maximum(thrust / largest, thrust / smallest), initial=1.0)
        inflow = np.einsum(
            "ij,ij->i",
            self.direction,
            nu_relative[:3] + np.cross(nu_relative[3:], self.position_m),
        )
        wanted = thrust / share
        return self.code_from_thrust(wanted, inflow), wanted, bool(share > 1.0)
