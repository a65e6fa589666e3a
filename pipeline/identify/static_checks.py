"""What a static family looks like when it is right, and why parts of it are missing."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from pipeline.identify.propeller import lowest_covered_ratio, measured_ratios
from pipeline.identify.working_grid import ThrusterFits
from pipeline.records.fits import Check
from pipeline.types import FloatArray


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
