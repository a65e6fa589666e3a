"""Table 4: the inverse characteristic N(T, V) as one cubic a speed."""

import numpy as np

from pipeline.identify.polynomial import as_intervals
from pipeline.identify.thrust_curve import ThrustCurve
from pipeline.physics.propeller import polynomial
from pipeline.records.fits import SpeedInverse, StaticRow
from pipeline.types import FloatArray

THRUST_POINTS = 200
#: Rounds of Lawson's reweighting, which turns least squares towards the smallest maximum.
LAWSON_ROUNDS = 60
NORMAL_95 = 1.959964


def fit_table4_row(row: StaticRow, curve: ThrustCurve, thrust_dead_n: float) -> SpeedInverse:
    """Fit N = K_N0 + K_N1 T + K_N2 T^2 + K_N3 T^3 over thrust_dead_n < T <= T_max(V).

    The error is weighed in newtons (code error times dT/dN) and its maximum made small by Lawson's
    iteration, because the firmware's worst error is what an allocator feels.

    Parameters
    ----------
    row : StaticRow
        Supplies the modes of the thrust's covariance along the codes of `curve`.
    curve : ThrustCurve
        T(N) of the family at this speed.
    thrust_dead_n : float
        Lower end of the fit. [N]

    References
    ----------
    Kostenko 2023, eq. (8), Table 4. Lawson 1961, Contributions to the theory of linear least
    maximum approximation, PhD thesis, UCLA.
    """
    thrust_n = np.linspace(thrust_dead_n, curve.thrust_max_n, THRUST_POINTS)
    code = curve.code_at(thrust_n)
    slope = curve.slope(code)
    design = np.vander(thrust_n, 4, increasing=True)
    weight = np.ones(THRUST_POINTS)
    coefficients: FloatArray = np.zeros(4, dtype=float)
    for _ in range(LAWSON_ROUNDS):
        root = np.sqrt(weight) * slope
        coefficients = np.asarray(
            np.linalg.lstsq(design * root[:, None], code * root, rcond=None)[0], float
        )
        error = np.abs(code - design @ coefficients) * slope
        weight *= np.maximum(error, 1e-3 * error.max()) / error.max()
        weight /= weight.sum()
    covariance = _covariance(row, design, slope, code)
    half = NORMAL_95 * np.sqrt(np.diag(covariance))
    return SpeedInverse(
        speed_mps=row.speed_mps,
        thrust_max_n=curve.thrust_max_n,
        coefficients=tuple(coefficients.tolist()),
        ci95=as_intervals(np.stack([coefficients - half, coefficients + half], axis=1)),
    )


def cubic_code(inverse: SpeedInverse, thrust_n: FloatArray) -> FloatArray:
    """Code by Table 4's cubic at positive thrusts [N], clamped to T_max."""
    return polynomial(np.minimum(thrust_n, inverse.thrust_max_n), np.array(inverse.coefficients))


def _covariance(
    row: StaticRow, design: FloatArray, slope: FloatArray, code: FloatArray
) -> FloatArray:
    """Covariance of the coefficients from that of the family: dN = -dT / (dT/dN) at fixed T."""
    modes = np.array(row.thrust_modes_n)
    at_points = np.stack([np.interp(code, np.array(row.mode_code), mode) for mode in modes])
    root = slope[:, None]
    solver = np.linalg.pinv(design * root) * slope
    shift = solver @ (-at_points / slope).T
    return np.asarray(shift @ shift.T)
