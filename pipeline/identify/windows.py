"""Cut runs into windows for the output-error fit: commands, readings, where each window starts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import QUANTITIES, ChannelNoise, was_measured
from pipeline.records.run_table import AS_STATED, Conditions, RunTable, stretches
from pipeline.simulate.applied_wrench import actuator_states
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray, IntArray

#: The kernel is not run finer than this; a finer table is thinned. [s]
SHORTEST_STEP_S = 0.02
#: Readings used of each channel, at most, per second.
FASTEST_HZ = 12.5
#: A window that has less than this share of a channel's usual readings goes without the channel.
SMALLEST_SHARE = 0.3
#: A last window with a lead may be this short beyond it. [s]
SHORTEST_BEYOND_LEAD_S = 1.0
#: A position surer than this shows a speed: over so long, and so many readings. [m], [s]
SURE_M, SLOPE_S, SLOPE_READINGS = 0.05, 0.7, 5
WINDOW_S = 8.0
#: Without velocity, speed shows only in what it leads to: longer windows tell more of it.
WINDOW_WITHOUT_VELOCITY_S = 20.0


@dataclass(frozen=True)
class Readings:
    """Readings of one channel in a window.

    `sample` (k,) within the window nearest to each, `values` (k, c), and by how much the reading is
    later than the sample, `late_s` (k,).
    """

    sample: IntArray
    values: FloatArray
    late_s: FloatArray

    def part(self, kept: BoolArray) -> "Readings":
        """Return some of the readings."""
        return Readings(self.sample[kept], self.values[kept], self.late_s[kept])


@dataclass(frozen=True)
class Window:
    """A piece of a run.

    `command` (m, n) held for `step_s` each; `start` (STATE,) kernel state guessed from the
    measurements; `known` (6,) whether linear (0-2) and angular (3-5) velocity there was measured;
    `readings` by quantity. `conditions` turn a parameter vector of the vehicle into that of the
    window, and `outside` (m, 6) is a known force that acts at each step, the cable's [N, N m].
    """

    run: int
    begin_s: float
    step_s: float
    command: FloatArray
    start: FloatArray
    known: BoolArray
    readings: dict[str, Readings]
    conditions: Conditions = AS_STATED
    outside: FloatArray | None = None

    @property
    def duration_s(self) -> float:
        """Length of the window [s]."""
        return self.step_s * len(self.command)

    def lead(self, steps: int) -> "Window":
        """Return the first steps with the readings in them."""
        readings = {
            quantity: found.part(early)
            for quantity, found in self.readings.items()
            if (early := found.sample <= steps).any()
        }
        outside = None if self.outside is None else self.outside[:steps]
        return replace(self, command=self.command[:steps], readings=readings, outside=outside)


def cut(
    packed: PackedVehicle,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    window_s: float | None = None,
    *,
    vector: FloatArray | None = None,
    lead_s: float = 0.0,
) -> list[Window]:
    """Cut runs into consecutive windows; what happens to the vehicle in a run begins a new one.

    One that is less than half as long is left out; of those with a lead, one shorter than
    `SHORTEST_BEYOND_LEAD_S` beyond it.

    `packed`, or `vector` in place of its nominal one, gives the thrusters' state at each start.
    They are `window_s` long [s]: `WINDOW_S`, or `WINDOW_WITHOUT_VELOCITY_S` where no run has
    velocity; and by `lead_s` longer, overlapping the one before.

    Raises
    ------
    CannotComputeError
        If no run has commands, or nothing that was measured.
    """
    if window_s is None:
        has_velocity_or_position = any(
            was_measured(run, q) for run in runs for q in ("velocity", "position")
        )
        window_s = WINDOW_S if has_velocity_or_position else WINDOW_WITHOUT_VELOCITY_S
    found: list[Window] = []
    for number, run in enumerate(runs):
        if not was_measured(run, "command") or run.time_s.size < 3:
            continue
        period, stride = _steps_of(run)
        command = np.nan_to_num(run.values["command"])
        actuator = actuator_states(packed, command, period, vector=vector)[:-1]
        picks = {c.quantity: readings_of(run, c.quantity) for c in channels}
        for begin, end in window_rows(run, window_s, lead_s):
            readings = {}
            for channel in channels:
                index = picks[channel.quantity]
                inside = index[(index >= begin) & (index <= end)]
                usual = min(channel.rate_hz, FASTEST_HZ) * (end - begin) * period
                if inside.size >= max(SMALLEST_SHARE * usual, 1):
                    readings[channel.quantity] = _readings(run, channel.quantity, inside, begin)
            if not readings:
                continue
            start, known = _start(run, begin, end, channels)
            start[BODY : BODY + actuator.shape[1]] = actuator[begin]
            found.append(
                Window(
                    number,
                    float(run.time_s[begin]),
                    period * stride,
                    command[begin:end:stride],
                    start,
                    known,
                    readings,
                    run.conditions_at(float(run.time_s[begin])),
                    run.force_over(slice(begin, end, stride)),
                )
            )
    if not found:
        raise CannotComputeError(
            f"{', '.join(run.name for run in runs) or 'no run'}: no stretch of {window_s / 2:g} s "
            "with commands and at least one of "
            + ", ".join(QUANTITIES)
            + "; there is nothing to identify from"
        )
    return found


def _readings(run: RunTable, quantity: str, row: IntArray, begin: int) -> Readings:
    """Take the readings next to some rows of a table as samples of a window."""
    period_s, stride = _steps_of(run)
    sample = np.round((row - begin) / stride).astype(int)
    values = run.values[quantity][row]
    late_s = (row - begin - sample * stride) * period_s
    off = run.off_row.get(quantity)
    if off is not None:
        late_s = late_s + off.late_s[row]
        values = values + off.more[row]
    return Readings(sample, values, late_s)


def _steps_of(run: RunTable) -> tuple[float, int]:
    """Period of a table [s], and how many of its rows a step of the kernel takes."""
    period = run.period_s
    return period, max(int(np.floor(SHORTEST_STEP_S / period + 1e-6)), 1)


def window_rows(run: RunTable, window_s: float, lead_s: float = 0.0) -> list[tuple[int, int]]:
    """First and last sample of the windows of a run, stretch by stretch of commands; as `cut`.

    A gap in the commands ends a stretch, as a change of the vehicle does, and the next one begins
    with its own first window.
    """
    period, stride = _steps_of(run)
    length = max(round(window_s / (period * stride)), 2) * stride
    lead = round(lead_s / (period * stride)) * stride
    shortest = lead + round(SHORTEST_BEYOND_LEAD_S / period) if lead else length // 2
    known = run.trusted("command")
    found = []
    for first, last in stretches(known[:-1]):
        inner = [row for row in run.changes if first < row < last]
        for begin_at, end_at in pairwise([first, *inner, last]):
            for begin in range(begin_at, end_at, length):
                end = min(begin + lead + length, end_at)
                end -= (end - begin) % stride
                if end - begin >= shortest:
                    found.append((begin, end))
    return found


def readings_of(run: RunTable, quantity: str, fastest_hz: float = FASTEST_HZ) -> IntArray:
    """Find the samples of a table that hold a reading of their own, thinned to `fastest_hz`."""
    if quantity not in run.values:
        return np.zeros(0, int)
    valid = run.trusted(quantity)
    kept, last = [], -np.inf
    for i in np.flatnonzero(valid & run.reading.get(quantity, valid)):
        if run.time_s[i] - last >= 1.0 / fastest_hz - 0.25 * run.period_s:
            kept.append(i)
            last = run.time_s[i]
    return np.array(kept, int)


def _going_ned(run: RunTable, begin: int, end: int, rate_hz: float) -> FloatArray:
    """Slope of the first positions of a window (3,); zero where one is missing. [m/s]."""
    length_s = max(SLOPE_S, SLOPE_READINGS / rate_hz)
    rows = np.arange(begin, min(begin + round(length_s / run.period_s), end) + 1)
    if rows.size < 2 or "position" not in run.values or not run.trusted("position")[rows].all():
        return np.zeros(3)
    return np.asarray(np.polyfit(run.time_s[rows], run.values["position"][rows], 1)[0])


def _start(
    run: RunTable, begin: int, end: int, channels: Sequence[ChannelNoise]
) -> tuple[FloatArray, BoolArray]:
    """Guess a window's first state from the first trusted sample of every channel."""
    state, known = np.zeros(STATE), np.zeros(6, bool)
    state[3] = 1.0
    place = {c.quantity: np.array(c.place_m) for c in channels}
    sure = [c.rate_hz for c in channels if c.quantity == "position" and c.white <= SURE_M]

    def first(quantity: str) -> FloatArray | None:
        if quantity not in run.values:
            return None
        trusted = np.flatnonzero(run.trusted(quantity)[begin : end + 1])
        return run.values[quantity][begin + trusted[0]] if trusted.size else None

    attitude, rate, velocity = first("attitude"), first("angular_velocity"), first("velocity")
    depth, position, force = first("depth"), first("position"), first("specific_force")
    if attitude is not None:
        state[3:7] = attitude / np.linalg.norm(attitude)
    elif force is not None:
        # the accelerometer at rest shows where up is
        roll, pitch = np.arctan2(-force[1], -force[2]), np.arctan2(force[0], np.hypot(*force[1:]))
        x, y, z, w = Rotation.from_euler("ZYX", [0.0, pitch, roll]).as_quat()
        state[3:7] = (w, x, y, z)
    if rate is not None:
        state[10:13], known[3:] = rate, True
    if velocity is not None:
        state[7:10] = velocity - np.cross(state[10:13], place["velocity"])
        known[:3] = True
    elif sure and attitude is not None:
        # no measurement of its own
        turn = Rotation.from_quat(state[[4, 5, 6, 3]])
        state[7:10] = turn.inv().apply(_going_ned(run, begin, end, sure[0]))
    if position is not None:
        state[0:3] = position
    if depth is not None:
        turn = Rotation.from_quat(state[[4, 5, 6, 3]])
        state[2] = depth[0] - turn.apply(place["depth"])[2]
    return state, known
