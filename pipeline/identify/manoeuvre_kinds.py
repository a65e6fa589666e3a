"""Steps, turns, ramps and excitation: what a part of a run holds, by its movements and commands."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.identify.manoeuvre_signals import PERIOD_S, Range, Signals, Swing, slope, swings
from pipeline.records.trial import ManoeuvreName
from pipeline.types import FloatArray

_DEGREE = np.pi / 180.0
#: Axis -> slope above which it moves and smallest change that counts ([rad/s], [rad]; [m/s], [m]),
#: what its steps are called, and the unit that they are told in.
_AXES: dict[str, tuple[float, float, ManoeuvreName, str]] = {
    "heading": (0.7 * _DEGREE, 5.0 * _DEGREE, "heading_steps", "deg"),
    "pitch": (0.5 * _DEGREE, 3.0 * _DEGREE, "pitch_steps", "deg"),
    "roll": (0.7 * _DEGREE, 4.0 * _DEGREE, "roll_steps", "deg"),
    "depth": (0.025, 0.2, "heave_steps", "m"),
}
#: A step of surge: slope [m/s2], change as a share of the fastest, and at least [m/s].
_SURGE_SLOPE, _SURGE_SHARE, _SURGE_LEAST_MPS = 0.02, 0.18, 0.07
#: Speed that rises for so long rises along a ramp where the commands of its last third are so much
#: larger than those of its first. [s], [1]
_LEAST_RAMP_S, _RISES = 7.5, 1.3
#: Movements of an axis with longer pauses do not belong together. [s]
_LONGEST_PAUSE_S = 40.0
#: One turn this way is a circle; as much each way a spiral.
_CIRCLE_RAD, _SPIRAL_RAD = 270.0 * _DEGREE, 150.0 * _DEGREE
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


def groups_of(signals: Signals, part: Range) -> list[Group]:
    """Find the groups of movements in a part of a run, those that explain the others first."""
    by_axis = {
        axis: _near_each_other(_swings(signals, axis, part, *limits[:2]))
        for axis, limits in _AXES.items()
    }
    turns = [
        (max(abs(one.change) for one in group) / _AXES[axis][1], axis, group)
        for axis in ("heading", "pitch", "roll")
        for group in by_axis[axis]
        if len(group) >= 2 or axis == "heading"
    ]
    found = [
        _heading(signals, group) if axis == "heading" else _steps(signals, axis, group)
        for _, axis, group in sorted(turns, key=lambda one: -one[0])
    ]
    found = _several_axes(found)
    found += [_steps(signals, "depth", group) for group in by_axis["depth"]]
    return found + _surge(signals, part)


def _swings(
    signals: Signals, axis: str, part: Range, least_slope: float, least_change: float
) -> list[Swing]:
    channel = signals.channels.get(axis)
    if channel is None:
        return []
    found = swings(channel[slice(*part)], least_slope, least_change)
    return [Swing(one.begin + part[0], one.end + part[0], one.change) for one in found]


def _near_each_other(found: Sequence[Swing]) -> list[list[Swing]]:
    groups: list[list[Swing]] = []
    for one in found:
        if groups and (one.begin - groups[-1][-1].end) * PERIOD_S <= _LONGEST_PAUSE_S:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def _heading(signals: Signals, group: Sequence[Swing]) -> Group:
    """Circle, spiral, zig-zag or steps of heading."""
    begin, end = group[0].begin, group[-1].end
    starboard = sum(max(one.change, 0.0) for one in group)
    port = -sum(min(one.change, 0.0) for one in group)
    largest = max(abs(one.change) for one in group)
    less, more = sorted((starboard, port))
    surge = signals.channels.get("surge")
    speed = 0.0 if surge is None else float(np.median(np.abs(surge[begin:end])))
    at = ", at a speed not measured" if surge is None else f", at {speed:.2f} m/s"
    reversals = sum(one.change * other.change < 0 for one, other in pairwise(group))
    name: ManoeuvreName
    if min(less, largest) > _SPIRAL_RAD:
        name = "spiral"
        text = f"turns {starboard / _DEGREE:.0f} deg to starboard and {port / _DEGREE:.0f} to port"
    elif more > _CIRCLE_RAD and less < 0.2 * more:
        way = "starboard" if starboard > port else "port"
        name, text = "circle", f"turns {more / _DEGREE:.0f} deg to {way}"
    elif reversals >= 2 and speed > 0.1:
        name, text = "zig_zag", f"heading swings {reversals} times to the other side, by up to "
        text += f"{largest / _DEGREE:.0f} deg"
    else:
        return _steps(signals, "heading", group, at)
    return Group(begin, end, name, text + at)


def _steps(signals: Signals, axis: str, group: Sequence[Swing], at: str = "") -> Group:
    begin, end = group[0].begin, group[-1].end
    _, _, name, unit = _AXES[axis]
    channel = signals.channels[axis][begin:end] / (_DEGREE if unit == "deg" else 1.0)
    times = "1 movement" if len(group) == 1 else f"{len(group)} movements"
    text = f"{times} of {axis} between {channel.min():.3g} and {channel.max():.3g} {unit}{at}"
    return Group(begin, end, name, text)


def _several_axes(found: list[Group]) -> list[Group]:
    """Put groups of three axes that go on together into one that is mixed."""
    for group in found:
        together = [
            other
            for other in found
            if min(group.end, other.end) - max(group.begin, other.begin)
            > 0.5 * max(group.end - group.begin, other.end - other.begin)
        ]
        if len({other.name for other in together}) >= 3:
            begin = min(other.begin for other in together)
            end = max(other.end for other in together)
            text = "; ".join(other.sentence for other in together)
            rest = [one for one in found if one not in together]
            return [Group(begin, end, "mixed", text), *_several_axes(rest)]
    return found


def _surge(signals: Signals, part: Range) -> list[Group]:
    """Ramps, or steps between different speeds; to and fro at one speed is neither."""
    if "surge" not in signals.channels:
        return []
    speed = np.abs(signals.channels["surge"])
    fastest = float(speed[slice(*part)].max(initial=0.0))
    least = max(_SURGE_LEAST_MPS, _SURGE_SHARE * fastest)
    moves = _swings(signals, "surge", part, _SURGE_SLOPE, least)
    push = np.abs(signals.command).max(axis=1)
    ramps = []
    for one in moves:
        first, _, last = np.array_split(push[one.begin : one.end], 3)
        rises = speed[one.end - 1] > speed[one.begin] and last.mean() > _RISES * first.mean()
        if rises and (one.end - one.begin) * PERIOD_S >= _LEAST_RAMP_S:
            ramps.append(one)
    if ramps:
        return _ramps(speed, moves, ramps)
    found: list[Group] = []
    for group in _near_each_other(moves):
        # between movements the vehicle keeps a speed; the last is kept to the end of the part
        end = group[-1].end
        edges = [*(one.begin for one in group[1:]), min(end + round(3.0 / PERIOD_S), part[1])]
        levels = [
            float(np.median(speed[one.end - 1 : max(edge, one.end)]))
            for one, edge in zip(group, edges, strict=True)
        ]
        under_way = [level for level in levels if level > 0.12 * fastest]
        if len(group) > 1 and under_way and max(under_way) - min(under_way) > 0.2 * fastest:
            text = f"steps of speed: {', '.join(f'{level:.2f}' for level in levels[:8])} m/s"
            found.append(Group(group[0].begin, end, "surge_steps", text))
    return found


def _ramps(speed: FloatArray, moves: Sequence[Swing], ramps: Sequence[Swing]) -> list[Group]:
    """Ramps of the speed, and the slowing down after one."""
    first, last = ramps[0].begin, moves[-1].end
    slow = [one.begin for one in moves if one.begin >= ramps[-1].end]
    text = f"surge rises along a ramp to {speed[first:last].max():.2f} m/s"
    if len(ramps) > 1:
        return [Group(first, last, "surge_ramp", f"{text}, {len(ramps)} times")]
    if not slow:
        return [Group(first, last, "surge_ramp", text)]
    said = f"slows down from {speed[slow[0]]:.2f} to {speed[last - 1]:.2f} m/s"
    return [
        Group(first, slow[0], "surge_ramp", text),
        Group(slow[0], last, "coast_down", said),
    ]


def broadband(signals: Signals, part: Range) -> Group | None:
    """Tell whether a part is broad-band excitation: multisine, chirp or pseudo-random steps."""
    command = signals.command[slice(*part)]
    if len(command) < 100:
        return None
    varied = command - command.mean(axis=0)
    steps = np.abs(np.diff(command, axis=0))
    still = float((steps <= _STILL_STEP).all(axis=1).mean())
    jumping = float((steps > _JUMP).any(axis=1).mean())
    size = varied.std(axis=0)
    if size.max() < _LEAST_SIZE or (still > _MOST_STILL and jumping < _LEAST_JUMPING):
        return None
    fast, even, noisy = _shape(varied)
    axes = [
        axis
        for axis, least in _MOVES.items()
        if axis in signals.channels
        if (np.abs(slope(signals.channels[axis][slice(*part)])) > least).mean() > _LEAST_MOVING
    ]
    if even < _LEAST_EVEN or noisy > _MOST_NOISY or fast < _LEAST_FAST:
        return None
    if len(axes) < (1 if still <= _MOST_STILL else 2):
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
    line = np.polynomial.Polynomial.fit
    time = np.arange(len(varied))
    rest = np.stack([one - line(time, one, 1)(time) for one in varied.T], axis=1)
    power = np.abs(np.fft.rfft(np.hanning(len(rest))[:, None] * rest, axis=0)) ** 2
    return np.fft.rfftfreq(len(rest), PERIOD_S).astype(np.float64), power.sum(axis=1)


def _shape(varied: FloatArray) -> tuple[float, float, float]:
    """Share of the power above 0.1 Hz, how evenly the band holds it (0 to 1), share above 1 Hz."""
    frequency, power = _spectrum(varied)
    total = max(float(power.sum()), 1e-12)
    band = power[(frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])]
    band = band / max(float(band.sum()), 1e-12)
    # entropy of the spectrum: 1 where every line is as strong, near 0 for one line
    even = -float((band * np.log(band + 1e-12)).sum()) / np.log(max(band.size, 2))
    fast, noisy = (float(power[frequency > edge].sum()) / total for edge in (_FAST_HZ, _NOISY_HZ))
    return fast, even, noisy
