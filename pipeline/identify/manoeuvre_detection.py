"""Find what was flown in a run: stretches of steps, turns, ramps, excitation, rest.

Where every thruster is off the vehicle idles, coasts or decays freely. Commands of many frequencies
are an excitation. Elsewhere movements one way are looked for, axis by axis (heading, pitch, roll,
depth, surge); several of them near each other are steps of that axis, turns of more than three
quarters are circles and spirals. What is left is hovering or a straight run. The limits are set to
the manoeuvres of `pipeline.simulate.manoeuvres` on the bundled vehicles.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from pipeline.identify.manoeuvre_axes import Group, groups_of
from pipeline.identify.manoeuvre_broadband import WINDOW_S, broadband
from pipeline.identify.manoeuvre_signals import PERIOD_S, Signals, signals_of, slope, stretches
from pipeline.records.manoeuvre import ManoeuvreFound, ManoeuvreName
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: A command below this share of its range is off.
_OFF = 0.01
#: Thrusters are off if all are for so long. [s]
_LEAST_OFF_S = 3.0
#: What is shorter is part of what is beside it. [s]
_LEAST_S = 4.0
#: Steps are taken to begin and end so long before and after they move. [s]
_PLATEAU_S = 12.0
#: Ahead or astern of this speed is under way; so is this share of the fastest of the run. [m/s]
_UNDER_WAY_MPS = 0.1
_UNDER_WAY_SHARE = 0.25
#: At rest at the start of a free decay is less than this. [rad/s], [m/s]
_STILL_RADPS = 0.01
_STILL_MPS = 0.05

_OF_SURGE = ("surge_ramp", "coast_down", "surge_steps")

Range = tuple[int, int]


def find_manoeuvres(
    run: RunTable, code_max: FloatArray | None = None
) -> tuple[ManoeuvreFound, ...]:
    """Part a run into stretches and say what each was.

    Parameters
    ----------
    run : RunTable
        A run; needs commands, uses attitude (or yaw rate), velocity and depth as far as there.
    code_max : ndarray, shape (n,), optional
        Largest code of each thruster; default the largest code of the run.

    Returns
    -------
    tuple of ManoeuvreFound
        In the order of time, without overlap; empty for a run without commands or of less than
        three seconds.
    """
    signals = signals_of(run, code_max)
    if signals is None:
        return ()
    off = (np.abs(signals.command) <= _OFF).all(axis=1) & signals.known
    still = [part for part in stretches(off) if _long(part, _LEAST_OFF_S)]
    found = [_off(signals, part) for part in still]
    for part in _rest((0, signals.time_s.size), still):
        found += _driven(signals, part)
    return tuple(sorted(found, key=lambda one: one.from_s))


def _driven(signals: Signals, part: Range) -> list[ManoeuvreFound]:
    """Name a stretch in which thrusters are commanded."""
    loud = _loud(signals, part)
    found = []
    for begin, end in loud:
        kind = broadband(signals, begin, end)
        if kind is not None:
            text = f"commands of many frequencies; {', '.join(kind.axes)} move"
            name: ManoeuvreName = kind.name  # type: ignore[assignment]  # the kinds are those of the Literal
            found.append(_found(signals, (begin, end), name, text, kind.confidence))
    for inner in _rest(part, loud):
        groups = _chosen(groups_of(signals, *inner))
        claimed = [_claim(group, inner, groups) for group in groups]
        found += [
            _found(signals, where, group.name, group.sentence, group.confidence)
            for group, where in zip(groups, claimed, strict=True)
        ]
        for left in _rest(inner, claimed):
            found += _steady(signals, left)
    return found


def _loud(signals: Signals, part: Range) -> list[Range]:
    """Stretches of broad-band commands: the whole part, or what of it windows show."""
    if broadband(signals, *part) is not None:
        return [part]
    window, hop = round(WINDOW_S / PERIOD_S), round(WINDOW_S / PERIOD_S / 6)
    mark = np.zeros(signals.time_s.size, np.bool_)
    for begin in range(part[0], part[1] - window + 1, hop):
        if broadband(signals, begin, begin + window) is not None:
            mark[begin : begin + window] = True
    return [one for one in stretches(mark) if broadband(signals, *one) is not None]


def _chosen(groups: Sequence[Group]) -> list[Group]:
    """Drop groups that a stronger one covers; `groups` come strongest first."""
    kept: list[Group] = []
    for group in groups:
        covered = sum(
            max(min(group.end, other.end + room) - max(group.begin, other.begin - room), 0)
            for other in kept
            if (room := 0 if other.name in _OF_SURGE else _samples(_PLATEAU_S)) >= 0
        )
        if covered < 0.3 * (group.end - group.begin):
            kept.append(group)
    return sorted(kept, key=lambda group: group.begin)


def _claim(group: Group, inner: Range, groups: Sequence[Group]) -> Range:
    """Widen a group by the plateaus beside it, up to its neighbours."""
    before = max((other.end for other in groups if other.end <= group.begin), default=inner[0])
    after = min((other.begin for other in groups if other.begin >= group.end), default=inner[1])
    room = _samples(_PLATEAU_S)
    # two neighbours share what lies between them
    first = before if before == inner[0] else (before + group.begin) // 2
    last = after if after == inner[1] else (after + group.end) // 2
    begin, end = max(group.begin - room, first), min(group.end + room, last)
    if begin - first < _samples(2 * _LEAST_S) and first == inner[0]:
        begin = first
    if last - end < _samples(2 * _LEAST_S) and last == inner[1]:
        end = last
    return begin, end


def _steady(signals: Signals, part: Range) -> list[ManoeuvreFound]:
    """Tell hovering from straight runs, where nothing else was found."""
    if not _long(part, _LEAST_S):
        return []
    begin, end = part
    if not signals.known[begin:end].mean() > 0.5:
        text = "the commands are not known"
        return [_found(signals, part, "mixed", text, 0.5)]
    if signals.surge is None:
        text = "heading, attitude and depth are held; the speed was not measured"
        return [_found(signals, part, "hover", text, 0.5)]
    surge = signals.surge
    fastest = float(np.abs(surge).max())
    limit = max(_UNDER_WAY_MPS, _UNDER_WAY_SHARE * fastest)
    under_way = np.abs(surge[begin:end]) > limit
    found: list[ManoeuvreFound] = []
    # runs to and fro pass through rest in between
    moving = stretches(under_way, _samples(6.0))
    moving = [(begin + a, begin + b) for a, b in moving if _long((a, b), _LEAST_S)]
    moving = [_closed(one, part) for one in moving]
    found += [_straight(signals, one) for one in moving]
    for one in _rest(part, moving):
        if _long(one, _LEAST_S):
            text = f"holds its place: at most {np.abs(surge[slice(*one)]).max():.2f} m/s"
            found.append(_found(signals, one, "hover", text, 0.8))
    return found


def _closed(one: Range, part: Range) -> Range:
    """Take in what is left of a part beside a straight run, if it is short."""
    begin = part[0] if one[0] - part[0] < _samples(_PLATEAU_S) else one[0]
    end = part[1] if part[1] - one[1] < _samples(_PLATEAU_S) else one[1]
    return begin, end


def _straight(signals: Signals, part: Range) -> ManoeuvreFound:
    surge = np.zeros(0) if signals.surge is None else signals.surge[slice(*part)]
    speed = float(np.median(np.abs(surge)))
    turns = int((np.diff(np.sign(surge[np.abs(surge) > 0.3 * speed])) != 0).sum())
    how = f"to and fro, {turns + 1} legs" if turns else "ahead" if surge.mean() > 0 else "astern"
    return _found(signals, part, "straight", f"straight {how}, at {speed:.2f} m/s", 0.8)


def _off(signals: Signals, part: Range) -> ManoeuvreFound:
    """Name a stretch without commands by the motion that it begins with."""
    begin, end = part
    first = slice(begin, min(begin + _samples(5.0), end))
    turning = max(
        (
            float(np.abs(slope(channel)[first]).max())
            for channel in (signals.heading, signals.pitch, signals.roll)
            if channel is not None
        ),
        default=0.0,
    )
    speed = 0.0 if signals.surge is None else float(np.abs(signals.surge[first]).max())
    if turning > 3.0 * _STILL_RADPS:
        text = f"no command; it begins with {np.degrees(turning):.1f} deg/s, {speed:.2f} m/s"
        return _found(signals, part, "free_decay", text, 0.9)
    if speed > 2.0 * _STILL_MPS:
        text = f"no command; it slows down from {speed:.2f} m/s"
        return _found(signals, part, "coast_down", text, 0.9)
    return _found(signals, part, "idle", "no command and no motion", 0.9)


def _rest(whole: Range, taken: Sequence[Range]) -> Iterator[Range]:
    """Yield what of a range is not taken."""
    at = whole[0]
    for begin, end in sorted(taken):
        if begin > at:
            yield at, begin
        at = max(at, end)
    if at < whole[1]:
        yield at, whole[1]


def _found(
    signals: Signals, part: Range, name: ManoeuvreName, sentence: str, confidence: float
) -> ManoeuvreFound:
    time_s = signals.time_s
    last = time_s[-1] if part[1] >= time_s.size else time_s[part[1]]
    return ManoeuvreFound(
        name=name,
        from_s=float(np.round(time_s[part[0]], 3)),
        to_s=float(np.round(last, 3)),
        sentence=sentence,
        confidence=float(np.round(np.clip(confidence, 0.0, 1.0), 2)),
    )


def _samples(seconds: float) -> int:
    return round(seconds / PERIOD_S)


def _long(part: Range, seconds: float) -> bool:
    return part[1] - part[0] >= _samples(seconds)
