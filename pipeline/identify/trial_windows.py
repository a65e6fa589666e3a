"""A run flown again by the model with the same commands, over short windows.

Each window begins where the readings just before it say that the vehicle was; what follows is a
prediction from the commands alone. Windows lie end to end, so that all of the run but its first
moments is predicted once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import channel_noise, was_measured
from pipeline.identify.window_outputs import WindowStack, simulate_windows
from pipeline.identify.window_prediction import lead_starts
from pipeline.identify.windows import SHORTEST_BEYOND_LEAD_S, Window, cut, window_rows
from pipeline.records.run_table import RunTable
from pipeline.simulate.kernel import STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory, trajectory
from pipeline.types import BoolArray
from pipeline.vehicle.sensor_schema import Sensors

HORIZON_S = 10.0
#: The stretch that a start comes from is short where speed is measured: over a longer one a wrong
#: model has time to draw the start to where it would be itself. [s]
LEAD_S, BLIND_LEAD_S = 0.6, 2.5


@dataclass(frozen=True)
class TrialFlights:
    """A run as it was flown again: a simulated motion on the time base of its table.

    `trajectory` has a sample for each row of the table; `valid` (rows,) is False where nothing was
    simulated. `windows` were predicted, `left_out` could not be: no readings before them, or a
    simulation that ran away. `first_rows` are the rows at which the predictions begin.
    """

    trajectory: Trajectory
    valid: BoolArray
    windows: int
    left_out: int
    first_rows: tuple[int, ...]
    horizon_s: float
    lead_s: float


def fly_trial(
    packed: PackedVehicle, sensors: Sensors, table: RunTable, *, threads: int = 2
) -> TrialFlights:
    """Fly the commands of a run again, over windows of `HORIZON_S`.

    Each window starts from the readings of the `LEAD_S` before it, or of `BLIND_LEAD_S` without
    velocity and position.

    `packed` and `sensors` are as the vehicle file states them, `threads` simulations at a time.

    Raises
    ------
    CannotComputeError
        When the run has no commands, nothing that shows motion, or no window could be flown.
    """
    if not was_measured(table, "command"):
        raise CannotComputeError(f"{table.name}: the log has no commands to simulate.")
    shows_speed = was_measured(table, "velocity") or was_measured(table, "position")
    channels = channel_noise(sensors, [table])
    if shows_speed:
        # an acceleration tells a speed only through the model, and a wrong model a wrong speed
        channels = tuple(one for one in channels if one.quantity != "specific_force")
    if not channels:
        raise CannotComputeError(
            f"{table.name}: none of its channels shows how the vehicle moved, so there is nothing "
            "to start from and nothing to compare."
        )
    lead_s = LEAD_S if shows_speed else BLIND_LEAD_S
    places = window_rows(table, HORIZON_S, lead_s) if table.time_s.size > 2 else []
    if not places:
        raise CannotComputeError(
            f"{table.name}: its commands are too short; {lead_s + SHORTEST_BEYOND_LEAD_S:g} s "
            "without a gap at least are needed."
        )
    period = table.period_s
    lead = round(lead_s / period)
    try:
        windows = cut(packed, [table], channels, HORIZON_S, lead_s=lead_s)
    except CannotComputeError:
        windows = []
    model = (packed, packed.vector)
    # ten seconds on the attitude has wandered off: each lead tells of itself alone
    alone = [replace(window, run=number) for number, window in enumerate(windows)]
    starts = lead_starts(model, alone, channels, [lead] * len(alone), threads=threads)
    started = [
        replace(window, start=start)
        for window, start in zip(windows, starts, strict=True)
        if np.isfinite(start).all()
    ]
    flown, motion, valid = _flown(packed, started, table, lead)
    if not flown:
        raise CannotComputeError(
            f"{table.name}: the model could not be flown over a single window of {HORIZON_S:g} s: "
            "no commands there, no readings before them, or it ran away. Check units and signs of "
            "the channels and the model: section."
        )
    begins = [int(np.searchsorted(table.time_s, one.begin_s - 1e-9)) for one in flown]
    return TrialFlights(
        motion,
        valid,
        len(begins),
        len(places) - len(begins),
        tuple(begin + lead for begin in begins),
        HORIZON_S,
        lead_s,
    )


def _flown(
    packed: PackedVehicle, windows: Sequence[Window], table: RunTable, lead: int
) -> tuple[list[Window], Trajectory, BoolArray]:
    """Fly windows, and lay what lies beyond their leads end to end on the rows of the table.

    First come those that did not run away, last where there is something.
    """
    rows, count = table.time_s.size, len(packed.thruster_names)
    state, rate, valid = np.zeros((rows, STATE)), np.zeros((rows, 6)), np.zeros(rows, bool)
    state[:, 3] = 1.0
    command = np.zeros((rows, count))
    kept = []
    if windows:
        stack = WindowStack.unread(packed, windows)
        states, rates = simulate_windows(stack, packed.vector, stack.starts)
        for window, first in zip(windows, stack.pieces.first_row.tolist(), strict=True):
            steps = len(window.command)
            if not np.isfinite(states[first]).all():
                continue
            begin = int(np.searchsorted(table.time_s, window.begin_s - 1e-9))
            into = slice(begin + lead, begin + steps + 1)
            own = slice(first + lead, first + steps + 1)
            state[into], rate[into], valid[into] = states[own], rates[own], True
            command[into] = np.concatenate([window.command, window.command[-1:]])[lead:]
            kept.append(window)
    nothing = np.zeros((rows, count))  # no sensor reads the thrust
    flown = trajectory(
        packed, command[:-1], state, rate, nothing, table.period_s, float(table.time_s[0])
    )
    return kept, flown, valid
