"""What the model says the sensors would read in each window, and how far off the readings are.

All windows are simulated apart, each from its own start; their samples lie one after another in
one array, so that every channel is computed once for all windows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import solve_triangular
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.identify.windows import ChannelNoise, Window
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import run
from pipeline.types import BoolArray, FloatArray, IntArray

DOWN = np.array([0.0, 0.0, 1.0])
#: Quantities whose constant offset is estimated, one a run.
BIASED = ("angular_velocity", "specific_force")


@dataclass(frozen=True)
class Rows:
    """The readings of one channel over all windows.

    `sample` (k,) index into the stacked samples, `window` (k,), `measured` (k, c), `blocks` one
    (slice, factor) a window: the factor's inverse makes its noise white with unit variance.
    """

    channel: ChannelNoise
    sample: IntArray
    window: IntArray
    measured: FloatArray
    blocks: tuple[tuple[slice, FloatArray | float], ...]


@dataclass(frozen=True)
class Stack:
    """Windows ready to be simulated together; `scale` widens a channel's noise by its quantity."""

    packed: PackedVehicle
    windows: tuple[Window, ...]
    rows: tuple[Rows, ...]
    order: IntArray
    bounds: IntArray
    owner: IntArray
    """(all residuals,): index of the channel in `rows`, in the order of the residuals."""
    scale: dict[str, float] = field(default_factory=dict)

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
) -> Stack:
    """Prepare windows for `residuals`.

    `scale` multiplies the stated noise of a quantity, where residuals have shown it to be larger.
    """
    factors = scale or {}
    offsets = np.concatenate([[0], np.cumsum([len(w.command) + 1 for w in windows])])
    rows, owner_window, owner_channel = [], [], []
    for channel in channels:
        samples, numbers, values, blocks, begin = [], [], [], [], 0
        shared: dict[bytes, FloatArray] = {}
        for number, window in enumerate(windows):
            if channel.quantity not in window.readings:
                continue
            index, measured = window.readings[channel.quantity]
            samples.append(offsets[number] + index)
            numbers.append(np.full(index.size, number))
            values.append(measured)
            factor = _noise_factor(channel, index * window.step_s, shared)
            blocks.append(
                (
                    slice(begin, begin + index.size),
                    factor * factors.get(channel.quantity, 1.0),
                )
            )
            begin += index.size
        if not samples:
            continue
        rows.append(
            Rows(
                channel,
                np.concatenate(samples),
                np.concatenate(numbers),
                np.concatenate(values),
                tuple(blocks),
            )
        )
        width = 3 if channel.quantity == "attitude" else rows[-1].measured.shape[1]
        owner_window.append(np.repeat(rows[-1].window, width))
        owner_channel.append(np.full(owner_window[-1].size, len(rows) - 1))
    windows_of_rows = np.concatenate(owner_window)
    order = np.argsort(windows_of_rows, kind="stable")
    bounds = np.searchsorted(windows_of_rows[order], np.arange(len(windows) + 1))
    return Stack(
        packed,
        tuple(windows),
        tuple(rows),
        order,
        bounds,
        np.concatenate(owner_channel)[order],
        dict(factors),
    )


def _noise_factor(
    channel: ChannelNoise, time_s: FloatArray, shared: dict[bytes, FloatArray]
) -> FloatArray | float:
    """Standard deviation, or the Cholesky factor of white noise plus a first-order wander."""
    if channel.wander <= 0.0:
        return channel.white
    key = np.round(time_s - time_s[0], 6).tobytes()
    if key not in shared:
        apart = np.abs(time_s[:, None] - time_s[None, :])
        covariance = channel.wander**2 * np.exp(-apart / channel.wander_s)
        covariance[np.diag_indices(time_s.size)] += channel.white**2
        shared[key] = np.linalg.cholesky(covariance)
    return shared[key]


def simulate_windows(
    stack: Stack, vector: FloatArray, starts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Stacked states (samples, 13) and accelerations (samples, 6) of all windows.

    A window whose simulation leaves the finite numbers holds NaN from its start.
    """
    states, rates = [], []
    for window, start in zip(stack.windows, starts, strict=True):
        try:
            trajectory = run(
                stack.packed, window.command, dt_s=window.step_s, vector=vector, start=start
            )
        except CannotComputeError:
            count = len(window.command) + 1
            states.append(np.full((count, 13), np.nan))
            rates.append(np.full((count, 6), np.nan))
            continue
        states.append(
            np.concatenate(
                [trajectory.position_ned_m, trajectory.quaternion, trajectory.nu], axis=1
            )
        )
        rates.append(trajectory.nu_dot)
    return np.concatenate(states), np.concatenate(rates)


def innovations(
    stack: Stack, vector: FloatArray, starts: FloatArray, biases: FloatArray
) -> list[FloatArray]:
    """Measured minus predicted, one (k, c) a channel in its unit; attitude as a body rotation.

    Parameters
    ----------
    stack : Stack
        Windows.
    vector : ndarray
        Parameter vector.
    starts : ndarray, shape (windows, STATE)
        First states.
    biases : ndarray, shape (runs, 6)
        Offsets of angular velocity [rad/s] and specific force [m/s^2].
    """
    state, rate = simulate_windows(stack, vector, starts)
    gravity = stack.packed.context.gravity_mps2
    run_of = np.array([window.run for window in stack.windows])
    found = []
    for rows in stack.rows:
        x, x_dot = state[rows.sample], rate[rows.sample]
        place = np.array(rows.channel.place_m)
        found.append(
            rows.measured - _predicted(rows.channel.quantity, x, x_dot, place, gravity)
            if rows.channel.quantity != "attitude"
            else _turn_between(x[:, 3:7], rows.measured)
        )
        if rows.channel.quantity in BIASED:
            first = 3 * BIASED.index(rows.channel.quantity)
            found[-1] = found[-1] - biases[run_of[rows.window], first : first + 3]
    return found


def _predicted(
    quantity: str, x: FloatArray, x_dot: FloatArray, place: FloatArray, gravity: float
) -> FloatArray:
    velocity, omega = x[:, 7:10], x[:, 10:13]
    if quantity == "angular_velocity":
        return omega
    if quantity == "velocity":
        return np.asarray(velocity + np.cross(omega, place))
    if quantity == "position":
        return x[:, 0:3]
    # the down axis in body coordinates: last row of the rotation matrix
    w, i, j, k = x[:, 3], x[:, 4], x[:, 5], x[:, 6]
    down = np.stack([2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)], axis=1)
    if quantity == "depth":
        return np.asarray(x[:, 2:3] + down @ place[:, None])
    return np.asarray(
        x_dot[:, :3]
        + np.cross(omega, velocity)
        + np.cross(x_dot[:, 3:], place)
        + np.cross(omega, np.cross(omega, place))
        - gravity * down
    )


def _turn_between(predicted: FloatArray, measured: FloatArray) -> FloatArray:
    """Rotation vector (k, 3) in body axes from the predicted to the measured attitude."""
    if np.isnan(predicted).any():
        return np.full((len(predicted), 3), np.nan)
    inverse = Rotation.from_quat(predicted[:, [1, 2, 3, 0]]).inv()
    return np.asarray((inverse * Rotation.from_quat(measured[:, [1, 2, 3, 0]])).as_rotvec())


def whitened(stack: Stack, raw: Sequence[FloatArray]) -> FloatArray:
    """One vector of unit-variance residuals, window after window, from `innovations`."""
    parts = []
    for rows, values in zip(stack.rows, raw, strict=True):
        out = np.empty_like(values)
        for where, factor in rows.blocks:
            if isinstance(factor, float):
                out[where] = values[where] / factor
            else:
                out[where] = solve_triangular(
                    factor, values[where], lower=True, check_finite=False
                )
        parts.append(out.ravel())
    return np.concatenate(parts)[stack.order]


def bias_columns(stack: Stack, scales: FloatArray, run_count: int) -> FloatArray:
    """Derivative of the whitened predictions by each run's offsets, (rows, 6 runs).

    `scales` (6,) are the prior standard deviations that an offset is counted in; columns of zero
    scale stay zero.
    """
    run_of = np.array([window.run for window in stack.windows])
    columns = []
    for number in range(run_count):
        for entry in range(6):
            raw = []
            for rows in stack.rows:
                width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
                values = np.zeros((rows.sample.size, width))
                if (
                    rows.channel.quantity in BIASED
                    and BIASED.index(rows.channel.quantity) == entry // 3
                ):
                    values[run_of[rows.window] == number, entry % 3] = scales[entry]
                raw.append(values)
            columns.append(whitened(stack, raw))
    return np.stack(columns, axis=1)


def observed_positions(stack: Stack) -> BoolArray:
    """Whether north, east, down show in the readings, (3,)."""
    quantities = {rows.channel.quantity for rows in stack.rows}
    plane = "position" in quantities
    return np.array([plane, plane, plane or "depth" in quantities])
