"""The slow motion and the commands of a run, as manoeuvre detection looks at them."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.records.run_table import RunTable, angles
from pipeline.records.trial import ManoeuvreName
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


#: What makes commands broad-band: their size, the share of their power above 0.1 Hz, the share of
#: the time in which none moves, and the share in which some axis does.
_LEAST_SIZE, _LEAST_FAST, _FAST_HZ = 0.08, 0.55, 0.1
_MOST_STILL, _STILL_STEP, _LEAST_MOVING = 0.6, 0.02, 0.5
#: A controller that feeds noise or one sine through is none: how evenly power must be spread over
#: the band, and how much of it may lie above.
_BAND_HZ, _LEAST_EVEN, _NOISY_HZ, _MOST_NOISY = (0.02, 0.6), 0.78, 1.0, 0.12
#: Or commands that hold and jump, with at least this share of the samples in a jump.
_JUMP, _LEAST_JUMPING = 0.10, 0.04
#: Slopes above which an axis moves: heading, pitch, roll [rad/s], surge [m/s2], depth [m/s].
_MOVES = {"heading": 0.012, "pitch": 0.009, "roll": 0.009, "surge": 0.03, "depth": 0.03}


@dataclass(frozen=True)
class Group:
    """Samples `begin` to `end`, and what they are."""

    begin: int
    end: int
    name: ManoeuvreName
    sentence: str


def broadband(signals: Signals, part: Range) -> Group | None:
    """Tell whether a part is an excitation, and which."""
    command = signals.command[slice(*part)]
    if len(command) < 100:
        return None
    varied = command - command.mean(axis=0)
    steps = np.abs(np.diff(command, axis=0))
    still = float((steps <= _STILL_STEP).all(axis=1).mean())
    size = varied.std(axis=0)
    jumping = float((steps > _JUMP).any(axis=1).mean()) >= _LEAST_JUMPING
    if size.max() < _LEAST_SIZE or (still > _MOST_STILL and not jumping):
        return None
    axes = [
        axis
        for axis, least in _MOVES.items()
        if axis in signals.channels
        if (np.abs(slope(signals.channels[axis][slice(*part)])) > least).mean() > _LEAST_MOVING
    ]
    if len(axes) < (1 if still <= _MOST_STILL else 2) or not _is_broad(varied):
        return None
    own = steps[:, int(np.argmax(size))]
    centres = []
    for quarter in np.array_split(varied, 4):
        frequency, power = _spectrum(quarter)
        centres.append(float((frequency * power).sum() / max(power.sum(), 1e-12)))
    name: ManoeuvreName = "multisine"
    if own[own > _JUMP].sum() > 0.6 * own.sum() and (own <= 0.5 * _STILL_STEP).mean() > 0.35:
        # nearly all of the change is in a few jumps
        name = "prbs"
    elif all(b > 1.1 * a for a, b in pairwise(centres)) and centres[3] > 2.0 * centres[0]:
        name = "chirp"
    return Group(*part, name, f"commands of many frequencies; {', '.join(axes)} move")


def _spectrum(varied: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequencies (k,) [Hz] and power (k,), all thrusters together, less a line each."""
    from scipy.signal import detrend

    rest = np.hanning(len(varied))[:, None] * detrend(varied, axis=0)
    power = np.abs(np.fft.rfft(rest, axis=0)) ** 2
    return np.fft.rfftfreq(len(rest), PERIOD_S).astype(np.float64), power.sum(axis=1)


def _is_broad(varied: FloatArray) -> bool:
    """Whether power is fast enough, spread evenly over the band, and not mostly noise above it."""
    frequency, power = _spectrum(varied)
    total = max(float(power.sum()), 1e-12)
    band = power[(frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])]
    band = band / max(float(band.sum()), 1e-12)
    # entropy of the spectrum: 1 where every line is as strong, near 0 for one line
    even = -float((band * np.log(band + 1e-12)).sum()) / np.log(max(band.size, 2))
    fast, noisy = (float(power[frequency > edge].sum()) / total for edge in (_FAST_HZ, _NOISY_HZ))
    return even >= _LEAST_EVEN and noisy <= _MOST_NOISY and fast >= _LEAST_FAST
