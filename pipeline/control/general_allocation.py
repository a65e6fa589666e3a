"""Allocation for any arrangement of thrusters: weighted pseudo-inverse, scaled to the limits."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from pipeline.control.bounded_allocation import configuration
from pipeline.types import FloatArray


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

    def codes(self, demand: FloatArray, nu_relative: FloatArray) -> tuple[FloatArray, bool]:
        """Codes (n,) for a wrench (6,) at a relative velocity (6,), and whether it saturates."""
        codes, _, cut = self.decide(demand, nu_relative)
        return codes, cut

    def decide(
        self,
        demand: FloatArray,
        nu_relative: FloatArray,
        limits: tuple[FloatArray, FloatArray] | None = None,
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Codes (n,), the thrusts (n,) [N] they are meant to give, and whether a limit cut.

        `limits` take the place of `smallest_n` and `largest_n`.
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
