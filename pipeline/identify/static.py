"""The static characteristic T(N, V): torque balance of the fitted propeller and drive."""

from typing import Literal

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.static_checks import explain_status, grid_checks
from pipeline.identify.table2 import FEWEST_LIVE_CODES, table2_row
from pipeline.identify.working_grid import (
    SEARCH_BEYOND,
    ThrusterFits,
    WorkingGrid,
    solve_grid,
)
from pipeline.physics.torque_balance import OpenWaterPropeller, first_zero, free_propeller_drag
from pipeline.records.fit_values import torque_surface
from pipeline.records.fits import (
    DriveFit,
    FasterRows,
    Matrix,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.intervals import drive_degrees
from pipeline.types import FloatArray
from pipeline.units import rpm_to_rps, rps_to_rpm
from pipeline.vehicle.schema import Vehicle

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
    family = solve_grid(model, propeller, drive, speed_mps=speed, code=code)
    if not (family.thrust_n > 0).any():
        raise CannotComputeError(
            "the propeller gives no positive thrust at any code and speed of the tables: K_T at "
            f"J = 0 is {propeller.thrust.coefficients[0]:.3g}. Check the sign of the thrust in "
            "open_water/"
        )
    table2 = {
        v: table2_row(v, model, drive, code, family.thrust_max(int(np.abs(speed - v).argmin())))
        for v in table_speed.tolist()
    }
    return StaticCharacteristic(
        speed_mps=tuple(speed.tolist()),
        code=tuple(code.tolist()),
        thrust_n=_matrix(family.thrust_n),
        thrust_std_n=_matrix(family.thrust_std_n),
        shaft_speed_rpm=tuple(
            tuple(rps_to_rpm(n) for n in row) for row in family.shaft_speed_rps.tolist()
        ),
        torque_nm=_matrix(family.torque_nm),
        advance_ratio=_matrix(family.advance_ratio),
        status=tuple(tuple(row) for row in family.status.tolist()),
        table2=tuple(row for row in table2.values() if row is not None),
        checks=grid_checks(family.thrust_n, family.status),
        faster=_faster(model, propeller, drive, code, float(speed[-1])),
        free_drag_ns2pm2=_free_drag(model.propeller),
        sources=tuple(
            sorted(
                {p.source.file for p in propeller.thrust.points if p.source}
                | set(drive.torque_scale_by_file)
            )
        ),
        explanations=(
            *explain_status(
                family.status,
                speed,
                code,
                propeller,
                drive,
                table_speed_mps=vehicle.tables.speed_mps,
            ),
            *(
                f"Table 2 has no row at {v:g} m/s: fewer than {FEWEST_LIVE_CODES} of the tested "
                "codes give thrust there."
                for v, row in table2.items()
                if row is None
            ),
        ),
    )


def _matrix(values: FloatArray) -> Matrix:
    return tuple(tuple(row) for row in values.tolist())


def _faster(
    model: ThrusterFits, propeller: PropellerFit, drive: DriveFit, code: FloatArray, last: float
) -> FasterRows | None:
    """Follow the balance beyond the tables for as long as the largest code gives thrust."""
    steps = np.arange(int(np.ceil((FASTER_REACH - 1.0) * last / FASTER_STEP_MPS)) + 1)
    speed = np.round(last + FASTER_STEP_MPS * steps, 9)

    def solved(speeds: FloatArray, codes: FloatArray) -> WorkingGrid:
        at = np.concatenate([[0.0], speeds])
        return solve_grid(model, propeller, drive, speed_mps=at, code=codes)

    top = solved(speed, code[code >= min(drive.code_range[1] - 1.0, code[-2:][0])])
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
        speed_mps=tuple(speed[1:count].tolist()),
        thrust_n=_matrix(grid.thrust_n[1:]),
        thrust_std_n=_matrix(grid.thrust_std_n[1:]),
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
    fastest = rpm_to_rps(max(spread.shaft_speed_rpm[1] for spread in drive.codes))
    return ThrusterFits(
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
        degrees_of_freedom=drive_degrees(drive),
        fastest_shaft_rps=SEARCH_BEYOND * fastest,
    )
