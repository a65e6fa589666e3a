"""The slow motion and the commands of a run, as manoeuvre detection looks at them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.records.run_table import RunTable, angles
from pipeline.types import BoolArray, FloatArray

#: Everything is looked at on this time base. [s]
PERIOD_S = 0.1
_SMOOTH_S = 1.0
#: The slope is taken over this time. [s]
_SLOPE_S = 2.0
#: Pauses in a movement that are shorter do not part it. [s]
_PAUSE_S = 0.8
#: A channel that is valid for less of the run is not used.
_LEAST_VALID = 0.3

#: Samples from the first up to, and without, the last.
Range = tuple[int, int]


@dataclass(frozen=True)
class Signals:
    """A run every 0.1 s.

    `channels` (m,) are heading (continuous), pitch, roll [rad], surge [m/s] and depth [m], those
    that were measured, smoothed. `command` (m, n) is each code as a share of its range, `known`
    (m,) where the commands are known.
    """

    time_s: FloatArray
    command: FloatArray
    known: BoolArray
    channels: Mapping[str, FloatArray]


@dataclass(frozen=True)
class Swing:
    """A movement one way: samples `begin` to `end`, and how far."""

    begin: int
    end: int
    change: float


def signals_of(run: RunTable, code_max: FloatArray | None) -> Signals | None:
    """Bring a run to the form that is looked at; None where it has no commands or is too short."""
    if "command" not in run.values or run.time_s.size < 2:
        return None
    time_s = np.arange(0.0, float(run.time_s[-1]) + 1e-9, PERIOD_S)
    if time_s.size < 30:
        return None
    index = np.clip(np.searchsorted(run.time_s, time_s - 1e-9), 0, run.time_s.size - 1)
    command = run.values["command"][index]
    known = run.valid["command"][index] & np.isfinite(command).all(axis=1)
    command = np.where(known[:, None], command, 0.0)
    size = np.abs(command).max(initial=0.0) if code_max is None else np.asarray(code_max, float)
    return Signals(time_s, command / np.maximum(size, 1e-9), known, _channels(run, time_s))


def _channels(run: RunTable, time_s: FloatArray) -> dict[str, FloatArray]:
    """Take what was measured to the times, bridged on a line where there is nothing."""
    from scipy.ndimage import uniform_filter1d

    def told(quantity: str) -> FloatArray | None:
        """Take readings (m, c), or angles, smoothed by the moving mean over a second."""
        if quantity not in run.values or (good := run.trusted(quantity)).mean() < _LEAST_VALID:
            return None
        values = run.values[quantity][good]
        if quantity == "attitude":
            values = angles(values)
            values[:, 2] = np.unwrap(values[:, 2])
        known = run.time_s[good]
        values = np.stack([np.interp(time_s, known, one) for one in values.T], axis=1)
        width = round(_SMOOTH_S / PERIOD_S)
        return np.asarray(uniform_filter1d(values, width, axis=0, mode="nearest"))

    found: dict[str, FloatArray] = {}
    if (attitude := told("attitude")) is not None:
        found |= dict(zip(("roll", "pitch", "heading"), attitude.T, strict=True))
    elif (rate := told("angular_velocity")) is not None:
        # the heading alone, where the yaw rate is all there is
        found["heading"] = PERIOD_S * np.cumsum(rate[:, 2] - np.median(rate[:, 2]))
    if (velocity := told("velocity")) is not None:
        found["surge"] = velocity[:, 0]
    for quantity in ("position", "depth"):
        if (deep := told(quantity)) is not None:
            found["depth"] = deep[:, -1]
    return found


def slope(values: FloatArray) -> FloatArray:
    """Change a second over two seconds around each sample (m,)."""
    half = round(_SLOPE_S / PERIOD_S / 2)
    padded = np.pad(values, half, mode="edge")
    return np.asarray((padded[2 * half :] - padded[: -2 * half]) / _SLOPE_S)


def swings(
    channel: FloatArray, part: Range, least_slope: float, least_change: float
) -> list[Swing]:
    """Movements one way within a part, faster than a slope and further than a change.

    >>> steps = np.repeat([0.0, 1.0, 1.0, 0.0], 50)
    >>> [(swing.change > 0) for swing in swings(steps, (0, 200), 0.1, 0.5)]
    [True, False]
    """
    values = channel[slice(*part)]
    speed = slope(values)
    found: list[Swing] = []
    for sign in (1.0, -1.0):
        moving = sign * speed > least_slope
        for begin, end in stretches(moving, round(_PAUSE_S / PERIOD_S)):
            # the slope is seen before and after the movement itself
            change = float(values[end - 1] - values[begin])
            if sign * change >= least_change:
                found.append(Swing(part[0] + begin, part[0] + end, change))
    return sorted(found, key=lambda swing: swing.begin)


def stretches(mark: BoolArray, bridge: int = 0) -> list[Range]:
    """Begin and end of each run of True; pauses of up to `bridge` samples are bridged.

    >>> stretches(np.array([0, 1, 1, 0, 1, 0, 0, 0, 1], bool), bridge=1)
    [(1, 5), (8, 9)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mark, [False]]).astype(np.int8)))
    found: list[Range] = []
    for begin, end in edges.reshape(-1, 2).tolist():
        if found and begin - found[-1][1] <= bridge:
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return found
