"""Table 4: the inverse characteristic N(T, V) as one cubic a speed."""

import numpy as np

from pipeline.identify.polynomial import as_intervals
from pipeline.identify.thrust_curve import ThrustCurve, curve_from_family
from pipeline.physics.propeller import polynomial
from pipeline.records.fits import SpeedInverse, StaticRow
from pipeline.records.intervals import interval_factor
from pipeline.types import FloatArray

THRUST_POINTS = 200
#: Rounds of Lawson's reweighting, which turns least squares towards the smallest maximum.
LAWSON_ROUNDS = 60


def fit_table4_row(row: StaticRow, curve: ThrustCurve, thrust_dead_n: float) -> SpeedInverse:
    """Fit N = K_N0 + K_N1 T + K_N2 T^2 + K_N3 T^3 over thrust_dead_n < T <= T_max(V).

    The error is weighed in newtons (code error times dT/dN) and its maximum made small by Lawson's
    iteration, because the firmware's worst error is what an allocator feels.

    The intervals are found by fitting again to the family moved along each mode of its covariance,
    which `row` has: the weights of a smallest maximum move with the curve, so no fixed map carries
    the covariance.

    References
    ----------
    Kostenko 2023, eq. (8), Table 4. Lawson 1961, Contributions to the theory of linear least
    maximum approximation, PhD thesis, UCLA.
    """
    coefficients = smallest_maximum(curve, thrust_dead_n)
    shifts = np.array(
        [
            smallest_maximum(_moved(curve, mode_n / 2), thrust_dead_n)
            - smallest_maximum(_moved(curve, -mode_n / 2), thrust_dead_n)
            for mode_n in _modes_along(row, curve)
        ]
    )
    half = interval_factor(row.fit) * np.sqrt(np.sum(shifts**2, axis=0))
    return SpeedInverse(
        speed_mps=row.speed_mps,
        thrust_max_n=curve.thrust_max_n,
        coefficients=tuple(coefficients.tolist()),
        ci95=as_intervals(np.stack([coefficients - half, coefficients + half], axis=1)),
    )


def smallest_maximum(curve: ThrustCurve, thrust_dead_n: float) -> FloatArray:
    """Fit the cubic N(T) whose largest error in newtons is smallest, K_N0 ... K_N3 (4,).

    From `thrust_dead_n` to the curve's largest thrust.
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
    return coefficients


def cubic_code(inverse: SpeedInverse, thrust_n: FloatArray) -> FloatArray:
    """Code by Table 4's cubic at positive thrusts [N], clamped to T_max."""
    return polynomial(np.minimum(thrust_n, inverse.thrust_max_n), np.array(inverse.coefficients))


def _modes_along(row: StaticRow, curve: ThrustCurve) -> FloatArray:
    """Modes of the thrust's covariance [N] at the codes of the curve beyond its edge.

    Shape (modes, codes). Beyond the tested codes they go on along a line, as the family does.
    """
    from scipy.interpolate import make_interp_spline

    modes = make_interp_spline(np.array(row.mode_code), np.array(row.thrust_modes_n), k=1, axis=1)
    return np.asarray(modes(curve.code[1:]))


def _moved(curve: ThrustCurve, shift_n: FloatArray) -> ThrustCurve:
    """Curve with its thrust moved by some newtons at each code; its edge moves along."""
    moved = curve_from_family(curve.code[1:], curve.thrust_n[1:] + shift_n)
    return curve if moved is None else moved
