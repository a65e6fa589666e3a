"""What the sensors would have read of a simulated motion, and how far the readings are from it."""

from dataclasses import replace

import numpy as np

from pipeline.identify.channel_noise import channel_noise, was_measured
from pipeline.identify.trial_windows import TrialFlights
from pipeline.records.run_table import COMPONENTS, RunTable, components, difference
from pipeline.records.trial import ChannelError, RunTrial
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.sensors import Log, measure
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import (
    Depth,
    Dvl,
    Imu,
    Position,
    Sensor,
    Sensors,
    ShaftSpeed,
    Voltage,
)

#: Sensor -> its class, and the quantities that it reads.
_SENSORS: dict[str, tuple[type[Sensor], tuple[str, ...]]] = {
    "imu": (Imu, ("angular_velocity", "specific_force", "attitude")),
    "dvl": (Dvl, ("velocity",)),
    "depth": (Depth, ("depth",)),
    "position": (Position, ("position",)),
    "shaft_speed": (ShaftSpeed, ("shaft_speed",)),
    # its nominal voltage is known to the vehicle file alone
    "voltage": (Voltage, ()),
}


def sensors_for(sensors: Sensors, table: RunTable, *, ideal: bool) -> Sensors:
    """Return sensors that read every quantity that a run has.

    One that the vehicle file leaves out sits at the origin and has the rate of the run. `ideal`
    ones are without delay and at the rate of the table, to be compared with it; others have their
    own. Always without noise: a prediction has none.
    """

    def rate(quantity: str) -> float:
        marks = table.reading.get(quantity)
        length = float(table.time_s[-1]) if table.time_s.size else 0.0
        count = int(marks.sum()) if marks is not None else 0
        return min(max(count / length, 0.1), 2000.0) if count and length > 0 else 10.0

    def quiet(sensor: Sensor) -> dict[str, object]:
        noise = [
            name
            for name in type(sensor).model_fields
            if "noise" in name or "bias" in name or name == "attitude_wander_rad"
        ]
        better: dict[str, object] = {"rate_hz": 1.0 / period, "delay_s": 0.0} if ideal else {}
        return {**dict.fromkeys(noise, 0.0), **better}

    period = table.period_s
    update: dict[str, object] = {}
    for name, (kind, quantities) in _SENSORS.items():
        own: Sensor | None = getattr(sensors, name)
        if own is None and any(was_measured(table, quantity) for quantity in quantities):
            own = kind(rate_hz=max(rate(quantity) for quantity in quantities))
        update[name] = None if own is None else own.model_copy(update=quiet(own))
    command = 1.0 / period if ideal else sensors.command_rate_hz
    return sensors.model_copy(update={**update, "command_rate_hz": command})


def predicted_table(
    packed: PackedVehicle, sensors: Sensors, table: RunTable, flown: TrialFlights
) -> RunTable:
    """Return what ideal sensors at their places would read of a flight, row by row of the table."""
    ideal = sensors_for(sensors, table, ideal=True)
    period = table.period_s
    found = table_of_log(
        measure(flown.trajectory, packed, ideal), ideal, name=table.name, period_s=period
    )
    values, valid = {}, {}
    for quantity, own in found.values.items():
        count = min(len(own), table.time_s.size)
        there = np.zeros(table.time_s.size, bool)
        there[:count] = found.valid[quantity][:count] & flown.valid[:count]
        values[quantity] = np.full((there.size, own.shape[1]), np.nan)
        values[quantity][there] = own[np.flatnonzero(there)]
        valid[quantity] = there
    return replace(found, time_s=table.time_s, values=values, valid=valid, reading={}, off_row={})


def sensor_log(
    packed: PackedVehicle, sensors: Sensors, table: RunTable, flown: TrialFlights
) -> Log:
    """Return the readings of a flight at the sensors' own rates and delays, for a log file."""
    own = sensors_for(sensors, table, ideal=False)
    log = measure(flown.trajectory, packed, own)
    grid = flown.trajectory.time_s
    kept: Log = {}
    for name, channel in log.items():
        row = np.clip(np.searchsorted(grid, channel.valid_s - 1e-9), 0, grid.size - 1)
        there = flown.valid[row]
        kept[name] = replace(
            channel,
            valid_s=channel.valid_s[there],
            logged_s=channel.logged_s[there],
            values=channel.values[there],
        )
    return kept


def compared(
    sensors: Sensors, table: RunTable, windowed: RunTable, flights: TrialFlights
) -> tuple[ChannelError, ...]:
    """Errors of every channel that was measured and simulated.

    `sensors` state the noise to compare with; `table` was measured and `windowed` predicted, on one
    time base.
    """
    noise = _noise(sensors, table)
    found = []
    for quantity, names in COMPONENTS.items():
        if not was_measured(table, quantity) or quantity not in windowed.values:
            continue
        labels = names or tuple((name, "rpm") for name in table.thrusters)
        measured = components(table, quantity)
        if measured.shape[1] != len(labels):
            continue
        rows = table.valid[quantity] & np.isfinite(measured).all(axis=1)
        if quantity in table.reading:
            rows &= table.reading[quantity]
        short = difference(quantity, measured, components(windowed, quantity))
        held = difference(quantity, measured, _held(table, rows, measured, flights))
        for column, (name, unit) in enumerate(labels):
            own = rows & np.isfinite(short[:, column])
            if not own.any():
                continue
            error = short[own, column]
            worst = int(np.argmax(np.abs(error)))
            found.append(
                ChannelError(
                    channel=name,
                    quantity=quantity,
                    unit=unit,
                    readings=int(own.sum()),
                    sensor_noise=noise.get(quantity),
                    rmse_windows=float(np.sqrt(np.mean(error**2))),
                    mean_windows=float(error.mean()),
                    worst_windows=float(error[worst]),
                    worst_at_s=float(table.time_s[own][worst]),
                    rmse_last_value=_rms(held[own, column]),
                )
            )
    return tuple(found)


def _held(
    table: RunTable, rows: BoolArray, measured: FloatArray, flights: TrialFlights
) -> FloatArray:
    """Hold the last reading before each window; `rows` (m,) have readings."""
    lead, begins = round(flights.lead_s / table.period_s), np.array(flights.first_rows)
    latest = np.maximum.accumulate(np.where(rows, np.arange(rows.size), -1))
    number = np.maximum(np.searchsorted(begins, np.arange(rows.size), side="right") - 1, 0)
    at = latest[begins[number]]
    # a reading from before the lead is no start for this window
    fresh = (at >= 0) & (at >= begins[number] - lead)
    return np.where(fresh[:, None], measured[np.maximum(at, 0)], np.nan)


def _noise(sensors: Sensors, table: RunTable) -> dict[str, float]:
    """Return the standard deviation of one reading where the vehicle file states the noise."""
    found = {
        one.quantity: one.of_reading(offset=True)
        for one in channel_noise(sensors, [table])
        if one.stated
    }
    if sensors.shaft_speed is not None and sensors.shaft_speed.noise_rpm > 0:
        found["shaft_speed"] = sensors.shaft_speed.noise_rpm
    if sensors.voltage is not None and sensors.voltage.noise_v > 0:
        found["voltage"] = sensors.voltage.noise_v
    return found


def _rms(values: FloatArray) -> float | None:
    """Root mean square of what is finite."""
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else None


#: A thruster this long at the end of its range has no control left. [share of the time]
LONG_AT_LIMIT = 0.2
#: Gaps in the commands of less than this in all are not worth a warning. [s]
LONG_WITHOUT_S = 5.0


def trial_warnings(trial: RunTrial) -> tuple[str, ...]:
    """Return sentences, the most serious first."""
    found = []
    losing: dict[str, list[str]] = {}
    for one in trial.channels:
        if one.loses:
            losing.setdefault(one.quantity.replace("_", " "), []).append(one.channel)
    if losing:
        names = [f"{quantity} ({', '.join(own)})" for quantity, own in losing.items()]
        found.append(
            f"Over {trial.horizon_s:g} s the model predicts {', '.join(names)} "
            "worse than keeping the last reading does: its thrust, damping or axes are wrong "
            "there, or the channel is mapped with a wrong sign or unit."
        )
    if trial.windows_left_out:
        found.append(
            f"{trial.windows_left_out} of {trial.windows + trial.windows_left_out} windows were "
            "not predicted: readings are missing there, or the simulation ran away."
        )
    if trial.without_commands_s > LONG_WITHOUT_S:
        found.append(
            f"For {trial.without_commands_s:.0f} s of the run there are no commands: nothing is "
            "predicted there."
        )
    found += [
        f"Thruster {name} is at the end of its range for {share:.0%} of the time."
        for name, share in trial.commands_at_limit.items()
        if share > LONG_AT_LIMIT
    ]
    return tuple(found)
