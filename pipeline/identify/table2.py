"""Table 2: eq. (4) fitted to the static family at one speed."""

import numpy as np

from pipeline.identify.polynomial import as_intervals
from pipeline.identify.working_grid import ThrusterFits, thrust_jacobian
from pipeline.physics.thrust_grid import dead_zone_code
from pipeline.records.fits import DriveFit, FitQuality, Matrix, PolynomialFit, StaticRow
from pipeline.types import FloatArray

#: A row needs this many live codes.
FEWEST_LIVE_CODES = 8
#: Share of the largest variance below which a mode of the covariance is left out.
SMALLEST_MODE = 1e-6


def table2_row(
    speed_mps: float,
    model: ThrusterFits,
    drive: DriveFit,
    code: FloatArray,
    thrust_max: tuple[float, float],
) -> StaticRow | None:
    """Fit T = K_F0 + K_F1 N + K_F2 N^2 to the family at one speed, over the tested codes.

    `code` (c,) are the codes of the family, the last the largest that the firmware sends;
    `thrust_max` is the thrust there, which may not have been on the bench, and its standard error
    [N]. None where too few codes give thrust.

    References
    ----------
    Kostenko 2023, eq. (4), Table 2.
    """
    tested = code[(code >= drive.code_range[0]) & (code <= drive.code_range[1])]
    points = model.solve(tested, np.full(tested.shape, speed_mps))
    live = points.found
    factor = model.interval_factor()
    thrust_max_n, half = thrust_max[0], factor * thrust_max[1]
    width = 3
    if live.sum() < FEWEST_LIVE_CODES:
        return None
    thrust_n, used = points.thrust_n[live], tested[live]
    design = np.vander(used, width, increasing=True)
    solver = np.linalg.pinv(design)
    coefficients = solver @ thrust_n
    jacobian = thrust_jacobian(model, points, tested)[live]
    of_thrust = jacobian @ model.covariance() @ jacobian.T
    covariance = solver @ of_thrust @ solver.T
    spread = factor * np.sqrt(np.diag(covariance))
    residual = thrust_n - design @ coefficients
    total = np.sum((thrust_n - thrust_n.mean()) ** 2)
    fit = PolynomialFit(
        quantity="T",
        variable="N",
        coefficients=tuple(coefficients.tolist()),
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        ci95=as_intervals(np.stack([coefficients - spread, coefficients + spread], axis=1)),
        quality=FitQuality(
            points=int(live.sum()),
            r_squared=float(1 - residual @ residual / total),
            residual_std=float(np.sqrt(residual @ residual / (live.sum() - width))),
            unit="N",
            valid_range=(float(used[0]), float(used[-1])),
            order_reason=(
                "Quadratic as in Kostenko 2023, eq. (4). The intervals carry the bench's noise; "
                f"the form itself misses the family by up to {np.abs(residual).max():.2f} N."
            ),
        ),
    )
    return StaticRow(
        speed_mps=float(speed_mps),
        fit=fit,
        dead_zone_code=min(dead_zone_code(coefficients), float(code[-1])),
        thrust_max_n=thrust_max_n,
        thrust_max_ci95=(thrust_max_n - half, thrust_max_n + half),
        mode_code=tuple(used.tolist()),
        thrust_modes_n=_modes(of_thrust),
    )


def _modes(covariance: FloatArray) -> Matrix:
    """Eigenvectors of Cov(T) along the live codes, scaled; the negligible ones are left out."""
    values, vectors = np.linalg.eigh(covariance)
    keep = values > SMALLEST_MODE * values.max()
    return tuple(tuple(mode) for mode in (vectors[:, keep] * np.sqrt(values[keep])).T.tolist())
