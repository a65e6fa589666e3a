"""Working points of drive and propeller on the grid of codes and speeds, with their errors.

The thrust at a working point is T(theta) with theta = (K_T coefficients, K_M coefficients, drive
coefficients). The shaft speed follows from the torque balance f(n, theta) = 0, so by the implicit
function theorem dn/dtheta = -(df/dtheta) / (df/dn). The three fits are independent of each other.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.errors import CannotComputeError
from pipeline.identify.propeller import lowest_covered_ratio, measured_ratios
from pipeline.physics.drive import TorqueSurface, drive_torque, surface_basis
from pipeline.physics.torque_balance import (
    OpenWaterPropeller,
    WorkingPoints,
    thrust_slope,
    torque_excess_slope,
    working_points,
)
from pipeline.records.fit_values import drive_factor
from pipeline.records.fits import DriveFit, PointStatus, PropellerFit
from pipeline.types import BoolArray, FloatArray
from pipeline.units import rpm_to_rps, rps_to_rpm

#: The search for the balance goes this far beyond the fastest shaft speed of the bench.
SEARCH_BEYOND = 1.5


@dataclass(frozen=True)
class ThrusterFits:
    """The fitted propeller and drive, and both as the torque balance takes them."""

    propeller_fit: PropellerFit
    drive: DriveFit
    propeller: OpenWaterPropeller
    surface: TorqueSurface

    @property
    def fastest_shaft_rps(self) -> float:
        """Shaft speed up to which the balance is sought [rev/s]."""
        fastest = max(spread.shaft_speed_rpm[1] for spread in self.drive.codes)
        return SEARCH_BEYOND * rpm_to_rps(fastest)

    def tested(self, code: FloatArray) -> BoolArray:
        """Tell which codes lie within those of the bench."""
        return (code >= self.drive.code_range[0]) & (code <= self.drive.code_range[1])

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
        """Half-width of a 95 % interval in standard errors: that of the drive, known worst."""
        return drive_factor(self.drive)

    def covariance(self) -> FloatArray:
        """Block-diagonal covariance of theta, shape (p, p)."""
        from scipy.linalg import block_diag

        fits = (self.propeller_fit.thrust, self.propeller_fit.torque, self.drive)
        return np.asarray(block_diag(*(np.array(fit.covariance) for fit in fits)))


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


#: A working point this far (share of the span) outside the measured speeds is an extrapolation.
SPEED_MARGIN = 0.02


@dataclass(frozen=True)
class WorkingGrid:
    """The family on a grid; all arrays have shape (speeds, codes).

    Codes outside the tested ones continue the line through the two nearest: the drive's surface
    knows nothing there, and where it is not a drive the balance has solutions that no motor has.
    The standard error is that of the line: its slope is not known exactly either.
    """

    thrust_n: FloatArray
    thrust_std_n: FloatArray
    shaft_speed_rps: FloatArray
    torque_nm: FloatArray
    advance_ratio: FloatArray
    status: npt.NDArray[np.str_]

    def thrust_max(self, row: int) -> tuple[float, float]:
        """Thrust at the largest code at the speed of a row, and its standard error [N]."""
        return float(self.thrust_n[row, -1]), float(self.thrust_std_n[row, -1])


def solve_grid(model: ThrusterFits, *, speed_mps: FloatArray, code: FloatArray) -> WorkingGrid:
    """Solve the torque balance at tested codes and continue to the others.

    `speed_mps` (v,) go along the thrust and begin with 0, `code` (c,) are positive and rise by one.

    Raises
    ------
    CannotComputeError
        If the curves meet at no code at rest.
    """
    tested = model.tested(code)
    speeds, codes = np.meshgrid(speed_mps, code[tested], indexing="ij")
    points = model.solve(codes.ravel(), speeds.ravel())
    if not (points.found & (speeds.ravel() == 0)).any():
        raise CannotComputeError(_why_no_balance(model))
    jacobian = thrust_jacobian(model, points, codes.ravel()).reshape(*speeds.shape, -1)
    jacobian = _continue(jacobian, tested, code)
    std = np.sqrt(np.einsum("vcj,jk,vck->vc", jacobian, model.covariance(), jacobian))
    status = _status(points, codes.ravel(), model).reshape(speeds.shape)

    def spread(values: FloatArray) -> FloatArray:
        return _above_zero(_continue(values.reshape(speeds.shape), tested, code), tested)

    thrust_n = spread(points.thrust_n)
    names = np.where(thrust_n > 0, "extrapolated", "dead").astype(status.dtype)
    names[:, tested] = status
    live = names != "dead"
    shaft = np.where(live, spread(points.shaft_speed_rps), 0.0)
    turning = shaft > 0
    diameter = model.propeller.diameter_m
    ratio = speed_mps[:, None] / (np.where(turning, shaft, 1.0) * diameter)
    return WorkingGrid(
        thrust_n=thrust_n,
        thrust_std_n=np.where(live, std, 0.0),
        shaft_speed_rps=shaft,
        torque_nm=np.where(live, spread(points.torque_nm), 0.0),
        advance_ratio=np.where(turning, ratio, 0.0),
        status=names,
    )


def _continue(values: FloatArray, tested: BoolArray, code: FloatArray) -> FloatArray:
    """Fill the columns outside the tested codes by the line through the two nearest.

    `values` has shape (speeds, tested codes, ...), the result (speeds, codes, ...).
    """
    full = np.zeros((values.shape[0], code.size, *values.shape[2:]))
    full[:, tested] = values  # to the last digit: what is dead is 0
    known = code[tested]
    for outside, end, inner in ((code < known[0], 0, 1), (code > known[-1], -1, -2)):
        if not outside.any():
            continue
        slope = (values[:, end] - values[:, inner]) / (known[end] - known[inner])
        reach = (code[outside] - known[end]).reshape(-1, *[1] * (values.ndim - 2))
        full[:, outside] = values[:, [end]] + slope[:, None] * reach
    return full


def _above_zero(values: FloatArray, tested: BoolArray) -> FloatArray:
    """Hold continued values to zero and above; `values` has shape (speeds, codes)."""
    first, last = np.flatnonzero(tested)[[0, -1]]
    held = np.where(tested, values, np.maximum(values, 0.0))
    # a dead end stays dead: its slope belongs to points beyond the dead zone
    held[values[:, first] <= 0, :first] = 0.0
    held[values[:, last] <= 0, last + 1 :] = 0.0
    return held


def _status(points: WorkingPoints, code: FloatArray, model: ThrusterFits) -> npt.NDArray[np.str_]:
    drive, propeller = model.drive, model.propeller_fit
    measured_codes = np.array([spread.code for spread in drive.codes])
    slow, fast = (
        np.interp(
            code,
            measured_codes,
            [rpm_to_rps(spread.shaft_speed_rpm[end]) for spread in drive.codes],
        )
        for end in (0, 1)
    )
    margin = SPEED_MARGIN * (fast - slow)
    shaft = points.shaft_speed_rps
    outside: BoolArray = (
        (code < measured_codes[0])
        | (code > measured_codes[-1])
        | (shaft < slow - margin)
        | (shaft > fast + margin)
        | (points.advance_ratio > measured_ratios(propeller)[1])
        | (points.advance_ratio < lowest_covered_ratio(propeller))
    )
    names: list[PointStatus] = ["dead", "no_working_point", "extrapolated"]
    return np.select([points.dead, ~points.found, outside], names, default="live")


def _why_no_balance(model: ThrusterFits) -> str:
    """Say with numbers why the propeller and the drive have no working point at rest."""
    code = np.array([model.drive.code_range[1]])
    fastest = model.fastest_shaft_rps
    needed = float(model.propeller.torque_nm(fastest, 0.0))
    given = float(drive_torque(fastest, code, model.surface)[0])
    return (
        f"the propeller's torque meets the drive's at no code at rest: at code {code[0]:g} and "
        f"{rps_to_rpm(fastest):.0f} rpm ({SEARCH_BEYOND:g} times the fastest of the bench) the "
        f"propeller needs {needed:.3g} N m and the drive gives {given:.3g} N m. Check the "
        "propeller's diameter in vehicle.yaml, the unit of torque in load_test/ and the K_M (not "
        "10 K_M) in open_water/"
    )
