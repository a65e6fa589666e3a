"""Data from which no diagnosis can be made, and the plain reason."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import was_measured
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable

#: Less than this of usable time in all runs together tells nothing. [s]
SHORTEST_S = 30.0
_MOTION = ("angular_velocity", "attitude", "velocity", "position", "depth", "specific_force")
#: Codes below this share of the largest, all the time, are thrusters that are off.
_OFF = 0.01


def check_preconditions(case: Case) -> None:
    """Raise `CannotComputeError` where no diagnosis can be given; the text says why."""
    if not case.runs:
        raise CannotComputeError("no run was given; a diagnosis needs at least one")
    for run in case.runs:
        _refuse_run(case, run)
    seconds = sum(float(run.time_s[-1] - run.time_s[0]) for run in case.runs if run.time_s.size)
    if seconds < SHORTEST_S:
        raise CannotComputeError(
            f"the runs last {seconds:.0f} s in all, and a diagnosis needs at least "
            f"{SHORTEST_S:.0f} s. Give longer runs, or more of them."
        )
    _refuse_quiet(case, case.runs)


def _refuse_run(case: Case, run: RunTable) -> None:
    count = len(case.packed.thruster_names)
    if run.time_s.size < 3:
        raise CannotComputeError(f"{run.name}: the run holds no time to speak of")
    if not was_measured(run, "command"):
        raise CannotComputeError(
            f"{run.name}: no commands of the thrusters were recorded, so there is nothing to "
            "simulate. Map their topic in the vehicle file: under pool: channels:, quantity "
            "thruster_command."
        )
    columns = run.values["command"].shape[1]
    if columns != count:
        raise CannotComputeError(
            f"{run.name}: the run has commands of {columns} thrusters and {case.name} has {count}. "
            "This looks like the wrong vehicle file."
        )
    if not any(was_measured(run, quantity) for quantity in _MOTION):
        raise CannotComputeError(
            f"{run.name}: none of the motion was measured (" + ", ".join(_MOTION) + ")"
        )
    for quantity in _MOTION:
        if not was_measured(run, quantity):
            continue
        values = run.values[quantity][run.valid[quantity]]
        if len(values) > 50 and np.ptp(values, axis=0).max() == 0.0:
            raise CannotComputeError(
                f"{run.name}: {quantity} is the same from the first reading to the last. The "
                "sensor is frozen, or its topic is mapped wrongly; leave the run out, or unmap "
                "the channel."
            )
    limits = case.packed.code_limits
    command = np.nan_to_num(run.values["command"][run.valid["command"]])
    over = (command > 1.05 * limits[:, 1] + 1) | (command < 1.05 * limits[:, 0] - 1)
    if over.mean() > 0.01:
        worst = int(np.argmax(over.mean(axis=0)))
        raise CannotComputeError(
            f"{run.name}: codes of {case.packed.thruster_names[worst]} reach "
            f"{np.abs(command[:, worst]).max():g}, and the vehicle file has codes from "
            f"{limits[worst, 0]:g} to {limits[worst, 1]:g}. This looks like the wrong vehicle "
            "file, or a command in another unit."
        )


def _refuse_quiet(case: Case, runs: Sequence[RunTable]) -> None:
    count = len(case.packed.thruster_names)
    largest = read(case.packed.vector, "code_max")[:count]
    level = max(
        float(np.max(np.abs(np.nan_to_num(run.values["command"])) / largest)) for run in runs
    )
    if level < _OFF:
        raise CannotComputeError(
            "all thrusters were off in all runs: what the vehicle does then says nothing of "
            "thrusters, damping or added mass. Give runs in which it is driven."
        )
    moved = max(
        float(np.ptp(np.nan_to_num(run.values["command"]), axis=0).max() / largest.max())
        for run in runs
    )
    if moved < _OFF:
        raise CannotComputeError(
            "the commands never change in any run: nothing was excited, and causes cannot be told "
            "apart. Give runs with steps or turns."
        )
