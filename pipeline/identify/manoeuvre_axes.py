"""Steps, turns and ramps: movements one way on one axis that belong together."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.identify.manoeuvre_signals import PERIOD_S, Signals, Swing, stretches, swings
from pipeline.records.manoeuvre import ManoeuvreName
from pipeline.types import FloatArray

_DEGREE = np.pi / 180.0
#: Axis -> slope above which it moves, smallest change that counts. [rad/s], [rad]; [m/s], [m]
_LIMITS = {
    "heading": (0.7 * _DEGREE, 5.0 * _DEGREE),
    "pitch": (0.5 * _DEGREE, 3.0 * _DEGREE),
    "roll": (0.7 * _DEGREE, 4.0 * _DEGREE),
    "depth": (0.025, 0.2),
}
#: A step of surge: slope [m/s2], change as a share of the fastest, and at least [m/s].
_SURGE_SLOPE = 0.02
_SURGE_SHARE = 0.18
_SURGE_LEAST_MPS = 0.07
#: Movements of an axis with longer pauses do not belong together. [s]
_LONGEST_PAUSE_S = 40.0
#: One turn this way is a circle; as much each way a spiral.
_CIRCLE_RAD = 270.0 * _DEGREE
_SPIRAL_RAD = 150.0 * _DEGREE
#: A command ramps where a line over 5 s changes by this share of its range and leaves little.
_RAMP_S = 5.0
_RAMP_CHANGE = 0.03
_RAMP_REST = 0.12
_LEAST_RAMP_S = 7.5


@dataclass(frozen=True)
class Group:
    """Samples `begin` to `end`, what they are, and how plainly."""

    begin: int
    end: int
    name: ManoeuvreName
    sentence: str
    confidence: float


def groups_of(signals: Signals, begin: int, end: int) -> list[Group]:
    """Find the groups of movements in a part of a run, those that explain the others first."""
    by_axis = {axis: _groups(signals, axis, begin, end) for axis in _LIMITS}
    found: list[Group] = []
    for group in by_axis["heading"]:
        found += _heading(signals, group)
    tilts: dict[str, ManoeuvreName] = {"pitch": "pitch_steps", "roll": "roll_steps"}
    for axis, name in tilts.items():
        for group in by_axis[axis]:
            if len(group) >= 2:
                found.append(_steps(signals, axis, name, group, "deg", 1.0 / _DEGREE))
    found = _several_axes(found)
    for group in by_axis["depth"]:
        found.append(_steps(signals, "depth", "heave_steps", group, "m", 1.0))
    return found + _surge(signals, begin, end)


def _groups(signals: Signals, axis: str, begin: int, end: int) -> list[list[Swing]]:
    channel = getattr(signals, axis)
    if channel is None:
        return []
    return _near_each_other(_moved(swings(channel[begin:end], *_LIMITS[axis]), begin))


def _moved(found: Sequence[Swing], begin: int) -> list[Swing]:
    return [Swing(one.begin + begin, one.end + begin, one.change) for one in found]


def _near_each_other(found: Sequence[Swing]) -> list[list[Swing]]:
    groups: list[list[Swing]] = []
    for one in found:
        if groups and (one.begin - groups[-1][-1].end) * PERIOD_S <= _LONGEST_PAUSE_S:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def _heading(signals: Signals, group: Sequence[Swing]) -> list[Group]:
    """Circle, spiral, zig-zag or steps of heading."""
    begin, end = group[0].begin, group[-1].end
    starboard = sum(max(one.change, 0.0) for one in group)
    port = -sum(min(one.change, 0.0) for one in group)
    largest = max(abs(one.change) for one in group)
    speed = _speed(signals, begin, end)
    at = ", at a speed not measured" if speed is None else f", at {speed:.2f} m/s"
    if min(starboard, port) > _SPIRAL_RAD and largest > _SPIRAL_RAD:
        text = f"turns {starboard / _DEGREE:.0f} deg to starboard and {port / _DEGREE:.0f} to port"
        return [Group(begin, end, "spiral", text + at, 0.85)]
    if max(starboard, port) > _CIRCLE_RAD and min(starboard, port) < 0.2 * max(starboard, port):
        way = "starboard" if starboard > port else "port"
        turn = max(starboard, port) / _DEGREE
        return [Group(begin, end, "circle", f"turns {turn:.0f} deg to {way}{at}", 0.9)]
    reversals = sum(one.change * other.change < 0 for one, other in itertools.pairwise(group))
    under_way = speed is not None and speed > 0.1
    if reversals >= 2 and under_way:
        text = f"heading swings {reversals} times to the other side, by up to "
        text += f"{largest / _DEGREE:.0f} deg{at}"
        return [Group(begin, end, "zig_zag", text, 0.6 + 0.1 * min(reversals - 1, 3))]
    text = f"{_times(len(group), 'movement')} of heading, up to {largest / _DEGREE:.0f} deg{at}"
    return [Group(begin, end, "heading_steps", text, 0.5 + 0.1 * min(len(group), 4))]


def _speed(signals: Signals, begin: int, end: int) -> float | None:
    if signals.surge is None:
        return None
    return float(np.median(np.abs(signals.surge[begin:end])))


def _steps(  # noqa: PLR0917  one line a group
    signals: Signals,
    axis: str,
    name: ManoeuvreName,
    group: Sequence[Swing],
    unit: str,
    scale: float,
) -> Group:
    begin, end = group[0].begin, group[-1].end
    channel: FloatArray = getattr(signals, axis)[begin:end]
    text = (
        f"{_times(len(group), 'movement')} of {axis} between {scale * channel.min():.3g} and "
        f"{scale * channel.max():.3g} {unit}"
    )
    return Group(begin, end, name, text, 0.5 + 0.1 * min(len(group), 4))


def _several_axes(found: Sequence[Group]) -> list[Group]:
    """Put groups of three axes that go on together into one that is mixed."""
    kept = list(found)
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
            kept = [one for one in kept if one not in together]
            return [Group(begin, end, "mixed", text, 0.6), *_several_axes(kept)]
    return kept


def _surge(signals: Signals, begin: int, end: int) -> list[Group]:
    """Ramps, or steps between different speeds; to and fro at one speed is neither."""
    if signals.surge is None:
        return []
    surge = signals.surge[begin:end]
    fastest = float(np.abs(surge).max(initial=0.0))
    least = max(_SURGE_LEAST_MPS, _SURGE_SHARE * fastest)
    moves = _moved(swings(surge, _SURGE_SLOPE, least), begin)
    found: list[Group] = []
    for group in _near_each_other(moves):
        first, last = group[0].begin, group[-1].end
        # between movements the vehicle keeps a speed; the last is kept to the end of the part
        edges = [*(one.begin for one in group[1:]), min(last + round(3.0 / PERIOD_S), end)]
        levels = [
            float(np.median(np.abs(signals.surge[one.end - 1 : max(edge, one.end)])))
            for one, edge in zip(group, edges, strict=True)
        ]
        under_way = [level for level in levels if level > 0.12 * fastest]
        if len(group) < 2 or not under_way:
            continue
        if max(under_way) - min(under_way) > 0.2 * fastest:
            said = ", ".join(f"{level:.2f}" for level in levels[:8])
            text = f"steps of speed: {said} m/s"
            found.append(Group(first, last, "surge_steps", text, 0.5 + 0.1 * min(len(group), 4)))
    ramps = _ramps(signals, moves, begin, end)
    ramped = sum(one.end - one.begin for one in ramps)
    stepped = sum(one.end - one.begin for one in found)
    # a ramp or two among steps are steps; steps inside of what is mostly ramps are ramps
    return ramps if ramped > 0.5 * stepped else found


def _ramps(signals: Signals, moves: Sequence[Swing], begin: int, end: int) -> list[Group]:
    """Ramps of the commands that drive the vehicle on, and the slowing down after them."""
    surge = signals.surge
    if surge is None:
        return []
    ramps = [
        (first, last)
        for first, last in _command_ramps(signals, begin, end)
        if any(
            one.begin < last and one.end > first and one.change * surge[one.end - 1] > 0
            for one in moves
        )
    ]
    if not ramps:
        return []
    first, last = ramps[0][0], ramps[-1][1]
    slow = [
        one
        for one in moves
        if one.end > last and one.begin < last + round(20.0 / PERIOD_S)
        if one.change * surge[one.begin] < 0
    ]
    fastest = float(np.abs(surge[first:last]).max())
    text = f"surge rises along a ramp to {fastest:.2f} m/s"
    confidence = 0.7 if len(ramps) == 1 and not slow else 0.85
    if len(ramps) > 1:
        text += f", {len(ramps)} times"
        last = max([last, *(one.end for one in slow)])
        return [Group(first, last, "surge_ramp", text, confidence)]
    if not slow:
        return [Group(first, last, "surge_ramp", text, confidence)]
    cut, rest = slow[0].begin, slow[-1].end
    said = f"slows down from {abs(surge[cut]):.2f} to {abs(surge[rest - 1]):.2f} m/s"
    return [
        Group(first, cut, "surge_ramp", text, confidence),
        Group(cut, rest, "coast_down", said, 0.7),
    ]


def _command_ramps(signals: Signals, begin: int, end: int) -> list[tuple[int, int]]:
    """Stretches in which the strongest commands follow a rising or falling line."""
    window, hop = round(_RAMP_S / PERIOD_S), round(0.5 / PERIOD_S)
    line = np.arange(window) - (window - 1) / 2.0
    line /= np.linalg.norm(line)
    strong = np.abs(signals.command[begin:end]).max(axis=0, initial=0.0)
    columns = strong > 0.5 * strong.max(initial=0.0)
    mark = np.zeros(end, np.bool_)
    for at in range(begin, end - window + 1, hop):
        part = signals.command[at : at + window, columns]
        part = part - part.mean(axis=0)
        along = line @ part
        change = np.abs(along) * (line[-1] - line[0])
        rest = (part - line[:, None] * along).std(axis=0)
        if ((change > _RAMP_CHANGE) & (rest < _RAMP_REST * change)).any():
            mark[at : at + window] = True
    found = stretches(mark, round(1.0 / PERIOD_S))
    return [(a, b) for a, b in found if (b - a) * PERIOD_S >= _LEAST_RAMP_S]


def _times(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
