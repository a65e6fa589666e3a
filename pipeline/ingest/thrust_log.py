"""A log in which thrust was measured, as the tables of a mooring test: one for each thruster."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.errors import CannotComputeError, InputError, Place
from pipeline.ingest.cells import Row, Sheet
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_resample import placed_on, resample, thrusters_of
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.schema import Vehicle

#: Rows of a table, at most, and in a second: steps of a command are held for seconds.
_MOST_ROWS, _RATE_HZ = 50_000, 10.0
#: A vehicle without a velocity that is moored stays within this. [m]
_MOORED_WITHIN_M = 0.5
_THRUST = "thrust_n."


def read_thrust_log(path: Path, shown_as: str, vehicle: Vehicle) -> tuple[Sheet, ...]:
    """Return code, thrust and the speed of the water along it over time, a sheet a thruster.

    The speed is that of the vehicle at the thruster, in still water. A log without a velocity was
    taken at a mooring, unless its position says that the vehicle went somewhere.

    Raises `InputError` when the log cannot be read, measures no thrust, or moved with nobody knows
    what speed.
    """
    place = Place(shown_as)
    run = read_pool_run(path, vehicle, path.parent)
    thrusts = {
        column.removeprefix(_THRUST): (channel, at)
        for channel in run.channels.values()
        if channel.quantity == "thrust"
        for at, column in enumerate(channel.columns)
    }
    own = {one.name for one in vehicle.thrusters if not vehicle.type_of(one)}
    wanted = [name for name in thrusts if name in own or not vehicle.thrusters]
    if not wanted:
        raise InputError.at(
            place,
            "this is the log of a pool run: it measures the thrust of no thruster of this type.",
            expected="a log with a channel of quantity thrust, or workbooks and text tables; pool "
            "runs in pool/.",
            remedy="Move it into the vehicle's pool/. If it does, map the force sensor under pool: "
            "channels in vehicle.yaml.",
        )
    table = _table(run, place)
    moves = _speeds(run, table, place)
    sheets = []
    for name in wanted:
        channel, at = thrusts[name]
        if name not in table.thrusters:
            raise InputError.at(place, f"it has the thrust of {name} and no commands for it.")
        code = table.values["command"][:, table.thrusters.index(name)]
        if not np.nan_to_num(code).any():  # it was never told to turn
            continue
        thrust_n = placed_on(channel, run.start_time_ns, table.time_s)[0][:, at]
        columns = [table.time_s, code, thrust_n]
        head = ["time_s", "code", "thrust_n"]
        there = table.valid["command"] & np.isfinite(thrust_n)
        if moves is not None:
            nu, known = moves
            columns.append(nu @ _twist(vehicle, name))
            head.append("speed_mps")
            there &= known
        for quantity, header in (("shaft_speed", "shaft_speed_rpm"), ("voltage", "voltage_v")):
            if quantity in table.values:
                own_column = table.thrusters.index(name) if quantity == "shaft_speed" else 0
                columns.append(table.values[quantity][:, own_column])
                head.append(header)
        sheets.append(_sheet(shown_as, name, tuple(head), np.stack(columns, axis=1)[there]))
    if not sheets:
        raise InputError.at(place, f"no command ever turned {', '.join(wanted)}.")
    faults = (one for one in run.problems if one.severity == "error")
    said = tuple(one.shown_as(shown_as) for one in faults)
    return (replace(sheets[0], problems=said), *sheets[1:])


def _table(run: PoolRun, place: Place) -> RunTable:
    """Put what is read beside the thrust onto one time base."""
    if not thrusters_of(run, "command"):
        raise InputError.at(
            place,
            "it has a measured thrust and no commands of the thrusters.",
            expected="the code of each thruster beside its thrust.",
            remedy="Map them under pool: channels in vehicle.yaml.",
        )
    try:
        rate_hz = min(_RATE_HZ, _MOST_ROWS / max(run.duration_s, 1.0))
        return resample(run, rate_hz, off_rows=False)
    except CannotComputeError as error:
        raise InputError.at(place, str(error)) from None


def _speeds(run: PoolRun, table: RunTable, place: Place) -> tuple[FloatArray, BoolArray] | None:
    """Return nu (m, 6) where it is known, None of a vehicle that is moored."""
    if "velocity" not in table.values:
        moved = 0.0
        if "position" in table.values and table.valid["position"].any():
            moved = float(table.values["position"][table.valid["position"]].std(axis=0).max())
        if "velocity_earth" in {one.quantity for one in run.channels.values()} or (
            moved > _MOORED_WITHIN_M
        ):
            raise InputError.at(
                place,
                "the vehicle moved while its thrust was measured, and its velocity in body axes is "
                "not known.",
                expected="a velocity in the log, or a vehicle that is moored.",
                remedy="Record the velocity (a DVL, or attitude beside a velocity over the earth).",
            )
        return None
    rates = table.values.get("angular_velocity", np.zeros_like(table.values["velocity"]))
    nu = np.nan_to_num(np.concatenate([table.values["velocity"], rates], axis=1))
    return nu, table.valid["velocity"]


def _twist(vehicle: Vehicle, name: str) -> FloatArray:
    """Return what nu (6,) is multiplied by for the speed along a thruster; else that ahead."""
    one = next((one for one in vehicle.thrusters if one.name == name), None)
    if one is None:
        return np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    moment = np.cross(one.position_m, one.direction)
    return np.asarray(np.concatenate([one.direction, moment]))


def _sheet(file: str, name: str, head: tuple[str, ...], rows: FloatArray) -> Sheet:
    """Write the rows as a raw file would have them; a cell without a number is empty."""

    def cells(row: FloatArray) -> Row:
        return tuple(float(one) if np.isfinite(one) else None for one in row)

    return Sheet(file, name, (head, *map(cells, rows)), 1)
