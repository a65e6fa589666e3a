"""Working points of drive and propeller on the grid of codes and speeds, with their errors."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.errors import CannotComputeError
from pipeline.identify.propagation import ThrusterFits, thrust_jacobian
from pipeline.identify.propeller import lowest_covered_ratio, measured_ratios
from pipeline.identify.static_checks import explain_no_balance
from pipeline.physics.torque_balance import WorkingPoints
from pipeline.records.fits import DriveFit, PointStatus, PropellerFit
from pipeline.types import BoolArray, FloatArray
from pipeline.units import rpm_to_rps

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


def solve_grid(
    model: ThrusterFits,
    propeller: PropellerFit,
    drive: DriveFit,
    *,
    speed_mps: FloatArray,
    code: FloatArray,
) -> WorkingGrid:
    """Solve the torque balance at tested codes and continue to the others.

    `speed_mps` (v,) go along the thrust and begin with 0, `code` (c,) are positive and rise by one.

    Raises
    ------
    CannotComputeError
        If the curves meet at no code at rest.
    """
    tested = (code >= drive.code_range[0]) & (code <= drive.code_range[1])
    speeds, codes = np.meshgrid(speed_mps, code[tested], indexing="ij")
    points = model.solve(codes.ravel(), speeds.ravel())
    if not (points.found & (speeds.ravel() == 0)).any():
        raise CannotComputeError(explain_no_balance(model, drive))
    jacobian = thrust_jacobian(model, points, codes.ravel()).reshape(*speeds.shape, -1)
    jacobian = _continue(jacobian, tested, code)
    std = np.sqrt(np.einsum("vcj,jk,vck->vc", jacobian, model.covariance(), jacobian))
    status = _status(points, codes.ravel(), propeller, drive).reshape(speeds.shape)

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


def _status(
    points: WorkingPoints, code: FloatArray, propeller: PropellerFit, drive: DriveFit
) -> npt.NDArray[np.str_]:
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
