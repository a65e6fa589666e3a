"""A run flown again by the model with the same commands: over short windows, and as one free run.

Each window begins where the readings just before it say that the vehicle was; what follows is a
prediction from the commands alone. Windows lie end to end, so that all of the run but its first
moments is predicted once. The free run starts once and is never corrected: it shows what adds up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise, channel_noise, was_measured
from pipeline.identify.output_error import solve
from pipeline.identify.run_nuisance import run_nuisance
from pipeline.identify.window_derivatives import FitProblem
from pipeline.identify.window_outputs import stack_windows
from pipeline.identify.windows import Window, cut
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import actuator_states
from pipeline.simulate.fly import join
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory, run
from pipeline.simulate.vector_under import vector_under
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import Sensors

HORIZON_S = 10.0
#: The stretch that a start comes from is short where speed is measured: over a longer one a wrong
#: model has time to draw the start to where it would be itself. [s]
LEAD_S, BLIND_LEAD_S = 0.6, 2.5
#: A last window may be this short beyond its lead. [s]
SHORTEST_S = 1.0
#: Starts that are estimated together; more only make the equations larger.
_BATCH = 16
#: Beyond this speed a simulation has run away. [m/s, rad/s]
_FASTEST = 1e3


@dataclass(frozen=True)
class FlownWindows:
    """A simulated motion on the time base of a table, and where it holds.

    `trajectory` has a sample for each row of the table from `first_row` on; `valid` (its samples,)
    is False where nothing was simulated.
    """

    trajectory: Trajectory
    first_row: int
    valid: BoolArray


@dataclass(frozen=True)
class TrialFlights:
    """Both ways a run was flown again; `free` is None, with `why_no_free`, where it ran away.

    `windows` were predicted, `left_out` could not be: no readings before them, or a simulation that
    ran away. `first_rows` are the rows of the table at which the predictions begin.
    """

    windowed: FlownWindows
    free: FlownWindows | None
    why_no_free: str
    windows: int
    left_out: int
    first_rows: tuple[int, ...]
    horizon_s: float
    lead_s: float


def fly_trial(
    packed: PackedVehicle,
    sensors: Sensors,
    table: RunTable,
    *,
    horizon_s: float = HORIZON_S,
    lead_s: float | None = None,
    threads: int = 2,
) -> TrialFlights:
    """Fly the commands of a run again.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle as its file states it.
    sensors : Sensors
        Noise and mounting, for the estimates of the starts.
    table : RunTable
        The measured run, evenly spaced.
    horizon_s, lead_s : float
        Length of the predictions, and of the stretch before each that its start comes from;
        `LEAD_S`, or `BLIND_LEAD_S` without velocity and position. [s]
    threads : int
        Simulations at a time.

    Returns
    -------
    TrialFlights

    Raises
    ------
    CannotComputeError
        When the run has no commands, nothing that shows motion, or no window could be flown.
    """
    if not was_measured(table, "command"):
        raise CannotComputeError(f"{table.name}: the log has no commands to simulate.")
    channels = _channels_of_starts(sensors, table)
    if not channels:
        raise CannotComputeError(
            f"{table.name}: none of its channels shows how the vehicle moved, so there is nothing "
            "to start from and nothing to compare."
        )
    if lead_s is None:
        lead_s = LEAD_S if _shows_speed(table) else BLIND_LEAD_S
    period = float(np.median(np.diff(table.time_s))) if table.time_s.size > 2 else 1.0
    lead, ahead = round(lead_s / period), max(round(horizon_s / period), 1)
    places = _places(table, lead, ahead, max(round(SHORTEST_S / period), 1))
    if not places:
        raise CannotComputeError(
            f"{table.name}: its commands are too short; {lead_s + SHORTEST_S:g} s without a gap "
            "at least are needed."
        )
    actuator = actuator_states(packed, np.nan_to_num(table.values["command"]), period)
    found = [
        (begin, _with_thrusters(window, actuator[begin]))
        for begin, end in places
        if (window := _window(packed, table, channels, begin, end)) is not None
    ]
    starts = _starts(packed, [window for _, window in found], channels, lead, threads)
    states: list[tuple[int, Trajectory]] = []
    free: FlownWindows | None = None
    why_no_free = "no start could be estimated."
    for (begin, window), start in zip(found, starts, strict=True):
        if start is None:
            continue
        flown = _flown(packed, window, start)
        if flown is None:
            continue
        if free is None and not states:
            free, why_no_free = _free_run(packed, table, begin, start, lead)
        states.append((begin, flown))
    if not states:
        raise CannotComputeError(
            f"{table.name}: the model could not be flown over a single window of {horizon_s:g} s: "
            "no commands there, no readings before them, or it ran away. Check units and signs of "
            "the channels and the model: section."
        )
    return TrialFlights(
        _joined(states, table, lead),
        free,
        why_no_free if free is None else "",
        len(states),
        len(places) - len(states),
        tuple(begin + lead for begin, _ in states),
        horizon_s,
        lead_s,
    )


def _shows_speed(table: RunTable) -> bool:
    return was_measured(table, "velocity") or was_measured(table, "position")


def _channels_of_starts(sensors: Sensors, table: RunTable) -> tuple[ChannelNoise, ...]:
    """List what starts are estimated from.

    An acceleration tells a speed only through the model, and a wrong model tells a wrong speed: it
    is left out where speed shows otherwise.
    """
    found = channel_noise(sensors, [table])
    if not _shows_speed(table):
        return found
    return tuple(one for one in found if one.quantity != "specific_force")


def rows_of(table: RunTable, begin: int, end: int) -> RunTable:
    """Return the rows [begin, end) of a table as one of their own, times kept from 0."""
    part = slice(begin, end)
    known = table.known
    return replace(
        table,
        known=None if known is None else known.part(part, float(table.time_s[begin])),
        time_s=table.time_s[part] - table.time_s[begin],
        values={name: values[part] for name, values in table.values.items()},
        valid={name: valid[part] for name, valid in table.valid.items()},
        reading={name: marks[part] for name, marks in table.reading.items()},
        off_row={name: off.rows(part) for name, off in table.off_row.items()},
        start_time_ns=table.start_time_ns + round(1e9 * float(table.time_s[begin])),
    )


def _places(table: RunTable, lead: int, ahead: int, shortest: int) -> list[tuple[int, int]]:
    """First and last row of each window with its lead; a gap in the commands ends a row of them.

    What happens to the vehicle ends it, too: the next begins there.
    """
    known = table.valid["command"] & np.isfinite(table.values["command"]).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], known.astype(int), [0]])))
    places = []
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        inner = [row + 1 for row in table.changes if first < row < last - 1]
        for begin_at, end_at in pairwise([first, *inner, last]):
            # a row before which something changed is the last of one and the first of the next
            from_row = begin_at - 1 if begin_at in inner else begin_at
            places += [
                (begin, min(begin + lead + ahead, end_at - 1))
                for begin in range(from_row, end_at - lead - shortest, ahead)
            ]
    return places


def _window(
    packed: PackedVehicle, table: RunTable, channels: Sequence[ChannelNoise], begin: int, end: int
) -> Window | None:
    """Cut one window; None where it has no readings."""
    part = rows_of(table, begin, end + 1)
    try:
        (window, *_) = cut(packed, [part], channels, float(part.time_s[-1]))
    except CannotComputeError:
        return None
    return window if window.begin_s == 0.0 else None


def _with_thrusters(window: Window, actuator: FloatArray) -> Window:
    """Let the thrusters be where the commands before the window have brought them."""
    start = window.start.copy()
    start[BODY : BODY + actuator.size] = actuator
    return replace(window, start=start)


def _starts(
    packed: PackedVehicle,
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    lead: int,
    threads: int,
) -> list[FloatArray | None]:
    """Estimate where each window starts from the readings of its lead alone."""
    leads = [_lead(window, lead) for window in windows]
    found: list[FloatArray | None] = [None] * len(windows)
    usable = [number for number, window in enumerate(leads) if window.readings]
    for first in range(0, len(usable), _BATCH):
        batch = usable[first : first + _BATCH]
        for numbers in (batch, *([number] for number in batch)):
            # one window that runs away must not take its neighbours with it
            if found[numbers[0]] is not None:
                continue
            own = [replace(leads[number], run=place) for place, number in enumerate(numbers)]
            stack = stack_windows(packed, own, channels)
            shared = run_nuisance(stack, len(own), offsets=False)
            problem = FitProblem(stack, (), packed.vector, shared, threads)
            try:
                fitted = solve(problem, smallest_gain=0.5)
            except (CannotComputeError, np.linalg.LinAlgError):
                continue
            for number, start in zip(numbers, problem.starts(fitted.point.starts), strict=True):
                found[number] = start
            if len(numbers) == len(batch):
                break
    return found


def _lead(window: Window, lead: int) -> Window:
    """Keep the commands and readings of a window's lead."""
    readings = {}
    for quantity, found in window.readings.items():
        early = found.sample <= lead
        if early.any():
            readings[quantity] = found.part(early)
    outside = None if window.outside is None else window.outside[: lead + 1]
    return replace(window, command=window.command[: lead + 1], readings=readings, outside=outside)


def _flown(packed: PackedVehicle, window: Window, start: FloatArray) -> Trajectory | None:
    try:
        found = run(
            packed,
            window.command,
            dt_s=window.step_s,
            vector=vector_under(window.conditions, packed.vector),
            start=start,
            external=window.outside,
        )
    except CannotComputeError:
        return None
    return found if np.abs(found.nu).max() <= _FASTEST else None


def _free_run(
    packed: PackedVehicle, table: RunTable, begin: int, start: FloatArray, lead: int
) -> tuple[FlownWindows | None, str]:
    """Fly all of the run from one start; where commands are missing the last one holds.

    The cable pulls as it did along the measured motion, wherever the free run has got to.
    """
    command = table.values["command"][begin:]
    known = table.valid["command"][begin:] & np.isfinite(command).all(axis=1)
    last = np.maximum.accumulate(np.where(known, np.arange(len(command)), 0))
    period = float(np.median(np.diff(table.time_s)))
    held = np.nan_to_num(command[last])[:-1]
    bounds = [begin, *(row for row in table.changes if begin < row < begin + len(held))]
    pieces: list[Trajectory] = []
    try:
        for first, end in pairwise([*bounds, begin + len(held)]):
            at_s = float(table.time_s[first])
            pieces.append(
                run(
                    packed,
                    held[first - begin : end - begin],
                    dt_s=period,
                    vector=vector_under(table.conditions_at(at_s), packed.vector),
                    start=pieces[-1].final_state if pieces else start,
                    external=table.force_over(slice(first, end)),
                    start_time_s=at_s,
                )
            )
    except CannotComputeError as error:
        return None, str(error)
    found = join(pieces)
    fast = np.abs(found.nu).max(axis=1) > _FASTEST
    if fast.any():
        at_s = float(found.time_s[int(np.argmax(fast))])
        return None, f"the simulated vehicle ran away {at_s:.0f} s after the start of the run."
    valid = np.arange(len(command)) >= lead
    return FlownWindows(found, begin, valid), ""


def _joined(states: Sequence[tuple[int, Trajectory]], table: RunTable, lead: int) -> FlownWindows:
    """Lay the predicted parts of the windows end to end on the rows of the table."""
    rows = table.time_s.size
    one = states[0][1]
    count = one.command.shape[1]
    position, nu, nu_dot = np.zeros((rows, 3)), np.zeros((rows, 6)), np.zeros((rows, 6))
    quaternion = np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1))
    command, actuator, thrust = (np.zeros((rows, count)) for _ in range(3))
    valid = np.zeros(rows, bool)
    for begin, flown in states:
        length = flown.time_s.size
        into = slice(begin + lead, begin + length)
        for target, source in (
            (position, flown.position_ned_m),
            (quaternion, flown.quaternion),
            (nu, flown.nu),
            (nu_dot, flown.nu_dot),
            (command, flown.command),
            (actuator, flown.actuator),
            (thrust, flown.thrust_n),
        ):
            target[into] = source[lead:]
        valid[into] = True
    return FlownWindows(
        Trajectory(
            table.time_s,
            position,
            quaternion,
            nu,
            nu_dot,
            command,
            actuator,
            thrust,
            np.zeros(STATE),
        ),
        0,
        valid,
    )
