"""What a fitted drive looks like when it is right, and what its intervals rest on."""

import numpy as np

from pipeline.identify.drive_bench import DriveBench, readings_at_code_0
from pipeline.identify.linear_fit import LinearFit
from pipeline.physics.drive import TorqueSurface, drive_torque, drive_torque_slope
from pipeline.records.fits import Check
from pipeline.records.intervals import SWEEPS_PER_TERM
from pipeline.records.measurements import LoadTestRecord


def physical_checks(bench: DriveBench, surface: TorqueSurface) -> tuple[Check, ...]:
    """Check that torque falls with shaft speed and rises with code where it was measured."""
    slope = drive_torque_slope(bench.shaft_speed_rps, bench.code, surface)
    step = 1.0
    rise = drive_torque(bench.shaft_speed_rps, bench.code + step, surface) - drive_torque(
        bench.shaft_speed_rps, bench.code, surface
    )
    return (
        Check(
            name="torque falls with shaft speed",
            passed=bool(np.all(slope < 0)),
            text=f"dM/dn from {slope.min() / 60:.3g} to {slope.max() / 60:.3g} N m per rpm "
            "at the measured points",
        ),
        Check(
            name="torque rises with code",
            passed=bool(np.all(rise > 0)),
            text=f"dM/dN from {rise.min() / step:.3g} to {rise.max() / step:.3g} N m per code "
            "at the measured points",
        ),
    )


def sweeps_check(sweeps: int, fit: LinearFit) -> Check:
    """Say whether the sweeps are enough for intervals that hold the truth as often as they say."""
    terms = len(fit.coefficients)
    if not fit.clustered:
        text = (
            f"{sweeps} sweeps are too few for the {terms} terms: the covariance takes the points "
            "of a sweep as independent, and the intervals are too narrow. Measure more codes, both "
            "branches, or a second drive"
        )
    elif sweeps < SWEEPS_PER_TERM * terms:
        text = (
            f"{sweeps} sweeps carry the covariance of {terms} terms, but are fewer than two for "
            "each term: the intervals hold the truth less often than 95 %. Measure more codes, "
            "both branches, or a second drive"
        )
    else:
        text = f"{sweeps} sweeps carry the covariance of {terms} terms"
    return Check(
        name="sweeps enough for the intervals",
        passed=fit.clustered and sweeps >= SWEEPS_PER_TERM * terms,
        text=text,
    )


def code_0_check(load_test: LoadTestRecord) -> tuple[Check, ...]:
    """Say how many readings were at code 0, where there were any."""
    idle = readings_at_code_0(load_test)
    if not idle:
        return ()
    return (
        Check(
            name="readings at code 0 left out",
            passed=True,
            text=f"{idle} at code 0, where nothing drives the shaft; they are not fitted",
        ),
    )
