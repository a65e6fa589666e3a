"""The static characteristic T(N, V): torque balance of the fitted propeller and drive; Table 2."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.drive import torque_surface
from pipeline.identify.polynomial import as_intervals
from pipeline.identify.propagation import ThrusterModel, monte_carlo_std, thrust_jacobian
from pipeline.identify.static_checks import explain_no_balance, explain_status, grid_checks
from pipeline.physics.torque_balance import OpenWaterPropeller, WorkingPoints
from pipeline.records.fits import (
    DriveFit,
    FitQuality,
    Matrix,
    PointStatus,
    PolynomialFit,
    PropellerFit,
    StaticCharacteristic,
    StaticRow,
)
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

#: Spacing of the grid of speeds. [m/s]
SPEED_STEP_MPS = 0.1
#: The search for the balance goes this far beyond the fastest shaft speed of the bench.
SEARCH_BEYOND = 1.5
#: A working point this far (share of the span) outside the measured speeds is an extrapolation.
SPEED_MARGIN = 0.02
#: A row of Table 2 needs this many live codes.
FEWEST_LIVE_CODES = 8
#: Share of the largest variance below which a mode of the covariance is left out.
SMALLEST_MODE = 1e-6
DRAWS = 400
SEED = 20230304
NORMAL_95 = 1.959964


def static_characteristic(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> StaticCharacteristic:
    """Compute the family T(N, V) on a grid, its standard error, and Table 2.

    Thrust and speed are taken along the same direction, as in the paper; codes are positive and
    negative ones mirror them.

    Parameters
    ----------
    propeller : PropellerFit
        K_T(J), K_M(J).
    drive : DriveFit
        M(n, N).
    vehicle : Vehicle
        Water, range of codes, speeds of the tables.

    Returns
    -------
    StaticCharacteristic

    Raises
    ------
    CannotComputeError
        If the propeller's torque meets the drive's at no code at rest.

    References
    ----------
    Kostenko 2023, eqs. (1)-(4), section 3.
    """
    model = thruster_model(propeller, drive, vehicle)
    code = np.arange(1.0, vehicle.drive.code_max + 1.0)
    table_speed = np.array(vehicle.tables.speed_mps)
    steps = round(float(table_speed[-1]) / SPEED_STEP_MPS)
    speed = np.unique(
        np.round(np.concatenate([table_speed, np.arange(steps + 1) * SPEED_STEP_MPS]), 9)
    )
    speeds, codes = np.meshgrid(speed, code, indexing="ij")
    flat = model.solve(codes.ravel(), speeds.ravel())
    if not (flat.found & (speeds.ravel() == 0)).any():
        raise CannotComputeError(explain_no_balance(model, drive))
    jacobian = thrust_jacobian(model, flat, codes.ravel())
    std = np.sqrt(np.einsum("ij,jk,ik->i", jacobian, model.covariance(), jacobian))
    status = _status(flat, codes.ravel(), propeller, drive)
    rows_of_table = {v: _table_row(v, model, drive, code) for v in table_speed.tolist()}
    ratio = _monte_carlo_ratio(model, table_speed, drive)

    def grid(values: FloatArray) -> Matrix:
        return tuple(tuple(row) for row in values.reshape(speeds.shape).tolist())

    rows = status.reshape(speeds.shape)
    return StaticCharacteristic(
        speed_mps=tuple(speed.tolist()),
        code=tuple(code.tolist()),
        thrust_n=grid(flat.thrust_n),
        thrust_std_n=grid(std),
        shaft_speed_rpm=grid(flat.shaft_speed_rps * 60.0),
        torque_nm=grid(flat.torque_nm),
        advance_ratio=grid(flat.advance_ratio),
        status=tuple(tuple(row) for row in rows.tolist()),
        table2=tuple(row for row in rows_of_table.values() if row is not None),
        monte_carlo_draws=DRAWS,
        monte_carlo_ratio=ratio,
        checks=grid_checks(flat.thrust_n.reshape(speeds.shape), rows, ratio, DRAWS),
        explanations=(
            *explain_status(rows, speed, code, propeller, drive),
            *(
                f"Table 2 has no row at {v:g} m/s: fewer than {FEWEST_LIVE_CODES} of the tested "
                "codes give thrust there."
                for v, row in rows_of_table.items()
                if row is None
            ),
        ),
    )


def thruster_model(propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle) -> ThrusterModel:
    """Gather the two fits into the model whose balance is solved."""
    fastest = max(spread.shaft_speed_rpm[1] for spread in drive.codes) / 60.0
    return ThrusterModel(
        propeller=OpenWaterPropeller(
            np.array(propeller.thrust.coefficients),
            np.array(propeller.torque.coefficients),
            propeller.diameter_m,
            vehicle.water.density_kgpm3,
        ),
        surface=torque_surface(drive),
        thrust_covariance=np.array(propeller.thrust.covariance),
        torque_covariance=np.array(propeller.torque.covariance),
        drive_covariance=np.array(drive.covariance),
        fastest_shaft_rps=SEARCH_BEYOND * fastest,
    )


def _status(
    points: WorkingPoints, code: FloatArray, propeller: PropellerFit, drive: DriveFit
) -> np.typing.NDArray[np.str_]:
    measured_codes = np.array([spread.code for spread in drive.codes])
    slow, fast = (
        np.interp(code, measured_codes, [spread.shaft_speed_rpm[end] for spread in drive.codes])
        for end in (0, 1)
    )
    margin = SPEED_MARGIN * (fast - slow)
    rpm = points.shaft_speed_rps * 60.0
    ratio_range = propeller.torque.quality.valid_range
    outside: BoolArray = (
        (code < measured_codes[0])
        | (code > measured_codes[-1])
        | (rpm < slow - margin)
        | (rpm > fast + margin)
        | (points.advance_ratio > ratio_range[1])
        | (points.advance_ratio < min(ratio_range[0], 0.0))
    )
    names: list[PointStatus] = ["dead", "no_working_point", "extrapolated"]
    return np.select([points.dead, ~points.found, outside], names, default="live")


def _table_row(
    speed_mps: float, model: ThrusterModel, drive: DriveFit, code: FloatArray
) -> StaticRow | None:
    """Fit eq. (4) to the family at one speed, over the codes that the bench covers."""
    tested = code[(code >= drive.code_range[0]) & (code <= drive.code_range[1])]
    points = model.solve(tested, np.full(tested.shape, speed_mps))
    live = points.found
    last = model.solve(code[-1:], np.array([speed_mps]))
    thrust_max = float(last.thrust_n[0])
    gradient = thrust_jacobian(model, last, code[-1:])[0]
    half = NORMAL_95 * float(np.sqrt(gradient @ model.covariance() @ gradient))
    width = 3
    if live.sum() < FEWEST_LIVE_CODES:
        return None
    thrust_n, used = points.thrust_n[live], tested[live]
    design = np.vander(used, width, increasing=True)
    solver = np.linalg.pinv(design)
    coefficients = solver @ thrust_n
    jacobian = solver @ thrust_jacobian(model, points, tested)[live]
    covariance = jacobian @ model.covariance() @ jacobian.T
    spread = NORMAL_95 * np.sqrt(np.diag(covariance))
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
        dead_zone_code=dead_zone_edge(coefficients),
        thrust_max_n=thrust_max,
        thrust_max_ci95=(thrust_max - half, thrust_max + half),
        mode_code=tuple(used.tolist()),
        thrust_modes_n=_covariance_modes(model, points, tested, live),
    )


def _covariance_modes(
    model: ThrusterModel, points: WorkingPoints, code: FloatArray, live: BoolArray
) -> Matrix:
    """Eigenvectors of Cov(T) along the live codes, scaled; the negligible ones are left out."""
    jacobian = thrust_jacobian(model, points, code)[live]
    values, vectors = np.linalg.eigh(jacobian @ model.covariance() @ jacobian.T)
    keep = values > SMALLEST_MODE * values.max()
    return tuple(tuple(mode) for mode in (vectors[:, keep] * np.sqrt(values[keep])).T.tolist())


def dead_zone_edge(coefficients: Sequence[float] | FloatArray) -> float:
    """Code at which K_F0 + K_F1 N + K_F2 N^2 rises through zero, 0 if it is positive at N = 0.

    The paper prints "T = 0 for |N| <= K_F0", but K_F0 is a thrust: the dead zone ends at the root.

    Parameters
    ----------
    coefficients : sequence of 3 floats
        K_F0 [N], K_F1 [N], K_F2 [N].

    Examples
    --------
    Table 2 of Kostenko 2023 at rest:

    >>> round(dead_zone_edge([-4.0, 0.254, 8.82e-4]), 1)
    15.0
    """
    if coefficients[0] >= 0:
        return 0.0
    roots = np.polynomial.polynomial.polyroots(coefficients)
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    return float(real.min()) if real.size else float("inf")


def _monte_carlo_ratio(
    model: ThrusterModel, speeds: FloatArray, drive: DriveFit
) -> tuple[float, float]:
    """Range of Monte Carlo over analytic standard error at tested codes that give 1 N and more.

    Closer to zero thrust a draw can fall into the dead zone, where the linear propagation ends.
    """
    codes = np.array([spread.code for spread in drive.codes])
    speed, code = (a.ravel() for a in np.meshgrid(speeds, codes, indexing="ij"))
    points = model.solve(code, speed)
    clear = points.found & (points.thrust_n > 1.0)
    jacobian = thrust_jacobian(model, points, code)[clear]
    analytic = np.sqrt(np.einsum("ij,jk,ik->i", jacobian, model.covariance(), jacobian))
    drawn = monte_carlo_std(model, code[clear], speed[clear], draws=DRAWS, seed=SEED)
    ratio = drawn / np.maximum(analytic, 1e-12)
    return float(ratio.min()), float(ratio.max())
