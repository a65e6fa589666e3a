"""One sweep of the load bench at one code: what the brake, the tachometer and the meters show."""

import math
from dataclasses import dataclass

from evaluation.bundled.mmt300_electric import electric
from evaluation.bundled.mmt300_truth import (
    SPEED_LIMIT_RPM,
    drive_speed,
    drive_torque,
    working_point,
)
from evaluation.bundled.noise import Noise

#: Readings on each branch.
STEPS = 26
#: Readings while the drive still runs up; they are no steady points.
WARM_UP_READINGS = 5
#: Time between readings. [s]
STEP_S = 2.0
#: The brake is loaded up to this share of the torque at rest (bollard), and down to the lower one.
LOAD_SHARES = (0.15, 1.20)
#: Lowest load that the brake can hold. [N m]
LEAST_TORQUE_NM = 0.006
#: Torque of the unloading branch over that of the loading one, less 1.
HYSTERESIS = 0.005


@dataclass(frozen=True)
class BenchReading:
    """One row of a load test, before it is written in the file's units."""

    time_s: float
    shaft_speed_rpm: float
    torque_nm: float
    current_a: float
    voltage_v: float

    @property
    def input_power_w(self) -> float:
        """Electrical power, as the bench computes it from its own readings."""
        return self.current_a * self.voltage_v

    @property
    def output_power_w(self) -> float:
        """Shaft power, as the bench computes it from its own readings."""
        return self.torque_nm * 2.0 * math.pi * self.shaft_speed_rpm / 60.0


def torque_range(code: int) -> tuple[float, float]:
    """Lowest and highest load at a code: the speed limit keeps the large codes loaded [N m].

    >>> low, high = torque_range(127)
    >>> round(low, 2), round(high, 2)
    (0.24, 0.88)
    """
    _, at_rest_nm = working_point(code, 0.0)
    low, high = (share * at_rest_nm for share in LOAD_SHARES)
    low = max(low, LEAST_TORQUE_NM)
    if drive_speed(low, code) > SPEED_LIMIT_RPM:
        low = float(drive_torque(SPEED_LIMIT_RPM, code))
    return low, high


def sweep(code: int, *, torque_scale: float, noise: Noise) -> list[BenchReading]:
    """Run up, load from the smallest to the largest torque, unload again.

    Parameters
    ----------
    code : int
        Control code, positive.
    torque_scale : float
        Torque of this exemplar of the drive over that of the family. [-]
    noise : Noise
        Source of the reading errors: torque 0.5 % of reading and 0.001 N m, speed 0.5 rpm and
        0.05 %, current 0.01 A and 0.5 %, voltage 0.02 V.
    """
    low, high = torque_range(code)
    loads = [low + (high - low) * step / (STEPS - 1) for step in range(STEPS)]
    readings = [_running_up(index, low, code, noise) for index in range(WARM_UP_READINGS)]
    for branch, torques in ((-0.5, loads), (0.5, loads[::-1])):
        scale = torque_scale * (1.0 + branch * HYSTERESIS)
        for planned_nm in torques:
            torque_nm = min(max(planned_nm * (1.0 + noise.normal(0.01)), low), high)
            speed_rpm = drive_speed(torque_nm / scale, code)
            readings.append(_read(len(readings) * STEP_S, speed_rpm, torque_nm, noise))
    return readings


def _running_up(index: int, torque_nm: float, code: int, noise: Noise) -> BenchReading:
    """Read while the shaft still gathers speed and the brake's load is not yet set."""
    share = (0.35, 0.68, 0.86, 0.95, 0.98)[index]
    speed_rpm = share * drive_speed(torque_nm, code)
    return _read(index * STEP_S, speed_rpm, torque_nm * (0.5 + 0.1 * index), noise)


def _read(time_s: float, speed_rpm: float, torque_nm: float, noise: Noise) -> BenchReading:
    meters = electric(speed_rpm, torque_nm)
    return BenchReading(
        time_s=time_s,
        shaft_speed_rpm=speed_rpm + noise.normal(math.hypot(0.5, 0.0005 * speed_rpm)),
        torque_nm=torque_nm + noise.normal(math.hypot(0.001, 0.005 * torque_nm)),
        current_a=meters.current_a + noise.normal(math.hypot(0.01, 0.005 * meters.current_a)),
        voltage_v=meters.voltage_v + noise.normal(0.02),
    )
