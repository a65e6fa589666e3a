"""The points of a load test as columns, as the fit of the drive wants them, and its checks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.linear_fit import LinearFit
from pipeline.physics.drive import TorqueSurface, drive_torque, drive_torque_slope
from pipeline.records.fit_values import SWEEPS_PER_TERM
from pipeline.records.fits import Check
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.units import rpm_to_rps


@dataclass(frozen=True)
class DriveBench:
    """The fitted points as columns, mirrored to positive code, speed and torque."""

    points: tuple[LoadTestPoint, ...]
    shaft_speed_rps: FloatArray
    code: FloatArray
    torque_nm: FloatArray
    sweep: IntArray
    sheet: IntArray
    file: IntArray
    loading: BoolArray


def bench_of(load_test: LoadTestRecord) -> DriveBench:
    """Take the points to fit: with a code, without marks, and not at code 0.

    Raises
    ------
    CannotComputeError
        If none is left.
    """
    points = load_test.points_to_fit()
    if not points:
        without_code = sum(1 for p in load_test.points if p.code is None)
        idle = readings_at_code_0(load_test)
        if idle:
            raise CannotComputeError(
                f"the load test holds readings at code 0 alone ({idle} of them), where nothing "
                "drives the shaft; measure at codes other than 0, or correct the code column of "
                "the files in load_test/"
            )
        raise CannotComputeError(
            f"the load test holds {without_code} points but no control code, so the family M(n, N) "
            "has no second variable; add a code column, a sheet per code, or a mapping in "
            "vehicle.yaml under columns.load_test.code"
            if without_code
            else "no usable load-test points, so the drive's characteristic M(n, N) cannot be "
            "fitted; put M-Test workbooks into load_test/"
        )
    code = np.array([p.code for p in points], float)
    sign = np.sign(code)
    return DriveBench(
        points=points,
        shaft_speed_rps=sign * np.array([rpm_to_rps(p.shaft_speed_rpm) for p in points]),
        code=np.abs(code),
        torque_nm=sign * np.array([p.torque_nm for p in points]),
        sweep=_labels([(p.source.file, p.code, p.branch) for p in points]),
        sheet=_labels([(p.source.file, p.source.sheet, p.code) for p in points]),
        file=_labels([p.source.file for p in points]),
        loading=np.array([p.branch == "loading" for p in points]),
    )


def readings_at_code_0(load_test: LoadTestRecord) -> int:
    """Count the usable readings at code 0: which side they mirror to, nobody knows."""
    return sum(1 for p in load_test.points if not p.marks and p.code == 0)


def _labels(keys: Sequence[object]) -> IntArray:
    known: dict[object, int] = {}
    return np.array([known.setdefault(key, len(known)) for key in keys], dtype=np.int64)


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
