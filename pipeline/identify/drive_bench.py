"""The points of a load test as columns, as the fit of the drive wants them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
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
