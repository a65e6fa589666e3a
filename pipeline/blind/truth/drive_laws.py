"""What the truth knows of a drive with its propeller: laws made from the vehicle's own statements.

Of a bench-tested drive the processed static family is read as data: K_T(J), K_M(J) and the slope
of the motor's torque are fitted anew from its working points.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.kernel_forces import BALANCED, LAGGED, SCREW_LAW, SHARE
from pipeline.errors import CannotComputeError
from pipeline.records.fits import StaticCharacteristic
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.model_schema import FromBollard, ThrusterModel
from pipeline.vehicle.schema import Vehicle

#: Working points with less thrust say nothing about K_T: the dead zone's edge is a line there. [N]
SMALLEST_THRUST_N = 0.8


@dataclass(frozen=True)
class DriveLaw:
    """A drive with its propeller.

    `law` (10,), `steady` (speeds, codes), `motor` (codes,) as the kernel takes them; `code_lag_s`,
    `shaft_lag_s`, `rotor_kgm2` how the shaft follows; `most_n` the stated largest thrust ahead and
    astern; `inverse` (2, k): stated code at rest for even shares of it.
    """

    mode: float
    law: FloatArray
    steady: FloatArray
    motor: FloatArray
    code_lag_s: float
    shaft_lag_s: float
    rotor_kgm2: float
    most_n: tuple[float, float]
    inverse: FloatArray


def drive_law(
    vehicle: Vehicle, drive: str, propeller: str, static: StaticCharacteristic | None
) -> DriveLaw:
    """Make the law of a drive with its propeller."""
    if vehicle.model is None:
        raise CannotComputeError(f"{vehicle.name} has no model: section, so it cannot be flown")
    stated = vehicle.model.thrusters[drive]
    top = float(vehicle.drives[drive].code_max)
    if isinstance(stated.characteristic, FromBollard):
        return _bollard(stated, stated.characteristic, top)
    if static is None:
        raise CannotComputeError(
            f"drive {drive} of {vehicle.name} takes its thrust from the bench tables, and there "
            f"are none; run `rig2sea run {vehicle.name}` first"
        )
    diameter_m = vehicle.propellers[propeller].diameter_m
    return _benched(stated, static, diameter_m, vehicle.water.density_kgpm3)


def _bollard(stated: ThrusterModel, curve: FromBollard, top: float) -> DriveLaw:
    law = np.zeros(SCREW_LAW)
    law[:5] = (
        curve.thrust_max_n,
        -curve.thrust_min_n,
        curve.zero_thrust_speed_mps,
        curve.dead_zone_code,
        curve.exponent,
    )
    law[7:9], law[9] = 1.0, curve.free_drag_ns2pm2
    share = np.linspace(0.0, 1.0, 201)
    dead = curve.dead_zone_code
    code = dead + (top - dead) * share ** (1.0 / curve.exponent)
    return DriveLaw(
        mode=SHARE,
        law=law,
        steady=np.zeros((2, 2)),
        motor=np.zeros(2),
        # the statement is a lag of the code, and there is no shaft to know more of
        code_lag_s=stated.lag_s,
        shaft_lag_s=0.0,
        rotor_kgm2=1.0,
        most_n=(curve.thrust_max_n, -curve.thrust_min_n),
        inverse=np.stack([code, code]),
    )


def _benched(
    stated: ThrusterModel, static: StaticCharacteristic, diameter_m: float, density: float
) -> DriveLaw:
    speed, code = np.array(static.speed_mps), np.array(static.code)
    thrust, torque = np.array(static.thrust_n), np.array(static.torque_nm)
    shaft, advance = np.array(static.shaft_speed_rpm) / 60.0, np.array(static.advance_ratio)
    live = np.array(static.status) == "live"
    good = (thrust > SMALLEST_THRUST_N) & (shaft > 0.0) & live
    squared = density * np.maximum(shaft, 1e-9) ** 2
    law = np.zeros(SCREW_LAW)
    law[0] = diameter_m
    law[1:4] = _quadratic(advance[good], (thrust / (squared * diameter_m**4))[good])
    law[9] = static.free_drag_ns2pm2
    law[4:7] = _quadratic(advance[good], (torque / (squared * diameter_m**5))[good])
    grid = np.arange(speed[0], speed[-1] + 1e-9, 0.1)
    rows = np.array([np.argmin(np.abs(speed - v)) for v in grid])
    law[7], law[8] = code[1] - code[0], grid[1] - grid[0] if grid.size > 1 else 1.0
    steady = np.concatenate([np.zeros((rows.size, 1)), shaft[rows]], axis=1)
    motor = _motor_slopes(shaft, torque, good)
    curve = np.concatenate([[0.0], thrust[0]])
    first = max(int(np.argmax(curve > 0.0)) - 1, 0)
    codes = np.concatenate([[0.0], code])
    share = np.linspace(0.0, 1.0, 201)
    inverse = np.interp(share * curve[-1], curve[first:], codes[first:])
    most = (float(curve[-1]), float(curve[-1]))
    common = {"law": law, "steady": steady, "motor": motor, "most_n": most}
    inverse = np.stack([inverse, inverse])
    if stated.rotor_inertia_kgm2 is None or not torque.any():
        return DriveLaw(
            mode=LAGGED,
            code_lag_s=0.0,
            shaft_lag_s=stated.lag_s,
            rotor_kgm2=1.0,
            inverse=inverse,
            **common,  # type: ignore[arg-type]  # fields of the law by name
        )
    # the stated lag is that of the whole: what the rotor takes of it the controller does not
    half = shaft[0, code.size // 2]
    stiff = 2.0 * law[4] * density * diameter_m**5 * half - motor[code.size // 2]
    rotor_s = 2.0 * np.pi * stated.rotor_inertia_kgm2 / max(stiff, 1e-9)
    lag_s = 0.0 if stated.balance_in_time else max(stated.lag_s - rotor_s, 0.0)
    return DriveLaw(
        mode=BALANCED,
        code_lag_s=lag_s,
        shaft_lag_s=0.0,
        rotor_kgm2=stated.rotor_inertia_kgm2,
        inverse=inverse,
        **common,  # type: ignore[arg-type]  # fields of the law by name
    )


def _quadratic(x: FloatArray, y: FloatArray) -> FloatArray:
    """Coefficients 1, x, x^2 by least squares, then once more without the far points."""
    powers = np.stack([np.ones_like(x), x, x * x], axis=1)
    kept = np.ones(x.size, np.bool_)
    fitted: FloatArray = np.zeros(3)
    for _ in range(3):
        fitted = np.asarray(np.linalg.lstsq(powers[kept], y[kept], rcond=None)[0], np.float64)
        off = np.abs(powers @ fitted - y)
        kept = off <= max(4.0 * float(np.median(off)), 1e-9)
    return fitted


def _motor_slopes(shaft: FloatArray, torque: FloatArray, good: BoolArray) -> FloatArray:
    """Slope of the motor's torque against the shaft speed by code, not above zero (codes + 1,)."""
    slopes = np.full(shaft.shape[1] + 1, np.nan)
    for j in range(shaft.shape[1]):
        rows = good[:, j]
        if rows.sum() >= 3 and np.ptp(shaft[rows, j]) > 0.05:
            slopes[j + 1] = min(float(np.polyfit(shaft[rows, j], torque[rows, j], 1)[0]), 0.0)
    known = np.flatnonzero(np.isfinite(slopes))
    if not known.size:
        return np.zeros(slopes.size)
    return np.interp(np.arange(slopes.size), known, slopes[known])
