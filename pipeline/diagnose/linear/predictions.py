"""What every sensor would read in each window, measurement effects and outside forces included.

Two layouts of the same time: windows, each simulated through from its start, and the short pieces
that a window is made of, each simulated from where the motion is at its begin. Readings refer to
samples of windows; a piece knows which samples are its own.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.diagnose.linear.workers import Workers
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.window_outputs import (
    Lines,
    Rows,
    WindowStack,
    innovation,
    lines_of,
)
from pipeline.physics.carried_body import cross_matrix
from pipeline.physics.parameters import offset, read, slot
from pipeline.simulate.applied_wrench import actuator_states
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pieces import OF_DRIVES, Alike, Pieces, alike_pieces
from pipeline.types import FloatArray, IntArray

#: Slots that only the sensors read: the motion is as without them.
_SENSOR_SLOTS = ("dvl_scale", "dvl_rotation", "dvl_delay", "dvl_lever_arm")
#: Sets of drives whose states are kept: long runs of many thrusters fill the memory.
_DRIVES_KEPT = 12


@dataclass(frozen=True)
class Bench:
    """Windows with what is needed to predict their readings.

    `commands` per run (m, n) and `period_s` their period, for the drives' state at any time;
    `pieces` is the number of pieces of a window; `pulls` per window the force (steps, 6) that makes
    the model follow the measured motion. `drive_states` keeps what the commands lead to, of the
    sets of drives that were asked for last.
    """

    stack: WindowStack
    commands: tuple[FloatArray, ...]
    period_s: tuple[float, ...]
    mount: Rotation
    nominal_v: float | None
    water_track: bool
    pieces: int
    pulls: tuple[FloatArray, ...]
    workers: Workers = field(compare=False)
    drive_states: dict[bytes, list[FloatArray]] = field(default_factory=dict, compare=False)

    @property
    def window_count(self) -> int:
        """Number of windows."""
        return len(self.stack.windows)

    @property
    def whole(self) -> Pieces:
        """Every window as one stretch; rows are the stacked samples."""
        return self.stack.pieces

    @cached_property
    def cut(self) -> Pieces:
        """Every piece as a stretch."""
        begins = self.whole.bounds[:-1]
        inside = [
            begin + (len(w.command) * np.arange(self.pieces)) // self.pieces
            for begin, w in zip(begins, self.stack.windows, strict=True)
        ]
        bounds = np.concatenate([*inside, self.whole.bounds[-1:]])
        return Pieces(self.whole.commands, bounds, np.repeat(self.whole.steps_s, self.pieces))

    @cached_property
    def piece_of_sample(self) -> IntArray:
        """Piece (numbered through all windows) of every stacked sample (samples,)."""
        step = np.searchsorted(self.cut.bounds, np.arange(len(self.whole.commands)), "right") - 1
        found = np.empty(len(self.whole.commands) + self.window_count, int)
        for number, (a, b) in enumerate(
            zip(self.whole.bounds[:-1], self.whole.bounds[1:], strict=True)
        ):
            found[a + number : b + number] = step[a:b]
            found[b + number] = step[b - 1]
        return found

    @cached_property
    def cut_alike(self) -> tuple[Alike, ...]:
        """Pieces by what is known of their runs."""
        return alike_pieces(
            self.cut, [w.conditions for w in self.stack.windows for _ in range(self.pieces)]
        )

    @cached_property
    def lines(self) -> tuple[Lines, ...]:
        """Where the readings of each channel lie, each piece being simulated in one go."""
        return tuple(lines_of(rows, self.piece_of_sample) for rows in self.stack.rows)

    @cached_property
    def row_of_sample(self) -> IntArray:
        """Row among the pieces' results of every stacked sample (samples,)."""
        window = np.repeat(np.arange(self.window_count), np.diff(self.whole.bounds) + 1)
        step = np.arange(window.size) - window
        return np.asarray(step + self.piece_of_sample)

    @cached_property
    def start_of_piece(self) -> IntArray:
        """Stacked sample at which each piece begins (pieces,)."""
        window = np.repeat(np.arange(self.window_count), self.pieces)
        return np.asarray(self.cut.bounds[:-1] + window)

    @cached_property
    def load(self) -> FloatArray:
        """Load of the supply at every stacked sample (samples,): mean square of the commands."""
        packed = self.stack.packed
        largest = read(packed.vector, "code_max")[: len(packed.thruster_names)]
        held = [np.concatenate([w.command, w.command[-1:]]) for w in self.stack.windows]
        return np.asarray(np.mean((np.concatenate(held) / largest) ** 2, axis=1))


@dataclass(frozen=True)
class Motion:
    """Stacked states (samples, STATE) and accelerations (samples, 6)."""

    state: FloatArray
    rate: FloatArray


def same_motion(first: FloatArray, second: FloatArray) -> bool:
    """Whether two parameter vectors differ at most in what the sensors read."""
    differ = first != second
    for name in _SENSOR_SLOTS:
        begin = offset(name)
        differ[begin : begin + slot(name).size] = False
    return not differ.any()


def other_drives(first: FloatArray, second: FloatArray) -> bool:
    """Whether the drives of two vehicles are at other codes after the same commands."""
    return not np.array_equal(first[OF_DRIVES], second[OF_DRIVES])


def drives_at(bench: Bench, vector: FloatArray, samples: IntArray) -> FloatArray:
    """State of the drives at stacked samples (k, n)."""
    drives = vector[OF_DRIVES].tobytes()
    states = bench.drive_states.get(drives)
    if states is None:
        states = [
            actuator_states(bench.stack.packed, command, period, vector=vector)
            for command, period in zip(bench.commands, bench.period_s, strict=True)
        ]
        for oldest in list(bench.drive_states)[: 1 - _DRIVES_KEPT]:
            bench.drive_states.pop(oldest, None)
        bench.drive_states[drives] = states
    begins = bench.stack.begins
    numbers = np.searchsorted(begins, samples, "right") - 1
    found = []
    for sample, number in zip(samples, numbers, strict=True):
        window = bench.stack.windows[number]
        time_s = window.begin_s + (sample - begins[number]) * window.step_s
        own = states[window.run]
        found.append(own[min(round(time_s / bench.period_s[window.run]), len(own) - 1)])
    return np.array(found)


def outside_forces(bench: Bench, forces: FloatArray, pull: float) -> FloatArray:
    """Force at every step (steps, 6) from forces (windows, 6 pieces) and a share of the pull."""
    found = np.repeat(forces.reshape(-1, 6), np.diff(bench.cut.bounds), axis=0)
    if pull != 0.0:
        found = found + pull * np.concatenate(bench.pulls)
    return np.asarray(found)


def simulate_windows(
    bench: Bench, vector: FloatArray, starts: FloatArray, forces: FloatArray
) -> Motion:
    """Simulate all windows with forces from outside at every step (steps, 6) [N, N m]."""
    packed, count = bench.stack.packed, len(bench.stack.packed.thruster_names)
    begin = starts.copy()
    if other_drives(vector, packed.vector):
        begin[:, BODY : BODY + count] = drives_at(bench, vector, bench.stack.begins[:-1])
    return Motion(*bench.stack.flown(bench.whole, bench.stack.alike, vector, begin, forces))


def simulate_cut(
    bench: Bench, vector: FloatArray, starts: FloatArray, forces: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """States and accelerations of all pieces; arguments as of `simulate_windows`."""
    return bench.stack.flown(bench.cut, bench.cut_alike, vector, starts, forces)


def innovations(bench: Bench, vector: FloatArray, motion: Motion) -> list[FloatArray]:
    """Measured minus predicted, one (k, c) a channel in its unit; attitude as a body rotation."""
    stack = bench.stack
    gravity = stack.packed.context.gravity_mps2
    found = []
    for rows, lines in zip(stack.rows, bench.lines, strict=True):
        quantity = rows.channel.quantity
        if quantity == "velocity":
            found.append(rows.measured - _velocity(bench, vector, motion, rows, lines))
        elif quantity == "voltage":
            found.append(rows.measured - _voltage(bench, vector)[rows.sample])
        else:
            found.append(innovation(rows, lines, motion.state, motion.rate, gravity))
    return found


def _velocity(
    bench: Bench, vector: FloatArray, motion: Motion, rows: Rows, lines: Lines
) -> FloatArray:
    """Velocity that a DVL shows whose scale, mount, place and age may be wrong, body axes."""
    late = float(read(vector, "dvl_delay"))
    nu, turn = lines.at(motion.state[:, 7:13]), lines.at(motion.state[:, 3:7])
    if late != 0.0:
        step = np.array([w.step_s for w in bench.stack.windows])[rows.window]
        wanted, low = _shown_at(bench, rows, late)
        # before its start a window goes back as it began, for a short time
        share = np.clip((wanted - low)[:, None], -0.5 / step[:, None], 1.0 + 0.5 / step[:, None])
        nu = motion.state[low, 7:13] * (1 - share) + motion.state[low + 1, 7:13] * share
        turn = motion.state[low, 3:7]
    arm = np.array(rows.channel.place_m) + read(vector, "dvl_lever_arm")
    velocity = nu[:, :3] + nu[:, 3:] @ cross_matrix(arm)
    if bench.water_track and np.isfinite(turn).all():
        water = Rotation.from_quat(turn[:, [1, 2, 3, 0]]).inv().apply(read(vector, "current"))
        velocity = velocity - water
    rotation = read(vector, "dvl_rotation")
    if rotation.any():
        error = Rotation.from_euler("ZYX", rotation[::-1])
        velocity = (bench.mount * error.inv() * bench.mount.inv()).apply(velocity)
    return np.asarray(float(read(vector, "dvl_scale")) * velocity)


def shown_samples(bench: Bench, vector: FloatArray, rows: Rows) -> IntArray:
    """Return the samples of the motion (k,) that the readings of a channel show."""
    late = float(read(vector, "dvl_delay"))
    if rows.channel.quantity != "velocity" or late == 0.0:
        return rows.sample
    return _shown_at(bench, rows, late)[1]


def _shown_at(bench: Bench, rows: Rows, late: float) -> tuple[FloatArray, IntArray]:
    """Sample, as a fraction, that a late reading shows, and the one before it in its window."""
    window = rows.window
    step = np.array([w.step_s for w in bench.stack.windows])[window]
    begins = bench.stack.begins
    wanted = rows.sample + rows.late - late / step
    low = np.clip(np.floor(wanted).astype(int), begins[window], begins[window + 1] - 2)
    return wanted, low


def _voltage(bench: Bench, vector: FloatArray) -> FloatArray:
    """Supply voltage at every stacked sample (samples, 1)."""
    share = 1.0 - read(vector, "supply_drop") - read(vector, "load_drop") * bench.load
    return np.asarray((bench.nominal_v or 0.0) * share)[:, None]


def voltage_channel(nominal_v: float, noise_v: float, rate_hz: float) -> ChannelNoise:
    """Supply voltage as a channel; a floor of 0.2 % stands for what a healthy supply does."""
    return ChannelNoise(
        "voltage", "V", max(noise_v, 0.002 * nominal_v), rate_hz=rate_hz, bias=0.005 * nominal_v
    )
