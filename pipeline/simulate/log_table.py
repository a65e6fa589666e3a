"""From the log of a simulated run to the table that identification, validation and diagnosis take.

The table of a measured run is made elsewhere, from its log file; both are alike: known delays
removed, every channel on one time base, velocity turned from the DVL's axes into the body's.
"""

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pipeline.records.run_table import OffRow, RunTable, mean_held
from pipeline.simulate.sensors import Channel, Log
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Between readings further apart than this many of the sensor's periods nothing is interpolated.
LARGEST_GAP_PERIODS = 2.5


def table_of_log(
    log: Log, sensors: Sensors, *, name: str = "simulated", period_s: float = 0.02
) -> RunTable:
    """Resample a simulated log to one time base, from 0 at the first command.

    Values are interpolated linearly between readings (attitude along the shortest turn); the
    command is the mean over the step that follows. `sensors` are those that measured: mounting of
    the DVL.
    """
    command = log["command"]
    begin, end = command.valid_s[[0, -1]]
    time_s = begin + period_s * np.arange(int(np.floor((end - begin) / period_s + 1e-9)) + 1)
    held = mean_held(command.valid_s, command.values, time_s, period_s)
    values: dict[str, FloatArray] = {"command": held}
    valid: dict[str, BoolArray] = {"command": np.ones(time_s.size, bool)}
    reading: dict[str, BoolArray] = {}
    off_row: dict[str, OffRow] = {}
    for quantity, channel, columns in _quantities(log, sensors):
        if not channel.valid_s.size:
            continue
        if quantity == "attitude":
            values[quantity] = _turned(channel.valid_s, columns, time_s)
        else:
            values[quantity] = np.stack(
                [np.interp(time_s, channel.valid_s, column) for column in columns.T], axis=1
            )
        valid[quantity] = _between_readings(channel.valid_s, time_s)
        reading[quantity] = _nearest(channel.valid_s, time_s) & valid[quantity]
        off = OffRow.of(time_s, values[quantity], channel.valid_s, columns)
        if off is not None:
            off_row[quantity] = off
    return RunTable(name, time_s - begin, values, valid, reading=reading, off_row=off_row)


def _quantities(log: Log, sensors: Sensors) -> list[tuple[str, Channel, FloatArray]]:
    found = []
    if "imu" in log:
        imu = log["imu"]
        found += [
            ("angular_velocity", imu, imu.values[:, 0:3]),
            ("specific_force", imu, imu.values[:, 3:6]),
            ("attitude", imu, imu.values[:, 6:10]),
        ]
    if "dvl" in log and sensors.dvl is not None:
        mount = Rotation.from_euler("ZYX", np.radians(sensors.dvl.rotation_deg)[::-1])
        body = mount.apply(log["dvl"].values) / sensors.dvl.scale
        found.append(("velocity", log["dvl"], body))
    found += [
        (name, log[name], log[name].values)
        for name in ("depth", "position", "shaft_speed", "voltage")
        if name in log
    ]
    return found


def _turned(reading_s: FloatArray, quaternion: FloatArray, time_s: FloatArray) -> FloatArray:
    turn = Rotation.from_quat(quaternion[:, [1, 2, 3, 0]])
    if reading_s.size > 1:
        turn = Slerp(reading_s, turn)(np.clip(time_s, reading_s[0], reading_s[-1]))
    x, y, z, w = np.broadcast_to(turn.as_quat().T, (4, time_s.size))
    return np.stack([w, x, y, z], axis=1)


def _between_readings(reading_s: FloatArray, time_s: FloatArray) -> BoolArray:
    """Whether a time has a reading on both sides that are not too far apart."""
    after = np.searchsorted(reading_s, time_s - 1e-9)
    inside = (time_s >= reading_s[0] - 1e-9) & (after < reading_s.size)
    if reading_s.size < 2:
        return np.asarray(inside)
    usual = float(np.median(np.diff(reading_s)))
    high = np.clip(after, 1, reading_s.size - 1)
    width = reading_s[high] - reading_s[high - 1]
    return np.asarray(inside & (width <= LARGEST_GAP_PERIODS * usual))


def _nearest(reading_s: FloatArray, time_s: FloatArray) -> BoolArray:
    period = time_s[1] - time_s[0] if time_s.size > 1 else 1.0
    index = np.round((reading_s - time_s[0]) / period).astype(int)
    marked = np.zeros(time_s.size, bool)
    marked[index[(index >= 0) & (index < time_s.size)]] = True
    return marked
