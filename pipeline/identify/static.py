"""The static characteristic T(N, V): torque balance of the fitted propeller and drive."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from pipeline.errors import CannotComputeError
from pipeline.identify.propeller import lowest_covered_ratio, measured_ratios
from pipeline.identify.working_grid import ThrusterFits, WorkingGrid, solve_grid, thrust_jacobian
from pipeline.physics.thrust_grid import dead_zone_code
from pipeline.physics.torque_balance import OpenWaterPropeller, first_zero, free_propeller_drag
from pipeline.records.fit_values import torque_surface
from pipeline.records.fits import (
    Check,
    DriveFit,
    FasterRows,
    FitQuality,
    PolynomialFit,
    PropellerFit,
    StaticCharacteristic,
    StaticRow,
)
from pipeline.types import FloatArray
from pipeline.units import rps_to_rpm
from pipeline.vehicle.schema import Vehicle


def grid_checks(thrust_n: FloatArray, status: npt.NDArray[np.str_]) -> tuple[Check, ...]:
    """Check that thrust rises with code and falls with speed."""
    met = status != "no_working_point"
    rises = np.diff(thrust_n, axis=1)[met[:, 1:] & met[:, :-1]] >= -1e-9
    falls = np.diff(thrust_n, axis=0)[met[1:] & met[:-1]] <= 1e-9
    return (
        Check(
            name="thrust rises with code",
            passed=bool(rises.all()),
            text=f"{int((~rises).sum())} of {rises.size} steps of the grid fall",
        ),
        Check(
            name="thrust falls with speed",
            passed=bool(falls.all()),
            text=f"{int((~falls).sum())} of {falls.size} steps of the grid rise",
        ),
    )


def explain_status(
    status: npt.NDArray[np.str_],
    speed: FloatArray,
    code: FloatArray,
    model: ThrusterFits,
    table_speed_mps: Sequence[float],
) -> tuple[str, ...]:
    """Say in sentences which parts of the family are dead, extrapolated or missing, and why.

    `status` has a row for each `speed` [m/s] and a column for each `code`. The dead zone is told at
    the speeds of the tables, not at every step of the grid.
    """
    propeller, (lowest, highest_code) = model.propeller_fit, model.drive.code_range
    lines = []
    untested = [f"below {lowest:g}"] if code[0] < lowest else []
    untested += [f"above {highest_code:g}"] if code[-1] > highest_code else []
    if untested:
        lines.append(
            f"Codes {' and '.join(untested)} were not on the bench, and the family M(n, N) says "
            "nothing there: thrust, shaft speed and torque continue the line through the two "
            "nearest tested codes at each speed, not below zero; the results are marked as "
            "extrapolated."
        )
    for row, v in zip(status, speed, strict=True):
        dead = code[row == "dead"]
        if dead.size and v > 0 and np.isclose(v, table_speed_mps).any():
            lines.append(
                f"At {v:g} m/s codes up to {dead.max():g} give no thrust: at the shaft speed where "
                "K_T = 0 the propeller already needs more torque than the drive has."
            )
        unmet = code[row == "no_working_point"]
        if unmet.size:
            lines.append(
                f"At {v:g} m/s the curves do not meet at {unmet.size} codes "
                f"({unmet.min():g} to {unmet.max():g}): the propeller stays below the drive's "
                "torque at every shaft speed the bench supports."
            )
    begins, highest = measured_ratios(propeller)
    if lowest_covered_ratio(propeller) > 0:
        lines.append(
            f"The open-water test begins at J = {begins:.3f}: below it, and so at rest, K_T and "
            "K_M are the curves continued."
        )
    if "extrapolated" in status:
        lines.append(
            f"Working points beyond J = {highest:.3f} or outside the shaft speeds of the bench are "
            "extrapolated too."
        )
    return tuple(lines)


#: Spacing of the grid of speeds, and of the rows beyond the tables. [m/s]
SPEED_STEP_MPS, FASTER_STEP_MPS = 0.1, 0.2
#: Beyond the tables the balance is followed up to this many times their last speed.
FASTER_REACH = 3.0


def static_characteristic(
    propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle
) -> StaticCharacteristic:
    """Compute the family T(N, V) on a grid, its standard error, and Table 2.

    Thrust and speed are taken along the same direction, as in the paper; codes are positive and
    negative ones mirror them.

    The vehicle gives the water, the range of codes and the speeds of the tables.

    Raises
    ------
    CannotComputeError
        If the propeller's torque meets the drive's at no code at rest, or it gives no thrust.

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
    family = solve_grid(model, speed_mps=speed, code=code)
    if not (family.thrust_n > 0).any():
        raise CannotComputeError(
            "the propeller gives no positive thrust at any code and speed of the tables: K_T at "
            f"J = 0 is {propeller.thrust.coefficients[0]:.3g}. Check the sign of the thrust in "
            "open_water/"
        )
    table2 = {
        v: table2_row(v, model, code, family.thrust_max(int(np.abs(speed - v).argmin())))
        for v in table_speed.tolist()
    }
    return StaticCharacteristic(
        speed_mps=speed.tolist(),
        code=code.tolist(),
        thrust_n=family.thrust_n.tolist(),
        thrust_std_n=family.thrust_std_n.tolist(),
        shaft_speed_rpm=[[rps_to_rpm(n) for n in row] for row in family.shaft_speed_rps.tolist()],
        torque_nm=family.torque_nm.tolist(),
        advance_ratio=family.advance_ratio.tolist(),
        status=family.status.tolist(),
        table2=tuple(row for row in table2.values() if row is not None),
        checks=grid_checks(family.thrust_n, family.status),
        faster=_faster(model, code, float(speed[-1])),
        free_drag_ns2pm2=_free_drag(model.propeller),
        sources=tuple(
            sorted(
                {p.source.file for p in propeller.thrust.points if p.source}
                | set(drive.torque_scale_by_file)
            )
        ),
        explanations=(
            *explain_status(family.status, speed, code, model, vehicle.tables.speed_mps),
            *(
                f"Table 2 has no row at {v:g} m/s: fewer than {FEWEST_LIVE_CODES} of the tested "
                "codes give thrust there."
                for v, row in table2.items()
                if row is None
            ),
        ),
    )


def _faster(model: ThrusterFits, code: FloatArray, last: float) -> FasterRows | None:
    """Follow the balance beyond the tables for as long as the largest code gives thrust."""
    steps = np.arange(int(np.ceil((FASTER_REACH - 1.0) * last / FASTER_STEP_MPS)) + 1)
    speed = np.round(last + FASTER_STEP_MPS * steps, 9)

    def solved(speeds: FloatArray, codes: FloatArray) -> WorkingGrid:
        at = np.concatenate([[0.0], speeds])
        return solve_grid(model, speed_mps=at, code=codes)

    top = solved(speed, code[code >= min(model.drive.code_range[1] - 1.0, code[-2:][0])])
    thrust, status = top.thrust_n[1:, -1], top.status[1:, -1]
    stops = np.flatnonzero((thrust <= 0.0) | (status == "no_working_point"))
    count = int(stops[0]) if stops.size else len(speed)
    if count <= 1:
        return None
    ends: Literal["no thrust", "no working point", "search ends"] = "search ends"
    if stops.size:
        ends = "no thrust" if status[count] != "no_working_point" else "no working point"
    grid = solved(speed[1:count], code)
    untested = np.flatnonzero(status[:count] != "live")
    tested = int(untested[0]) - 1 if untested.size else count - 1
    return FasterRows(
        speed_mps=speed[1:count].tolist(),
        thrust_n=grid.thrust_n[1:].tolist(),
        thrust_std_n=grid.thrust_std_n[1:].tolist(),
        tested_mps=float(speed[max(tested, 0)]),
        ends=ends,
    )


def _free_drag(propeller: OpenWaterPropeller) -> float:
    """Drag of the freely turning propeller at 1 m/s, 0 where the curves do not tell it. [N]."""
    if not np.isfinite(first_zero(propeller.torque_coefficients)):
        return 0.0
    return max(float(free_propeller_drag(1.0, propeller)), 0.0)


def thruster_model(propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle) -> ThrusterFits:
    """Gather the two fits into the model whose balance is solved."""
    own = OpenWaterPropeller(
        np.array(propeller.thrust.coefficients),
        np.array(propeller.torque.coefficients),
        propeller.diameter_m,
        vehicle.water.density_kgpm3,
    )
    return ThrusterFits(propeller, drive, own, torque_surface(drive))


#: A row needs this many live codes.
FEWEST_LIVE_CODES = 8
#: Share of the largest variance below which a mode of the covariance is left out.
SMALLEST_MODE = 1e-6


def table2_row(
    speed_mps: float, model: ThrusterFits, code: FloatArray, thrust_max: tuple[float, float]
) -> StaticRow | None:
    """Fit T = K_F0 + K_F1 N + K_F2 N^2 to the family at one speed, over the tested codes.

    `code` (c,) are the codes of the family, the last the largest that the firmware sends;
    `thrust_max` is the thrust there, which may not have been on the bench, and its standard error
    [N]. None where too few codes give thrust.

    References
    ----------
    Kostenko 2023, eq. (4), Table 2.
    """
    tested = code[model.tested(code)]
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
        coefficients=coefficients.tolist(),
        covariance=covariance.tolist(),
        ci95=np.stack([coefficients - spread, coefficients + spread], axis=1).tolist(),
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
        mode_code=used.tolist(),
        thrust_modes_n=_modes(of_thrust).tolist(),
    )


def _modes(covariance: FloatArray) -> FloatArray:
    """Eigenvectors of Cov(T) along the live codes, scaled; the negligible ones are left out."""
    values, vectors = np.linalg.eigh(covariance)
    keep = values > SMALLEST_MODE * values.max()
    return np.asarray((vectors[:, keep] * np.sqrt(values[keep])).T)
