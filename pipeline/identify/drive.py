"""The drive's mechanical characteristic M(n, N): one smooth surface over speed and code."""

from dataclasses import replace
from itertools import product

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.drive_bench import (
    DriveBench,
    bench_of,
    code_0_check,
    physical_checks,
    sweeps_check,
)
from pipeline.identify.linear_fit import Judgement, LinearFit, fit_linear, judge
from pipeline.identify.polynomial import name_outliers
from pipeline.physics.drive import TorqueSurface, drive_torque_slope, surface_basis
from pipeline.records.fits import CodeSpread, DriveFit, FitQuality, OrderScore
from pipeline.records.measurements import LoadTestRecord
from pipeline.types import FloatArray, IntArray
from pipeline.units import rps_to_rpm
from pipeline.vehicle.schema import Vehicle

#: Largest powers of speed and code that are tried.
LARGEST_POWERS = (4, 4)
#: Largest power of the code in the centre line of the measured speeds.
CENTRE_POWER = 3
#: A sheet with fewer points cannot tell an outlier from a bend.
FEWEST_TO_JUDGE = 8
#: An order with fewer terms is taken when its error between codes is within this of the best.
SIMPLER_IS_BETTER = 1.05


def fit_drive(load_test: LoadTestRecord, vehicle: Vehicle) -> DriveFit:
    """Fit the family of mechanical characteristics.

    The powers are chosen by the error at codes left out one at a time (the surface is there to
    interpolate between codes), then by simplicity. The covariance is clustered by sweep (file,
    code, branch), because the errors of a sweep go together; with two or more drives on the bench
    the scatter of their torque scale is added, because every point of a drive shares it.

    Points with marks are not fitted; the vehicle gives the range of codes.

    Raises
    ------
    CannotComputeError
        If there are no points, no codes, or fewer than three codes.
    """
    bench = bench_of(load_test)
    codes = np.unique(bench.code)
    if codes.size < 3:
        raise CannotComputeError(
            f"the load test holds {codes.size} control code{'s' if codes.size > 1 else ''} "
            f"({', '.join(f'{code:g}' for code in codes)}); a family M(n, N) that interpolates "
            "between codes needs at least 3, six or more are better"
        )
    if not (bench.torque_nm > 0).any():
        raise CannotComputeError(
            "the load test shows no torque at any point: the largest is "
            f"{bench.torque_nm.max():.3g} N m. Was the load on the shaft, and the torque sensor "
            "connected?"
        )
    judged = _judged_within_sheets(bench)
    frame = _frame(bench, float(vehicle.drive.code_max))
    chosen, scores = _score_powers(bench, frame, judged)
    frame = replace(frame, exponents=_exponents(*chosen))
    basis = surface_basis(bench.shaft_speed_rps, bench.code, frame)
    fit = fit_linear(basis, bench.torque_nm, clusters=bench.sweep, judged=judged)
    surface = replace(frame, coefficients=fit.coefficients)
    scale_by_file = _torque_scale_by_file(bench, fit)
    scale_std = float(np.std(list(scale_by_file.values()), ddof=1)) if len(scale_by_file) > 1 else 0
    # every point of a drive shares its torque scale: a rank-one term along the coefficients
    covariance = fit.covariance + np.outer(fit.coefficients, fit.coefficients) * (
        scale_std**2 / max(len(scale_by_file), 1)
    )
    sweeps = int(np.unique(bench.sweep[~fit.outlier]).size)
    return DriveFit(
        exponents=tuple((int(i), int(j)) for i, j in surface.exponents),
        coefficients=fit.coefficients.tolist(),
        covariance=covariance.tolist(),
        centre_rps=surface.centre_rps.tolist(),
        shaft_speed_scale_rps=surface.shaft_speed_scale_rps,
        code_scale=surface.code_scale,
        band_code=surface.band_code.tolist(),
        slowest_rps=surface.slowest_rps.tolist(),
        fastest_rps=surface.fastest_rps.tolist(),
        code_range=(float(codes[0]), float(codes[-1])),
        clusters=sweeps,
        clustered=fit.clustered,
        torque_scale_by_file=scale_by_file,
        torque_scale_std=scale_std,
        quality=FitQuality(
            points=int((~fit.outlier).sum()),
            outliers=name_outliers(
                fit, [point.source for point in bench.points], bench.code, "code"
            ),
            r_squared=fit.r_squared,
            residual_std=fit.residual_std,
            unit="N m",
            valid_range=(float(codes[0]), float(codes[-1])),
            orders=scores,
            order_reason=(
                f"Powers up to x^{chosen[0]} and N^{chosen[1]}: the smallest error at codes left "
                "out one at a time, or within 5 % of it with fewer terms."
            ),
        ),
        codes=_spread_by_code(bench, fit),
        checks=(
            *physical_checks(bench, surface),
            sweeps_check(sweeps, fit),
            *code_0_check(load_test),
        ),
    )


def _exponents(speed_power: int, code_power: int) -> IntArray:
    pairs = product(range(speed_power + 1), range(code_power + 1))
    return np.array(list(pairs), dtype=np.int64)


def _frame(bench: DriveBench, code_scale: float) -> TorqueSurface:
    """Centre line and band of the measured speeds; a surface without terms yet.

    Below the lowest code the band shrinks towards standstill at code 0.
    """
    codes = np.unique(bench.code)
    ends = np.array(
        [(own.min(), own.max()) for own in (bench.shaft_speed_rps[bench.code == c] for c in codes)]
    )
    power = min(CENTRE_POWER, codes.size - 2)
    centre = np.polynomial.polynomial.polyfit(codes / code_scale, ends.mean(axis=1), power)
    return TorqueSurface(
        exponents=np.zeros((0, 2), dtype=np.int64),
        coefficients=np.zeros(0),
        centre_rps=centre,
        shaft_speed_scale_rps=float(np.ptp(ends, axis=1).max()) / 2,
        code_scale=code_scale,
        band_code=np.concatenate([[0.0], codes]),
        slowest_rps=np.concatenate([[0.0], ends[:, 0]]),
        fastest_rps=np.concatenate([[0.0], ends[:, 1]]),
    )


def _judged_within_sheets(bench: DriveBench) -> Judgement:
    """Judge each point by a robust cubic through its own sheet's points.

    A point is judged by its neighbours on the bench, not by the surface: where the surface is too
    stiff it would call good points bad.
    """
    sigmas = np.zeros(bench.code.shape)
    outlier = np.zeros(bench.code.shape, bool)
    for label in np.unique(bench.sheet):
        own = bench.sheet == label
        if own.sum() >= FEWEST_TO_JUDGE:
            n = bench.shaft_speed_rps[own]
            design = np.vander((n - n.mean()) / max(float(np.ptp(n)), 1e-9), 4, increasing=True)
            found = judge(design, bench.torque_nm[own])
            sigmas[own], outlier[own] = found.sigmas, found.outlier
    return Judgement(sigmas, outlier)


def _score_powers(
    bench: DriveBench, frame: TorqueSurface, judged: Judgement
) -> tuple[tuple[int, int], tuple[OrderScore, ...]]:
    """Choose the powers: the simplest of those with about the least error at codes left out.

    Surfaces whose torque rises with speed somewhere are no drives; they stand back where others do
    not.
    """
    codes = np.unique(bench.code)
    tried: dict[tuple[int, int], OrderScore] = {}
    rises = set()
    for powers in product(range(1, LARGEST_POWERS[0] + 1), range(1, LARGEST_POWERS[1] + 1)):
        if powers[1] > codes.size - 2:
            continue
        shape = replace(frame, exponents=_exponents(*powers))
        basis = surface_basis(bench.shaft_speed_rps, bench.code, shape)
        try:
            fit = fit_linear(basis, bench.torque_nm, judged=judged)
        except CannotComputeError:
            continue
        surface = replace(shape, coefficients=fit.coefficients)
        slope = drive_torque_slope(bench.shaft_speed_rps, bench.code, surface)
        name = f"x^{powers[0]} N^{powers[1]}"
        if not np.all(slope < 0):
            rises.add(powers)
            name += " (rises with speed somewhere)"
        tried[powers] = OrderScore(
            order=name,
            parameters=len(shape.exponents),
            aicc=fit.aicc,
            leave_one_out_rmse=_error_at_left_out_codes(bench, basis, fit),
            chosen=False,
        )
    if not tried:
        raise CannotComputeError(
            f"{bench.code.size} points at {codes.size} codes do not determine even a plane M(n, N)"
        )
    drives = {p: one for p, one in tried.items() if p not in rises} or tried
    most = SIMPLER_IS_BETTER * min(one.leave_one_out_rmse for one in drives.values())
    chosen = min(
        (p for p, one in drives.items() if one.leave_one_out_rmse <= most),
        key=lambda p: (drives[p].parameters, drives[p].leave_one_out_rmse),
    )
    tried[chosen] = tried[chosen].model_copy(update={"chosen": True})
    return chosen, tuple(tried.values())


def _error_at_left_out_codes(bench: DriveBench, basis: FloatArray, fit: LinearFit) -> float:
    """RMS error at each inner code predicted from the others; the end codes would extrapolate."""
    keep = ~fit.outlier
    squares: list[FloatArray] = []
    for code in np.unique(bench.code)[1:-1]:
        others, own = keep & (bench.code != code), keep & (bench.code == code)
        coefficients = np.linalg.lstsq(basis[others], bench.torque_nm[others], rcond=None)[0]
        squares.append((bench.torque_nm[own] - basis[own] @ coefficients) ** 2)
    return float(np.sqrt(np.mean(np.concatenate(squares)))) if squares else np.inf


def _torque_scale_by_file(bench: DriveBench, fit: LinearFit) -> dict[str, float]:
    """Torque of each drive over that of the family, least squares through zero."""
    scales = {}
    for label in np.unique(bench.file):
        own = (bench.file == label) & ~fit.outlier
        if own.any():
            name = bench.points[int(np.flatnonzero(own)[0])].source.file
            family = fit.fitted[own]
            scales[name] = float(bench.torque_nm[own] @ family / (family @ family))
    return scales


def _spread_by_code(bench: DriveBench, fit: LinearFit) -> tuple[CodeSpread, ...]:
    spreads = []
    for code in np.unique(bench.code):
        own = (bench.code == code) & ~fit.outlier
        if not own.any():
            continue
        residual = fit.residuals[own]
        up, down = residual[bench.loading[own]], residual[~bench.loading[own]]
        speed = bench.shaft_speed_rps[own]
        torque = bench.torque_nm[own]
        spreads.append(
            CodeSpread(
                code=float(code),
                points=int(own.sum()),
                shaft_speed_rpm=(rps_to_rpm(float(speed.min())), rps_to_rpm(float(speed.max()))),
                torque_nm=(float(torque.min()), float(torque.max())),
                residual_std_nm=float(np.sqrt(np.mean(residual**2))),
                loading_minus_unloading_nm=(
                    float(up.mean() - down.mean()) if up.size and down.size else None
                ),
            )
        )
    return tuple(spreads)
