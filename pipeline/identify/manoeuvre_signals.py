"""The slow motion and the commands of a run, as manoeuvre detection looks at them."""

from dataclasses import dataclass

import numpy as np

from pipeline.records.run_components import angles
from pipeline.records.run_table import RunTable
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


@dataclass(frozen=True)
class Signals:
    """Smoothed channels (m,) every 0.1 s; None where they were not measured.

    `heading` is continuous; angles in rad, `surge` in m/s, `depth` in m. `command` (m, n) is each
    code as a share of its range. `known` is where commands are known.
    """

    time_s: FloatArray
    command: FloatArray
    known: BoolArray
    heading: FloatArray | None
    pitch: FloatArray | None
    roll: FloatArray | None
    surge: FloatArray | None
    depth: FloatArray | None


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
    command = command / np.maximum(size, 1e-9)
    heading, pitch, roll = _angles(run, time_s)
    velocity, depth = _filled(run, "velocity", time_s), _filled(run, "depth", time_s)
    if depth is None and (position := _filled(run, "position", time_s)) is not None:
        depth = position[:, 2:]
    surge, deep = (None if one is None else _smooth(one)[:, 0] for one in (velocity, depth))
    return Signals(time_s, command, known, heading, pitch, roll, surge, deep)


def _filled(run: RunTable, quantity: str, time_s: FloatArray) -> FloatArray | None:
    """Take readings to the times of the signals, bridged on a line where there are none."""
    if quantity not in run.values:
        return None
    good = run.trusted(quantity)
    if good.mean() < _LEAST_VALID:
        return None
    columns = run.values[quantity][good].T
    return np.stack([np.interp(time_s, run.time_s[good], column) for column in columns], axis=1)


def _smooth(values: FloatArray) -> FloatArray:
    """Return the moving mean over a second."""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(values, round(_SMOOTH_S / PERIOD_S), axis=0, mode="nearest"))


def _angles(
    run: RunTable, time_s: FloatArray
) -> tuple[FloatArray | None, FloatArray | None, FloatArray | None]:
    """Heading, pitch and roll; the heading alone from the yaw rate where that is all there is."""
    quaternion = run.values.get("attitude")
    if quaternion is not None:
        good = run.trusted("attitude")
        if good.mean() >= _LEAST_VALID:
            roll, pitch, heading = angles(quaternion[good]).T
            columns = [
                np.interp(time_s, run.time_s[good], one)
                for one in (np.unwrap(heading), pitch, roll)
            ]
            smooth = _smooth(np.stack(columns, axis=1))
            return smooth[:, 0], smooth[:, 1], smooth[:, 2]
    rate = _filled(run, "angular_velocity", time_s)
    if rate is None:
        return None, None, None
    return PERIOD_S * np.cumsum(rate[:, 2] - np.median(rate[:, 2])), None, None


def slope(values: FloatArray) -> FloatArray:
    """Change a second over two seconds around each sample (m,)."""
    half = round(_SLOPE_S / PERIOD_S / 2)
    padded = np.pad(values, half, mode="edge")
    return np.asarray((padded[2 * half :] - padded[: -2 * half]) / _SLOPE_S)


def swings(values: FloatArray, least_slope: float, least_change: float) -> list[Swing]:
    """Movements one way, faster than a slope and further than a change.

    >>> steps = np.repeat([0.0, 1.0, 1.0, 0.0], 50)
    >>> [(swing.change > 0) for swing in swings(steps, 0.1, 0.5)]
    [True, False]
    """
    speed = slope(values)
    found: list[Swing] = []
    for sign in (1.0, -1.0):
        moving = sign * speed > least_slope
        for begin, end in stretches(moving, round(_PAUSE_S / PERIOD_S)):
            # the slope is seen before and after the movement itself
            change = float(values[end - 1] - values[begin])
            if sign * change >= least_change:
                found.append(Swing(begin, end, change))
    return sorted(found, key=lambda swing: swing.begin)


def stretches(mark: BoolArray, bridge: int = 0) -> list[tuple[int, int]]:
    """Begin and end of each run of True; pauses of up to `bridge` samples are bridged.

    >>> stretches(np.array([0, 1, 1, 0, 1, 0, 0, 0, 1], bool), bridge=1)
    [(1, 5), (8, 9)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mark, [False]]).astype(np.int8)))
    found: list[tuple[int, int]] = []
    for begin, end in edges.reshape(-1, 2).tolist():
        if found and begin - found[-1][1] <= bridge:
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return found
