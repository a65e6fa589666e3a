"""From the covariance of the fits to the standard error of thrust.

The thrust at a working point is T(theta) with theta = (K_T coefficients, K_M coefficients, drive
coefficients). The shaft speed follows from the torque balance f(n, theta) = 0, so by the implicit
function theorem dn/dtheta = -(df/dtheta) / (df/dn). The three fits are independent of each other.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.physics.drive import TorqueSurface, surface_basis
from pipeline.physics.torque_balance import (
    OpenWaterPropeller,
    WorkingPoints,
    thrust_slope,
    torque_excess_slope,
    working_points,
)
from pipeline.records.intervals import student_95
from pipeline.types import FloatArray

#: The search for the balance goes this far beyond the fastest shaft speed of the bench.
SEARCH_BEYOND = 1.5


@dataclass(frozen=True)
class ThrusterFits:
    """The fitted propeller and drive with the covariances of their coefficients.

    `degrees_of_freedom` are those of the drive's covariance, the part that is known worst; its t
    quantile belongs to the intervals of all that is propagated.
    """

    propeller: OpenWaterPropeller
    surface: TorqueSurface
    thrust_covariance: FloatArray
    torque_covariance: FloatArray
    drive_covariance: FloatArray
    degrees_of_freedom: int
    fastest_shaft_rps: float

    def solve(self, code: FloatArray, speed_mps: FloatArray | float) -> WorkingPoints:
        """Solve the torque balance; see `working_points`."""
        return working_points(
            code,
            speed_mps,
            propeller=self.propeller,
            surface=self.surface,
            fastest_shaft_rps=self.fastest_shaft_rps,
        )

    def interval_factor(self) -> float:
        """Half-width of a 95 % interval in standard errors."""
        return student_95(self.degrees_of_freedom)

    def covariance(self) -> FloatArray:
        """Block-diagonal covariance of theta, shape (p, p)."""
        from scipy.linalg import block_diag

        return np.asarray(
            block_diag(self.thrust_covariance, self.torque_covariance, self.drive_covariance)
        )


def thrust_jacobian(model: ThrusterFits, points: WorkingPoints, code: FloatArray) -> FloatArray:
    """Differentiate thrust to theta at solved points (m,), shape (m, p); zero where not found."""
    propeller, surface = model.propeller, model.surface
    n = np.where(points.found, points.shaft_speed_rps, 1.0)
    powers_t = points.advance_ratio[:, None] ** np.arange(len(propeller.thrust_coefficients))
    powers_m = points.advance_ratio[:, None] ** np.arange(len(propeller.torque_coefficients))
    force = propeller.density_kgpm3 * n**2 * propeller.diameter_m**4
    basis = surface_basis(n, code, surface)
    excess_slope = torque_excess_slope(points, code, propeller=propeller, surface=surface)
    safe = np.where(points.found, excess_slope, 1.0)
    # dT/dn * dn/dtheta, with df/dtheta = (0, J^i rho n^2 D^5, -basis)
    through_speed = (thrust_slope(points, propeller) / safe)[:, None]
    jacobian = np.concatenate(
        [
            powers_t * force[:, None],
            -through_speed * powers_m * (force * propeller.diameter_m)[:, None],
            through_speed * basis,
        ],
        axis=1,
    )
    return np.where(points.found[:, None], jacobian, 0.0)
