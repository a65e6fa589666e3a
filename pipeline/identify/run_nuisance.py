r"""What a run's sensors add that lasts longer than a window: constant offsets and slow wander.

Offsets of angular velocity, specific force and depth are one number each a run. The wander of the
attitude is a first-order Gauss-Markov process: given its values at the ends of the windows, what
it does within one window is independent of all others (an Ornstein-Uhlenbeck bridge). So its values
there, the knots, are unknowns with the chain

.. math:: k_0 \sim N(0, 1), \qquad k_{i+1} = \phi k_i + N(0, 1 - \phi^2), \qquad
    \phi = e^{-\Delta t / \tau}

as their prior, in units of its standard deviation, and the noise of a window is white plus the
bridge. Both together are the covariance of the whole run, exactly, and windows stay apart.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.window_outputs import OFFSET_COUNT, OFFSETS, WindowStack, whitened
from pipeline.types import FloatArray, IntArray

#: A window's own columns: the run's offsets, then three axes of the knot at its begin and its end.
_KNOT_COLUMNS = 6


@dataclass(frozen=True)
class RunNuisance:
    """The unknowns that the windows of a run share, counted in prior standard deviations.

    `index` (windows, l) says which of them a window has, `columns` (rows, l) the derivative of its
    whitened predictions; `precision` (s, s) is that of their prior. The first OFFSET_COUNT runs
    entries are the offsets, run by run.
    """

    precision: FloatArray
    index: IntArray
    columns: FloatArray
    window: IntArray
    scales: FloatArray
    """Prior standard deviations of a run's offsets (OFFSET_COUNT,)."""
    run_count: int

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.precision)

    def offsets(self, values: FloatArray) -> FloatArray:
        """Offsets (runs, OFFSET_COUNT) in their units from values (s,)."""
        count = OFFSET_COUNT * self.run_count
        return np.asarray(values[:count].reshape(self.run_count, OFFSET_COUNT) * self.scales)

    def whitened(self, values: FloatArray) -> FloatArray:
        """Return what values (s,) add to the whitened predictions, (rows,)."""
        own = values[self.index][self.window]
        return np.asarray(np.einsum("rk,rk->r", self.columns, own))

    def cost(self, values: FloatArray) -> float:
        """Return the prior's share of the cost."""
        return float(values @ self.precision @ values)


def run_nuisance(stack: WindowStack, run_count: int, *, offsets: bool = True) -> RunNuisance:
    """Set up the shared unknowns of a stack; `offsets` False leaves the constant ones at zero."""
    channels = [rows.channel for rows in stack.rows]
    scales = np.zeros(OFFSET_COUNT)
    for channel in channels if offsets else ():
        if channel.quantity in OFFSETS:
            scales[OFFSETS[channel.quantity]] = channel.bias
    attitude = next((c for c in channels if c.quantity == "attitude" and c.wander > 0), None)
    fixed = OFFSET_COUNT * run_count
    run_of = np.array([window.run for window in stack.windows])
    index = OFFSET_COUNT * run_of[:, None] + np.arange(OFFSET_COUNT)
    chains = [np.eye(fixed)]
    if attitude is not None:
        knots, chains_of_knots = _knots(stack, run_count, attitude.wander_s)
        index = np.concatenate([index, fixed + knots], axis=1)
        chains += chains_of_knots
    return RunNuisance(
        np.asarray(block_diag(*chains)),
        index,
        _columns(stack, scales, attitude),
        np.repeat(np.arange(len(stack.windows)), np.diff(stack.bounds)),
        scales,
        run_count,
    )


def _knots(
    stack: WindowStack, run_count: int, wander_s: float
) -> tuple[IntArray, list[FloatArray]]:
    """Position of each window's knots (windows, 6), and the chains' precisions, axis by axis."""
    position = np.zeros((len(stack.windows), _KNOT_COLUMNS), int)
    chains, begin = [], 0
    for number in range(run_count):
        own = [k for k, window in enumerate(stack.windows) if window.run == number]
        if not own:
            continue
        ends = [(round(stack.windows[k].begin_s, 6), round(_end(stack, k), 6)) for k in own]
        times, place = np.unique(np.array(ends), return_inverse=True)
        place = place.reshape(-1, 2)
        chain = chain_precision(times, wander_s)
        for axis in range(3):
            position[own, 2 * axis : 2 * axis + 2] = begin + place
            chains.append(chain)
            begin += times.size
    return position, chains


def _end(stack: WindowStack, number: int) -> float:
    window = stack.windows[number]
    return window.begin_s + window.duration_s


def chain_precision(time_s: FloatArray, wander_s: float) -> FloatArray:
    """Precision (k, k) of a first-order Gauss-Markov process of unit variance at times (k,)."""
    keep = np.exp(-np.diff(time_s) / wander_s)
    left = 1.0 - keep**2
    precision = np.zeros((time_s.size, time_s.size))
    precision[0, 0] = 1.0
    for k, (phi, variance) in enumerate(zip(keep, left, strict=True)):
        pair = np.array([[phi**2, -phi], [-phi, 1.0]]) / variance
        precision[k : k + 2, k : k + 2] += pair
    return precision


def bridge_weights(
    time_s: FloatArray, duration_s: FloatArray | float, wander_s: float
) -> tuple[FloatArray, FloatArray]:
    """Weights (k,) of the values at 0 and at `duration_s` in the mean of the bridge between."""
    whole = duration_s / wander_s

    def share(x: FloatArray) -> FloatArray:
        # sinh x / sinh whole, written so that a long window does not overflow
        return np.asarray(np.exp(x - whole) * np.expm1(-2 * x) / np.expm1(-2 * whole))

    return share(whole - time_s / wander_s), share(time_s / wander_s)


def _columns(stack: WindowStack, scales: FloatArray, attitude: ChannelNoise | None) -> FloatArray:
    found = []
    for column in range(OFFSET_COUNT + (_KNOT_COLUMNS if attitude is not None else 0)):
        raw = []
        for rows in stack.rows:
            quantity = rows.channel.quantity
            width = 3 if quantity == "attitude" else rows.measured.shape[1]
            values = np.zeros((rows.sample.size, width))
            own = OFFSETS.get(quantity, slice(0, 0))
            if own.start <= column < own.stop:
                values[:, column - own.start] = scales[column]
            if quantity == "attitude" and attitude is not None and column >= OFFSET_COUNT:
                axis, end = divmod(column - OFFSET_COUNT, 2)
                size = attitude.wander * stack.scale.get("attitude", 1.0)
                whole_s = np.array([w.duration_s for w in stack.windows])[rows.window]
                weights = bridge_weights(stack.into_s(rows), whole_s, attitude.wander_s)
                values[:, axis] = size * weights[end]
            raw.append(values)
        found.append(whitened(stack, raw))
    return np.stack(found, axis=1)
