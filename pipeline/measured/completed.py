"""What a run did not measure and other sensors tell: rates, attitude and velocity by derivation."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.measured.motion import channel_of, smoothed, window_of
from pipeline.records.run_table import RunTable, continuous
from pipeline.types import FloatArray

#: Mean of the specific force that counts as the direction of gravity. [s]
_LEVEL_S = 2.0
#: A position that is read less often says little of a velocity. [s]
_OFTEN_S = 0.5


def completed(run: RunTable) -> RunTable:
    """Add rates by the attitude, attitude by the IMU, and velocity by the position.

    Each is at the origin, with more noise than a sensor of its own would have. What nothing tells
    stays absent.
    """
    found: dict[str, tuple[str, FloatArray]] = {}
    attitude = channel_of(run, "attitude")
    rates = channel_of(run, "angular_velocity")
    if rates is None and attitude is not None:
        found["angular_velocity"] = "attitude", _rates(run, attitude)
    force = channel_of(run, "specific_force")
    if attitude is None and rates is not None and force is not None:
        attitude = _levelled(rates, force, run.period_s)
        found["attitude"] = "specific_force", attitude
    position = channel_of(run, "position") if run.pause_s("position") <= _OFTEN_S else None
    if channel_of(run, "velocity") is None and position is not None and attitude is not None:
        over_ground = smoothed(position, window_of(run, "position"), run.period_s)[1]
        turn = Rotation.from_quat(attitude[:, [1, 2, 3, 0]])
        found["velocity"] = "position", turn.inv().apply(over_ground)
    return _with(run, found)


def _with(run: RunTable, found: Mapping[str, tuple[str, FloatArray]]) -> RunTable:
    """Add quantities that were derived from others, valid and read where those are."""
    values, valid, reading = dict(run.values), dict(run.valid), dict(run.reading)
    for quantity, (source, own) in found.items():
        values[quantity], valid[quantity] = own, run.valid[source]
        if source in reading:
            reading[quantity] = reading[source]
    return replace(run, values=values, valid=valid, reading=reading) if found else run


def _rates(run: RunTable, attitude: FloatArray) -> FloatArray:
    """Body rates (m, 3): omega = 2 q* dq/dt (Fossen 2021, eq. 2.78), smoothed."""
    value, slope = smoothed(continuous(attitude), window_of(run, "attitude"), run.period_s)
    w, v = value[:, :1], value[:, 1:]
    return np.asarray(2.0 * (w * slope[:, 1:] - slope[:, :1] * v - np.cross(v, slope[:, 1:])))


def _levelled(rates: FloatArray, force: FloatArray, period_s: float) -> FloatArray:
    """Attitude (m, 4) with roll and pitch by the mean specific force, and yaw by the rate."""
    from scipy.ndimage import uniform_filter1d

    mean = uniform_filter1d(force, max(round(_LEVEL_S / period_s), 1), axis=0, mode="nearest")
    # at rest the sensor reads the reaction to gravity: -g along down
    roll = np.arctan2(-mean[:, 1], -mean[:, 2])
    pitch = np.arctan2(mean[:, 0], np.hypot(mean[:, 1], mean[:, 2]))
    turning = (rates[:, 1] * np.sin(roll) + rates[:, 2] * np.cos(roll)) / np.cos(pitch)
    yaw = np.concatenate([[0.0], np.cumsum(0.5 * (turning[1:] + turning[:-1]) * period_s)])
    return Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, roll])).as_quat()[
        :, [3, 0, 1, 2]
    ]
