r"""Whether the heading counts the way the gyroscope, or else the commands, turn the vehicle.

Without a gyroscope the yaw moment of the commands, through the model's inertia and damping in yaw,
is what the rate of the heading should look like. Their correlation over a run needs no gain, no
mass and no velocity to be of the right size. How many independent samples it is worth follows from
the autocorrelations (Bartlett 1946): n / (1 + 2 sum (1 - k / n) a_k b_k) with a_k, b_k those at
lag k; Fisher's z then gives the chance of a correlation as negative where there is none.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from pipeline.identify.channel_noise import was_measured
from pipeline.identify.smoothing import leaky_sum
from pipeline.identify.thruster_regression import SETTLING_S
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable, angles
from pipeline.simulate.applied_wrench import actuator_states, levers, thruster_wrench
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray

YAW = 5
_STEP_S = 0.2
_FEWEST = 8.0
#: Beyond this pitch a heading turns without a yaw rate. [rad]
_STEEPEST = 1.0


@dataclass(frozen=True)
class HeadingCheck:
    """Correlation of the rate of the heading with what it should be, and the chance of less."""

    correlation: float
    p_negative: float
    told_by: str


def heading_check(packed: PackedVehicle, run: RunTable, delay_s: float) -> HeadingCheck | None:
    """Compare the rate of the heading with that of the gyroscope, or with the commands' yaw.

    `delay_s` is how late the commands act beyond the model's lag. None without an attitude, or
    where the vehicle hardly turns.
    """
    if "attitude" not in run.values or "command" not in run.values or run.time_s.size < 50:
        return None
    period = float(run.time_s[1] - run.time_s[0])
    roll_pitch_yaw = angles(run.values["attitude"])
    known = run.valid["attitude"] & np.isfinite(roll_pitch_yaw).all(axis=1)
    known &= (np.abs(np.nan_to_num(roll_pitch_yaw[:, 1])) < _STEEPEST) & run.valid["command"]
    known &= run.time_s - run.time_s[0] >= SETTLING_S
    gyroscope = was_measured(run, "angular_velocity")
    if gyroscope:
        known &= run.trusted("angular_velocity")
        roll, pitch = roll_pitch_yaw[:, 0], np.clip(roll_pitch_yaw[:, 1], -_STEEPEST, _STEEPEST)
        _, q, r = run.values["angular_velocity"].T
        expected = (np.sin(roll) * q + np.cos(roll) * r) / np.cos(pitch)
    else:
        expected = _expected_rate(packed, run, delay_s, period)
    yaw = np.unwrap(np.nan_to_num(roll_pitch_yaw[:, 2]))
    width = max(round(_STEP_S / period), 1)
    start = np.arange(0, yaw.size - width, width)
    start = start[known[start] & known[start + width // 2] & known[start + width]]
    measured = (yaw[start + width] - yaw[start]) / (width * period)
    meant = expected[start + width // 2]
    if start.size < 4 * _FEWEST or not measured.std() or meant.std() < 1e-3:
        return None
    correlation = float(np.corrcoef(measured, meant)[0, 1])
    samples = _worth(measured, meant)
    if samples < _FEWEST:
        return None
    z = float(np.arctanh(np.clip(correlation, -0.999, 0.999))) * (samples - 3.0) ** 0.5
    told_by = "the gyroscope" if gyroscope else "the yaw moment of the commands"
    return HeadingCheck(correlation, float(ndtr(z)), told_by)


def _expected_rate(
    packed: PackedVehicle, run: RunTable, delay_s: float, period: float
) -> FloatArray:
    """Yaw rate (m,) of the model for the commands, by inertia and linear damping alone."""
    command = np.nan_to_num(run.values["command"])
    late = np.maximum(np.arange(len(command)) - round(delay_s / period), 0)
    actuator = actuator_states(packed, command[late], period)[:-1]
    _, thrust = thruster_wrench(packed, actuator, np.zeros((len(command), 6)))
    moment = thrust @ levers(packed)[YAW]
    inertia = float(
        read(packed.vector, "inertia")[2, 2] + read(packed.vector, "added_mass")[YAW, YAW]
    )
    linear = float(read(packed.vector, "linear_damping")[YAW, YAW])
    quadratic = float(read(packed.vector, "quadratic_damping")[YAW])
    # quadratic damping as the line through the rate that the usual moment sustains
    usual = float(np.sqrt(np.mean(moment**2)))
    damping = linear + (quadratic * usual) ** 0.5
    keep = np.exp(-period * max(damping, 1e-9) / max(inertia, 1e-9))
    return leaky_sum(period / max(inertia, 1e-9) * moment, float(keep))


def _worth(first: FloatArray, second: FloatArray) -> float:
    """Count the independent samples that a correlation of two series is worth, at least 4."""
    count = first.size
    lags = np.arange(1, count // 4)
    both = 1.0 - lags / count
    for values in (first, second):
        rest = values - values.mean()
        at_lags = np.correlate(rest, rest, "full")[count : count + lags.size]
        both *= at_lags / max(float(rest @ rest), 1e-300)
    return float(max(count / max(1.0 + 2.0 * float(both.sum()), 1.0), 4.0))
