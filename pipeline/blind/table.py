"""Readings of the truth as a table on one time base, as a log of them would be read."""

import numpy as np

from pipeline.blind.truth.sensors import Log, SensorReading
from pipeline.records.held_commands import mean_held
from pipeline.records.run_table import OffRow, RunTable
from pipeline.types import BoolArray, FloatArray

#: A gap of more than so many periods is not bridged.
BRIDGED_PERIODS = 2.5
#: Quantity -> instrument and its columns.
_PARTS = {
    "angular_velocity": ("imu", slice(0, 3)),
    "specific_force": ("imu", slice(3, 6)),
    "attitude": ("imu", slice(6, 10)),
    "velocity": ("dvl", slice(0, 3)),
    "depth": ("depth", slice(0, 1)),
    "position": ("position", slice(0, 3)),
    "shaft_speed": ("shaft_speed", slice(None)),
    "voltage": ("voltage", slice(0, 1)),
}


def table_of(
    log: Log, thrusters: tuple[str, ...], name: str, start_time_ns: int, period_s: float = 0.02
) -> RunTable:
    """Put readings onto one time base; lines between readings, commands held.

    Parameters
    ----------
    log : dict of SensorReading
        From `pipeline.blind.truth.sensors.read_all`.
    thrusters : tuple of str
        Names of the columns of the commands.
    name : str
        Name of the run.
    start_time_ns : int
        Time zero on the clock of the log. [ns]
    period_s : float
        Period of the table. [s]

    Returns
    -------
    RunTable
        Not a number where nothing is valid.
    """
    command = log["command"]
    end = float(command.logged_s[-1])
    time_s = np.asarray(np.arange(int(end / period_s + 1e-6) + 1) * period_s, np.float64)
    held = mean_held(command.stamp_s, command.values, time_s, period_s)
    values: dict[str, FloatArray] = {"command": held}
    valid: dict[str, BoolArray] = {"command": time_s + 0.5 * period_s >= command.stamp_s[0]}
    reading: dict[str, BoolArray] = {"command": _nearest(command.stamp_s, time_s)}
    off_row: dict[str, OffRow] = {}
    for quantity, (instrument, columns) in _PARTS.items():
        if instrument not in log or log[instrument].stamp_s.size < 2:
            continue
        source = log[instrument]
        values[quantity], valid[quantity] = _placed(source, source.values[:, columns], time_s)
        if quantity == "attitude":
            values[quantity] /= np.linalg.norm(values[quantity], axis=1, keepdims=True)
        reading[quantity] = _nearest(source.stamp_s, time_s) & valid[quantity]
        off = OffRow.of(time_s, values[quantity], source.stamp_s, source.values[:, columns])
        if off is not None:
            off_row[quantity] = off
    return RunTable(
        name,
        time_s,
        values,
        valid,
        reading=reading,
        off_row=off_row,
        thrusters=thrusters,
        start_time_ns=start_time_ns,
    )


def _placed(
    source: SensorReading, columns: FloatArray, time_s: FloatArray
) -> tuple[FloatArray, BoolArray]:
    stamp = source.stamp_s
    if columns.shape[1] == 4:
        # the same turn with the other sign would be interpolated the long way round
        flips = np.where((columns[1:] * columns[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
        columns = columns * np.concatenate([[1.0], np.cumprod(flips)])[:, None]
    out = np.stack([np.interp(time_s, stamp, column) for column in columns.T], axis=1)
    after = np.searchsorted(stamp, time_s - 1e-9)
    there = (time_s >= stamp[0] - 1e-9) & (after < stamp.size)
    high = np.clip(after, 1, stamp.size - 1)
    usual = float(np.median(np.diff(stamp)))
    exact = np.abs(stamp[np.clip(after, 0, stamp.size - 1)] - time_s) < 1e-9
    there &= exact | (stamp[high] - stamp[high - 1] <= BRIDGED_PERIODS * usual)
    out[~there] = np.nan
    return out, np.asarray(there)


def _nearest(stamp: FloatArray, time_s: FloatArray) -> BoolArray:
    index = np.rint(stamp / (time_s[1] - time_s[0])).astype(int)
    out = np.zeros(time_s.size, np.bool_)
    out[index[(index >= 0) & (index < time_s.size)]] = True
    return out
