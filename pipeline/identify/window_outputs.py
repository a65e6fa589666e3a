"""What the model says the sensors would read in each window, and how far off the readings are.

All windows are simulated apart, each from its own start; their samples lie one after another in
one array, so that every channel is computed once for all windows.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.windows import Window
from pipeline.physics.carried_body import cross_matrix
from pipeline.records.run_table import down_axis
from pipeline.simulate.kernel import RK4
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Pieces, largest_step_s, run_pieces
from pipeline.types import FloatArray, IntArray

#: Quantities whose constant offset is estimated, one a run: columns among a run's offsets.
OFFSETS = {"angular_velocity": slice(0, 3), "specific_force": slice(3, 6), "depth": slice(6, 7)}
OFFSET_COUNT = 7


@dataclass(frozen=True)
class Rows:
    """The readings of one channel over all windows.

    `sample` (k,) index into the stacked samples, `late` (k,) by how many steps the reading is later
    than that, `window` (k,), `measured` (k, c), `blocks` one (rows, whitener) a set of windows with
    the same sampling: rows (n, j) of n windows, and the number or matrix (j, j) that makes their
    noise white with unit variance.
    """

    channel: ChannelNoise
    sample: IntArray
    late: FloatArray
    window: IntArray
    measured: FloatArray
    blocks: tuple[tuple[IntArray, FloatArray | float], ...]


@dataclass(frozen=True)
class Lines:
    """Where the readings of a channel lie between samples.

    Of the way from `sample` (k,) to the one `beside` it (k,), each by a `share` (k, 1).
    """

    sample: IntArray
    beside: IntArray
    share: FloatArray

    @cached_property
    def _between(self) -> bool:
        return bool(self.share.any())

    def at(self, motion: FloatArray) -> FloatArray:
        """Take the motion (samples, n) at the times of the readings, (k, n)."""
        # rows of what lies together are taken twice as fast
        motion = np.ascontiguousarray(motion)
        here = motion.take(self.sample, axis=0)
        if self._between:
            way = motion.take(self.beside, axis=0)
            way -= here
            way *= self.share
            here += way
        return here


@dataclass(frozen=True)
class WindowStack:
    """Windows ready to be simulated together; `scale` widens a channel's noise by its quantity."""

    packed: PackedVehicle
    windows: tuple[Window, ...]
    rows: tuple[Rows, ...]
    order: IntArray
    bounds: IntArray
    owner: IntArray
    """(all residuals,): index of the channel in `rows`, in the order of the residuals."""
    scale: dict[str, float] = field(default_factory=dict)

    @classmethod
    def unread(cls, packed: PackedVehicle, windows: Sequence[Window]) -> "WindowStack":
        """Stack windows to be simulated, not compared with readings."""
        none = np.zeros(0, int)
        return cls(packed, tuple(windows), (), none, np.zeros(len(windows) + 1, int), none)

    def of(self, packed: PackedVehicle) -> "WindowStack":
        """Return the same windows, with what is worked out of them, for other thrust curves."""
        _ = self.pieces, self.lines, self.outside
        other = copy(self)
        other.__dict__["packed"] = packed
        return other

    @cached_property
    def lines(self) -> tuple[Lines, ...]:
        """Where the readings of each channel lie."""
        return tuple(lines_of(rows, self.begins) for rows in self.rows)

    @cached_property
    def begins(self) -> IntArray:
        """Stacked sample at which each window begins, and the end (windows + 1,)."""
        return np.cumsum([0, *(len(window.command) + 1 for window in self.windows)])

    def into_s(self, rows: Rows) -> FloatArray:
        """Return the times (k,) of the samples of a channel since their windows began [s]."""
        step_s = np.array([window.step_s for window in self.windows])
        return np.asarray((rows.sample - self.begins[rows.window]) * step_s[rows.window])

    @cached_property
    def pieces(self) -> Pieces:
        """Every window as one stretch; rows are the stacked samples."""
        windows = self.windows
        bounds = np.concatenate([[0], np.cumsum([len(w.command) for w in windows])])
        steps_s = np.array([w.step_s for w in windows])
        conditions = tuple(w.conditions for w in windows)
        return Pieces(np.concatenate([w.command for w in windows]), bounds, steps_s, conditions)

    @cached_property
    def outside(self) -> FloatArray:
        """Known force from outside at every step (steps, 6), the cables'."""
        none = ((np.zeros((len(w.command), 6)), w.outside) for w in self.windows)
        return np.concatenate([zero if known is None else known for zero, known in none])

    @property
    def starts(self) -> FloatArray:
        """Guessed first states (windows, STATE)."""
        return np.stack([window.start for window in self.windows])


def stack_windows(
    packed: PackedVehicle,
    windows: Sequence[Window],
    channels: Sequence[ChannelNoise],
    *,
    scale: dict[str, float] | None = None,
) -> WindowStack:
    """Prepare windows for `residuals`.

    `scale` multiplies the stated noise of a quantity, where residuals have shown it to be larger.
    """
    factors = scale or {}
    offsets = np.concatenate([[0], np.cumsum([len(w.command) + 1 for w in windows])])
    rows, owner_window, owner_channel = [], [], []
    for channel in channels:
        quantity, wider = channel.quantity, factors.get(channel.quantity, 1.0)
        own = [
            (k, w, w.readings[quantity]) for k, w in enumerate(windows) if quantity in w.readings
        ]
        if not own:
            continue
        bounds = np.cumsum([0, *(read.sample.size for _, _, read in own)])
        alike: dict[bytes, tuple[FloatArray, float, list[IntArray]]] = {}
        for (_, window, read), (begin, end) in zip(own, pairwise(bounds), strict=True):
            time_s = np.asarray(read.sample * window.step_s)
            key = np.round([*time_s, window.duration_s], 6).tobytes()
            group = alike.setdefault(key, (time_s, window.duration_s, []))
            group[2].append(np.arange(begin, end))
        rows.append(
            Rows(
                channel,
                np.concatenate([offsets[number] + read.sample for number, _, read in own]),
                np.concatenate([read.late_s / window.step_s for _, window, read in own]),
                np.repeat([number for number, _, _ in own], np.diff(bounds)),
                np.concatenate([read.values for _, _, read in own]),
                tuple(
                    (np.stack(members), _whitener(channel, time_s, duration_s) / wider)
                    for time_s, duration_s, members in alike.values()
                ),
            )
        )
        width = 3 if quantity == "attitude" else rows[-1].measured.shape[1]
        owner_window.append(np.repeat(rows[-1].window, width))
        owner_channel.append(np.full(owner_window[-1].size, len(rows) - 1))
    windows_of_rows = np.concatenate(owner_window)
    order = np.argsort(windows_of_rows, kind="stable")
    bounds = np.searchsorted(windows_of_rows[order], np.arange(len(windows) + 1))
    return WindowStack(
        packed,
        tuple(windows),
        tuple(rows),
        order,
        bounds,
        np.concatenate(owner_channel)[order],
        dict(factors),
    )


def _whitener(channel: ChannelNoise, time_s: FloatArray, duration_s: float) -> FloatArray | float:
    """Inverse of the standard deviation, or of the Cholesky factor of white noise plus wander.

    The wander's values at both ends of the window are unknowns of their own (`run_nuisance`); left
    is the bridge between them, of covariance 2 sinh(a / tau) sinh(b / tau) / sinh(T / tau) with a
    the earlier time counted from the begin and b the later one counted to the end.
    """
    if channel.wander <= 0.0:
        return 1.0 / channel.white
    tau = channel.wander_s
    early = np.minimum(time_s[:, None], time_s[None, :]) / tau
    late = (duration_s - np.maximum(time_s[:, None], time_s[None, :])) / tau
    whole = duration_s / tau
    # written with decaying exponentials, so that a long window does not overflow
    bridge = np.exp(early + late - whole) * np.expm1(-2 * early) * np.expm1(-2 * late)
    bridge /= -np.expm1(-2 * whole)
    covariance = channel.wander**2 * bridge
    covariance[np.diag_indices(time_s.size)] += channel.white**2
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


#: A window whose velocity exceeds this has run away. [m/s, rad/s]
_FASTEST = 1e3


def simulate_windows(
    stack: WindowStack, vector: FloatArray, starts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Stacked states (samples, STATE) and accelerations (samples, 6) of all windows.

    `vector` is that of all windows, or (windows, n) of each. A window whose simulation runs away
    holds NaN from its start.
    """
    pieces = stack.pieces
    states, rates, _ = run_pieces(stack.packed, pieces, vector, starts, stack.outside, RK4)
    size = np.abs(states[:, 7:13]).max(axis=1)
    lost = ~(np.maximum.reduceat(size, pieces.first_row) <= _FASTEST)
    lost |= pieces.steps_s > largest_step_s(stack.packed, np.atleast_2d(vector)[0])
    rows = np.repeat(lost, pieces.last_row - pieces.first_row + 1)
    states[rows], rates[rows] = np.nan, np.nan
    return states, rates


def innovations(stack: WindowStack, vector: FloatArray, starts: FloatArray) -> list[FloatArray]:
    """Measured minus predicted, one (k, c) a channel in its unit; attitude as a body rotation."""
    state, rate = simulate_windows(stack, vector, starts)
    gravity = stack.packed.context.gravity_mps2
    return [
        turn_between(lines.at(state[:, 3:7]), rows.measured)
        if rows.channel.quantity == "attitude"
        else rows.measured - predicted_reading(rows.channel, lines, state, rate, gravity)
        for rows, lines in zip(stack.rows, stack.lines, strict=True)
    ]


def lines_of(rows: Rows, begins: IntArray) -> Lines:
    """Find the lines on which readings lie: through two samples of their own window.

    `begins` (windows + 1,) are the samples at which the windows begin.
    """
    first, last = begins[rows.window], begins[rows.window + 1] - 1
    at = rows.sample + rows.late
    before = np.clip(np.floor(at).astype(int), first, np.maximum(last - 1, first))
    sample = np.where(rows.late == 0.0, rows.sample, before)
    return Lines(sample, np.minimum(sample + 1, last), (at - sample)[:, None])


def predicted_reading(
    channel: ChannelNoise, lines: Lines, state: FloatArray, rate: FloatArray, gravity: float
) -> FloatArray:
    """Return readings (k, c) from states (samples, 13 or more) and accelerations (samples, 6)."""
    quantity, place = channel.quantity, np.array(channel.place_m)
    if quantity == "angular_velocity":
        return lines.at(state[:, 10:13])
    if quantity == "position":
        return lines.at(state[:, 0:3])
    if quantity == "velocity":
        nu = lines.at(state[:, 7:13])
        return np.asarray(nu[:, :3] + nu[:, 3:] @ cross_matrix(place))
    down = down_axis(lines.at(state[:, 3:7]))
    if quantity == "depth":
        return np.asarray(lines.at(state[:, 2:3]) + down @ place[:, None])
    nu, nu_dot = lines.at(state[:, 7:13]), lines.at(rate)
    velocity = nu[:, :3] + nu[:, 3:] @ cross_matrix(place)
    found = nu_dot[:, :3] + nu_dot[:, 3:] @ cross_matrix(place)
    for axis, (b, c) in enumerate(((1, 2), (2, 0), (0, 1))):
        # the general cross product takes four times as long
        found[:, axis] += nu[:, 3 + b] * velocity[:, c] - nu[:, 3 + c] * velocity[:, b]
    found -= gravity * down
    return found


def turn_between(predicted: FloatArray, measured: FloatArray) -> FloatArray:
    """Rotation vector (k, 3) in body axes from the predicted to the measured attitude (k, 4).

    Quaternions (w, x, y, z) of any length above zero; a row that is not finite stays so.
    """
    # conj(p) m, by components: a third of the time of a general rotation library
    (w0, x0, y0, z0), (w1, x1, y1, z1) = predicted.T, measured.T
    w = w0 * w1 + x0 * x1 + y0 * y1 + z0 * z1
    turn = np.empty((len(predicted), 3))
    turn[:, 0] = w0 * x1 - x0 * w1 - y0 * z1 + z0 * y1
    turn[:, 1] = w0 * y1 - y0 * w1 - z0 * x1 + x0 * z1
    turn[:, 2] = w0 * z1 - z0 * w1 - x0 * y1 + y0 * x1
    side = np.where(w < 0.0, -1.0, 1.0)
    sine = np.sqrt(np.einsum("ij,ij->i", turn, turn))
    angle = 2.0 * np.arctan2(sine, side * w)
    small = sine < 1e-12 * np.abs(w)
    factor = np.where(
        small, 2.0 / np.where(small, side * w, 1.0), angle / np.where(small, 1.0, sine)
    )
    return np.asarray(turn * (side * factor)[:, None])


def whitened(stack: WindowStack, raw: Sequence[FloatArray]) -> FloatArray:
    """One vector of unit-variance residuals, window after window, from `innovations`."""
    parts = []
    for rows, values in zip(stack.rows, raw, strict=True):
        out = np.empty_like(values)
        for members, whitener in rows.blocks:
            if isinstance(whitener, float):
                out[members] = values[members] * whitener
            else:
                # einsum, not matmul: BLAS would start threads of its own for these small products
                out[members] = np.einsum("ij,njc->nic", whitener, values[members])
        parts.append(out.ravel())
    return np.concatenate(parts)[stack.order]
