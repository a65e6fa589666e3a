"""The inverse characteristics as cubics: Table 3 from the mooring test, Table 4 at speed."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.polynomial import fit_polynomial
from pipeline.identify.thrust_curve import ThrustCurve, curve_from_family, curve_from_measurements
from pipeline.physics.propeller import polynomial
from pipeline.records.fit_values import interval_factor
from pipeline.records.fits import PolynomialFit, SpeedInverse, StaticRow
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import VOLTAGE_TOLERANCE, is_at_supply
from pipeline.vehicle.schema import Vehicle

#: Kostenko 2023, eq. (7).
DEGREE = 3


def points_for_tables(mooring: MooringRecord, vehicle: Vehicle) -> tuple[MooringPoint, ...]:
    """Usable points at the supply voltage that the tables are for.

    Raises
    ------
    CannotComputeError
        If there are none, or several voltages and no choice in the vehicle file.
    """
    used = tuple(point for point in mooring.points if not point.marks)
    if not used:
        raise CannotComputeError(
            "no usable mooring points, so Table 3 cannot be fitted; put a table of thrust against "
            "code or PWM into mooring/"
        )
    wanted = vehicle.tables.supply_voltage_v
    voltages = np.array([p.voltage_v for p in used if p.voltage_v is not None], float)
    if wanted is None:
        spread = float(np.ptp(voltages)) if voltages.size else 0.0
        if voltages.size and spread > 2 * VOLTAGE_TOLERANCE * float(np.median(voltages)):
            raise CannotComputeError(
                f"the mooring data were taken at supply voltages from {voltages.min():g} to "
                f"{voltages.max():g} V; say in vehicle.yaml which one the tables are for "
                "(tables.supply_voltage_v)"
            )
        return used
    near = tuple(p for p in used if is_at_supply(p.voltage_v, wanted))
    if not near:
        known = ", ".join(f"{v:g}" for v in np.unique(np.round(voltages, 1)))
        raise CannotComputeError(
            f"tables.supply_voltage_v is {wanted:g} V, but the mooring data were taken at {known} V"
        )
    return near


def fit_table3(points: tuple[MooringPoint, ...], sign: int, thrust_dead_n: float) -> PolynomialFit:
    """Fit N = K_0 + K_1 T + K_2 T^2 + K_3 T^3 to one sign of thrust, T and N signed.

    Of one supply voltage; readings up to `thrust_dead_n`, for which the code is zero, are not
    fitted.

    Raises
    ------
    CannotComputeError
        If the points do not carry the cubic, or are of fewer codes than it has coefficients.

    References
    ----------
    Kostenko 2023, eq. (7), Table 3. For negative thrust the variable is the signed T.
    """
    used = [p for p in points if sign * p.thrust_n > thrust_dead_n and sign * p.code > 0]
    codes = len({p.code for p in used})
    if 0 < codes <= DEGREE:
        # many readings at few codes: their noise would make a cubic that is level at each code
        raise CannotComputeError(
            f"only {codes} of the {DEGREE + 1} codes that a cubic needs have readings beyond the "
            "dead thrust"
        )
    return fit_polynomial(
        np.array([p.thrust_n for p in used], float),
        np.array([p.code for p in used], float),
        degree=DEGREE,
        quantity="N",
        variable="T",
        unit="code",
        degree_reason="Cubic as in Kostenko 2023, eq. (7).",
        sources=[p.source for p in used],
        compared_degrees=(1, 2, 3, 4, 5),
    )


def mooring_curve(points: tuple[MooringPoint, ...], sign: int) -> ThrustCurve:
    """Monotone T(N) of one sign at rest, as magnitudes.

    Raises
    ------
    CannotComputeError
        With too few codes of this sign, which the message names.
    """
    used = [p for p in points if sign * p.code >= 0]
    try:
        return curve_from_measurements(
            np.array([abs(p.code) for p in used], float),
            np.array([sign * p.thrust_n if p.code else 0.0 for p in used], float),
        )
    except CannotComputeError as error:
        codes = "positive codes" if sign > 0 else "negative codes"
        raise CannotComputeError(f"{codes}: {error}") from error


def mean_by_code(points: tuple[MooringPoint, ...], sign: int) -> tuple[FloatArray, FloatArray]:
    """Return rising sizes of the codes of one sign and the mean thrust of each, by size [N]."""
    used = [p for p in points if sign * p.code > 0]
    code, index = np.unique(np.array([abs(p.code) for p in used], float), return_inverse=True)
    thrust = np.array([sign * p.thrust_n for p in used], float)
    return code, np.bincount(index, weights=thrust) / np.maximum(np.bincount(index), 1)


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
        coefficients=coefficients.tolist(),
        ci95=np.stack([coefficients - half, coefficients + half], axis=1).tolist(),
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
