"""The commands of a log, and the state in which its vehicle was when they began.

Any log that `read_pool_run` understands will do, with the channel mapping of the vehicle file.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import InputError, Place
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.pool_run import RunNotes
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

_MOTION = ("/sim/odometry", "nav_msgs/msg/Odometry", "cdr")
_COMMAND = "thruster_command"
_PREFIX = "command."
#: A reading that is this far from the first command says nothing of it. [s]
_NEAR_S = 1.0
_MOST_NOTES = 8
#: What the start of a run is made of, and what a person calls it.
_OF_START = {"attitude": "attitude", "angular_velocity": "turning"} | {
    name: name for name in ("velocity", "depth", "position")
}


@dataclass(frozen=True)
class StartOfRun:
    """Position NED (3,) [m], quaternion w x y z (4,), nu (6,) [m/s, rad/s] of the first sample."""

    position_ned_m: FloatArray
    quaternion: FloatArray
    nu: FloatArray


def read_true_start(path: Path) -> StartOfRun | None:
    """Read the first true motion of a log in the layout of docs/formats_log.md, None for others.

    Raises `InputError` if the file is no MCAP file.
    """
    if path.suffix.lower() != ".mcap":
        return None  # another recorder's
    topics = McapFile(path, path.name).topics()
    named = (one for one in topics if (one.name, one.message_type, one.encoding) == _MOTION)
    message: Mapping[str, Any] | None = next((one.probe for one in named if one.probe), None)
    if message is None:
        return None
    pose, twist = message["pose"], message["twist"]
    parts = (pose["pose"]["position"], pose["pose"]["orientation"], *twist["twist"].values())
    place, (x, y, z, w), linear, angular = (np.array(list(one.values())) for one in parts)
    turn, nu = np.array([w, x, y, z]), np.concatenate([linear, angular])
    numbers = np.concatenate([place, turn, nu, pose["covariance"], twist["covariance"]])
    sound = np.isfinite(numbers).all() and abs(float(np.linalg.norm(turn)) - 1.0) < 1e-3
    return StartOfRun(place, turn, nu) if sound else None


@dataclass(frozen=True)
class RunCommands:
    """Commanded codes of a run.

    `time_s` (m,) from 0, which is `start_time_ns` on the clock of the log; `codes` (m, n), one
    column a name, each held until the next. `end_s` is when the run ends. `notes` say what is
    wrong with the log and what had to be assumed; `written` is what a person wrote of the run, by
    times from the start of the log, which lies at `log_start_s`, 0 or before.
    """

    start_time_ns: int
    names: tuple[str, ...]
    time_s: FloatArray
    codes: FloatArray
    end_s: float
    start: StartOfRun | None
    notes: tuple[str, ...] = ()
    written: RunNotes | None = None
    log_start_s: float = 0.0


def read_run_commands(path: Path, vehicle: Vehicle, raw_root: Path) -> RunCommands:
    """Read the commands of a log and the state to start from.

    The start is the true motion of a simulation where the log holds it, else what was measured next
    to the first command. Raises `InputError` if the file is no log, or holds no commands.
    """
    run = read_pool_run(path, vehicle, raw_root)
    said = [str(one) for one in run.problems if one.severity != "note"]
    if len(said) > _MOST_NOTES:
        more = f"and {len(said) - _MOST_NOTES} more; rig2sea check {path} names them all."
        said = [*said[:_MOST_NOTES], more]
    found = commands_of(run, vehicle)
    true = read_true_start(path)
    if true is None:
        return replace(found, notes=(*said, *found.notes))
    return replace(found, start=true, notes=tuple(said))


def commands_of(run: PoolRun, vehicle: Vehicle) -> RunCommands:
    """Take the commands out of a run; raises `InputError` if it has fewer than two of them."""
    channels = [one for one in run.channels.values() if one.quantity == _COMMAND]
    # asked thruster by thruster: a command that jumps or is zero is a command
    parts = [
        (one, _own_time_ns(one), one.timely() & ~one.marks.get("broken", np.False_))
        for one in channels
    ]
    times = [time_ns[kept] for _, time_ns, kept in parts]
    all_ns = np.unique(np.concatenate([np.empty(0, np.int64), *times]))
    if all_ns.size < 2:
        raise InputError.at(
            Place(run.file),
            f"holds {'one command' if all_ns.size else 'no commands'} for the thrusters.",
            expected="the commanded code or pulse width of each thruster, at least two messages.",
            remedy="Name their topic under pool: channels: of the vehicle file, quantity "
            "thruster_command; rig2sea check shows what was recognised.",
        )
    columns: dict[str, FloatArray] = {}
    for channel, time_ns, kept in parts:
        for name, values in zip(channel.columns, channel.values.T, strict=True):
            rows = kept & np.isfinite(values)
            columns[name.removeprefix(_PREFIX)] = _held(time_ns[rows], values[rows], all_ns)
    begin = int(all_ns[0])
    end = int(all_ns[-1])
    if not all(one.is_regular for one in channels):
        end = max(end, run.end_time_ns)  # sent on change: the last one holds to the end
    start, notes = _start_of(run, vehicle, begin)
    return RunCommands(
        begin,
        tuple(columns),
        (all_ns - begin) * 1e-9,
        np.stack(list(columns.values()), axis=1),
        (end - begin) * 1e-9,
        start,
        notes,
        run.notes,
        min(run.start_time_ns - begin, 0) * 1e-9,
    )


def _own_time_ns(channel: RunChannel) -> IntArray:
    return np.asarray(channel.time_ns - round(channel.delay_s * 1e9), dtype=np.int64)


def _held(time_ns: IntArray, values: FloatArray, at_ns: IntArray) -> FloatArray:
    """Values (k,) in force at times (m,); 0 before the first."""
    order = np.argsort(time_ns, kind="stable")
    index = np.searchsorted(time_ns[order], at_ns, side="right") - 1
    return np.concatenate([[0.0], values[order]])[index + 1]


def _start_of(
    run: PoolRun, vehicle: Vehicle, at_ns: int
) -> tuple[StartOfRun | None, tuple[str, ...]]:
    """State at a time from the readings next to it, and sentences on what had to be assumed."""
    from scipy.spatial.transform import Rotation

    sensors = vehicle.sensors
    taken = {called: _nearest(run, quantity, at_ns) for quantity, called in _OF_START.items()}
    attitude, rate, velocity, depth, position = taken.values()
    quaternion = np.array([1.0, 0.0, 0.0, 0.0]) if attitude is None else attitude
    turn = Rotation.from_quat(quaternion[[1, 2, 3, 0]])
    over_earth = _nearest(run, "velocity_earth", at_ns)
    if velocity is None and over_earth is not None:
        velocity = taken["velocity"] = turn.apply(over_earth, inverse=True)
    known = [name for name, value in taken.items() if value is not None]
    if not known:
        return None, ()
    nu = np.concatenate([np.zeros(3), np.zeros(3) if rate is None else rate])
    if velocity is not None:
        dvl = None if sensors is None else sensors.dvl
        place = np.zeros(3) if dvl is None else np.array(dvl.position_m)
        nu[:3] = velocity - np.cross(nu[3:], place)
    place_ned = np.zeros(3) if position is None else position.copy()
    if depth is not None:
        gauge = None if sensors is None else sensors.depth
        arm = np.zeros(3) if gauge is None else turn.apply(gauge.position_m)
        place_ned[2] = float(depth[0]) - float(arm[2])
    # a position is measured with its depth
    missing = [
        name
        for name, value in taken.items()
        if value is None and not (name == "depth" and position is not None)
    ]
    text = f"the run starts from what was measured of {_listed(known)} at the first command"
    if missing:
        text += f"; {_listed(missing)} not measured then: level, at rest, at the origin for that"
    return StartOfRun(place_ned, quaternion, nu), (f"{text}.",)


def _nearest(run: PoolRun, quantity: str, at_ns: int) -> FloatArray | None:
    for channel in run.channels.values():
        if channel.quantity != quantity:
            continue
        kept = channel.usable() & np.isfinite(channel.values).all(axis=1)
        away = np.abs(_own_time_ns(channel)[kept] - at_ns)
        if away.size and away.min() <= _NEAR_S * 1e9:
            return np.array(channel.values[kept][int(away.argmin())])
    return None


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:-1]) + " and " + names[-1] if len(names) > 1 else names[0]
