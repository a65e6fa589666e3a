"""Simulate the commands of a log."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.ingest.run_commands import RunCommands
from pipeline.inputs.simulated_vehicle import SimulatedVehicle
from pipeline.records.run_table import mean_held
from pipeline.simulate.events import PayloadSchedule
from pipeline.simulate.fly import run_changing
from pipeline.simulate.run import Mover, Trajectory, initial_state, run
from pipeline.types import FloatArray

#: A longer run is not simulated at a time. [s]
LONGEST_S = 3600.0


def replay(
    one: SimulatedVehicle,
    log: RunCommands,
    true: FloatArray,
    step_s: float,
    schedule: PayloadSchedule | None = None,
    *,
    mover: Mover = run,
) -> tuple[Trajectory, list[str]]:
    """Simulate the commands of a log, each held until the next.

    Thrusters are matched by name; `true` is the parameter vector that is simulated. Returns the
    run, and sentences on what had to be assumed.

    Raises
    ------
    CannotComputeError
        When the log lacks a thruster of the vehicle, or the run is too long.
    """
    missing = [name for name in one.packed.thruster_names if name not in log.names]
    if missing:
        raise CannotComputeError(
            f"the log has no commands for {', '.join(missing)} of {one.name}; it has "
            f"{', '.join(log.names)}"
        )
    if log.end_s > LONGEST_S:
        raise CannotComputeError(
            f"the log is {log.end_s:.0f} s long; at most {LONGEST_S:.0f} s are simulated at a "
            "time.\nCut it, e.g. with mcap filter --start --end."
        )
    notes = _ignored(log.names, one.packed.thruster_names)
    state = initial_state()
    if log.start is None:
        notes.append("the log does not say how the vehicle started: taken at rest at the origin.")
    else:
        state[:3], state[3:7] = log.start.position_ned_m, log.start.quaternion
        state[7:13] = log.start.nu
    steps = max(round(log.end_s / step_s), 1)
    columns = [log.names.index(name) for name in one.packed.thruster_names]
    codes = mean_held(
        log.time_s, log.codes[:, columns], np.asarray(step_s * np.arange(steps), float), step_s
    )
    low, high = one.packed.code_limits.T
    beyond = np.logical_or(codes < low, codes > high).any(axis=0).tolist()
    if any(beyond):
        names = [name for name, out in zip(one.packed.thruster_names, beyond, strict=True) if out]
        notes.append(
            f"codes beyond the drive's range, of {', '.join(names)}, are simulated at its limits."
        )
        codes = np.clip(codes, low, high)
    times = () if schedule is None else schedule.times_s
    if schedule is None or not times:
        return mover(one.packed, codes, dt_s=step_s, vector=true, start=state), notes
    changed = run_changing(
        one.packed, codes, schedule.change, times, dt_s=step_s, start=state, mover=mover
    )
    return changed, notes


def _ignored(names: Sequence[str], known: Sequence[str]) -> list[str]:
    more = [name for name in names if name not in known]
    return [f"the log also commands {', '.join(more)}: left out."] if more else []
