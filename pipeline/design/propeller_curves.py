"""Curves of a propeller of the series: open water, and thrust and torque over shaft speed."""

import numpy as np

from pipeline.design.propeller_select import Task, screw
from pipeline.design.propeller_series import Geometry, thrust_coefficient, torque_coefficient
from pipeline.physics.propeller import efficiency
from pipeline.records.design import PropellerCurves
from pipeline.types import FloatArray


def propeller_curves(task: Task, shape: Geometry) -> PropellerCurves:
    """Return open-water curves, and thrust and torque beside the drive."""
    j = np.linspace(0.0, 1.6, 81)
    k_t, k_q = thrust_coefficient(j, shape), torque_coefficient(j, shape)
    end = int(np.argmax(k_t <= 0)) if (k_t <= 0).any() else len(j)
    j, k_t, k_q = j[:end], k_t[:end], k_q[:end]
    slow, fast = task.drive.slowest_rps, task.drive.fastest_rps
    shaft = (
        np.linspace(0.6 * slow, 1.15 * fast, 60)
        if task.drive.point
        else np.linspace(slow, fast, 60)
    )
    at = screw(task, shape, shaft)
    real = (at.thrust_coefficient > 0) & (at.torque_coefficient > 0)
    drive = np.asarray(task.drive.torque_nm(shaft))
    stated: tuple[float | None, ...] = (
        (None,) * len(shaft) if task.drive.point else tuple(float(m) for m in drive)
    )
    return PropellerCurves(
        advance_ratio=tuple(j.tolist()),
        thrust_coefficient=tuple(k_t.tolist()),
        torque_coefficient=tuple(k_q.tolist()),
        efficiency=tuple(np.asarray(efficiency(j, k_t, k_q)).tolist()),
        shaft_speed_rpm=tuple((60 * shaft).tolist()),
        drive_torque_nm=stated,
        propeller_torque_nm=_shown(at.torque_nm, real),
        propeller_thrust_n=_shown(at.thrust_n, real),
    )


def _shown(values: FloatArray, real: "np.typing.NDArray[np.bool_]") -> tuple[float | None, ...]:
    return tuple(float(v) if ok else None for v, ok in zip(values, real, strict=True))
