"""Find what was flown in a run: stretches of steps, turns, ramps, excitation, rest.

Where every thruster is off the vehicle idles, coasts or decays freely. Commands of many frequencies
are an excitation. Elsewhere movements one way are looked for, axis by axis; several of them near
each other are steps of that axis, turns of more than three quarters are circles and spirals. What
is left is hovering or a straight run. The limits are set to the manoeuvres of
`pipeline.simulate.manoeuvres` on the bundled vehicles.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pipeline.identify.manoeuvre_signals import (
    PERIOD_S,
    Group,
    Range,
    Signals,
    Swing,
    broadband,
    signals_of,
    slope,
    stretches,
    swings,
)
from pipeline.records.run_table import RunTable
from pipeline.records.trial import ManoeuvreFound, ManoeuvreName
from pipeline.types import FloatArray

#: A command below this share of its range is off; thrusters are if all are for so long. [s]
_OFF, _LEAST_OFF_S = 0.01, 3.0
#: Steps are taken to begin and end so long before and after they move; what is left beside them
#: belongs to them where it is shorter than that. [s]
_PLATEAU_S, _LEAST_S = 12.0, 8.0
#: Ahead or astern of this speed is under way; so is this share of the fastest of the run. [m/s]
_UNDER_WAY_MPS, _UNDER_WAY_SHARE = 0.1, 0.25
#: Pauses between legs to and fro, and the shortest leg. [s]
_PAUSE_S, _LEAST_LEG_S = 6.0, 4.0
#: What begins with less is no free decay, no coasting. [rad/s], [m/s]
_TURNING_RADPS, _COASTING_MPS = 0.03, 0.1
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


def find_manoeuvres(
    run: RunTable, code_max: FloatArray | None = None
) -> tuple[ManoeuvreFound, ...]:
    """Part a run into stretches and say what each was, in the order of time, without overlap.

    Needs commands, uses attitude (or yaw rate), velocity and depth as far as there. `code_max` (n,)
    is the largest code of each thruster; default the largest code of the run. Empty for a run
    without commands or of less than three seconds.
    """
    signals = signals_of(run, code_max)
    if signals is None:
        return ()
    time_s = signals.time_s
    off = (np.abs(signals.command) <= _OFF).all(axis=1) & signals.known
    still = [part for part in stretches(off) if _long(part, _LEAST_OFF_S)]
    found = [_off(signals, part) for part in still]
    edges = [0, *(at for part in still for at in part), time_s.size]
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        found += _driven(signals, (begin, end)) if begin < end else []
    return tuple(
        ManoeuvreFound(
            name=one.name,
            from_s=float(np.round(time_s[one.begin], 3)),
            to_s=float(np.round(time_s[min(one.end, time_s.size - 1)], 3)),
            sentence=one.sentence,
        )
        for one in sorted(found, key=lambda one: one.begin)
    )


def _long(part: Range, seconds: float) -> bool:
    return part[1] - part[0] >= round(seconds / PERIOD_S)


def _shared(one: Group, other: Group) -> int:
    """Count the samples that two groups have in common."""
    return max(min(one.end, other.end) - max(one.begin, other.begin), 0)


def _off(signals: Signals, part: Range) -> Group:
    """Name a stretch without commands by the motion that it begins with."""
    first = slice(part[0], min(part[0] + round(5.0 / PERIOD_S), part[1]))
    largest = {
        name: float(np.abs(channel if name == "surge" else slope(channel))[first].max())
        for name, channel in signals.channels.items()
    }
    turning = max(largest.get(name, 0.0) for name in ("heading", "pitch", "roll"))
    speed = largest.get("surge", 0.0)
    if turning > _TURNING_RADPS:
        text = f"no command; it begins with {np.degrees(turning):.1f} deg/s, {speed:.2f} m/s"
        return Group(*part, "free_decay", text)
    if speed > _COASTING_MPS:
        text = f"no command; it slows down from {speed:.2f} m/s"
        return Group(*part, "coast_down", text)
    return Group(*part, "idle", "no command and no motion")


def _driven(signals: Signals, part: Range) -> list[Group]:
    """Name the stretches of a part in which thrusters are commanded."""
    excited = broadband(signals, part)
    if excited is not None:
        return [excited]
    kept: list[Group] = []
    for group in _groups(signals, part):
        # one that a stronger one covers is dropped
        if sum(_shared(group, other) for other in kept) < 0.3 * (group.end - group.begin):
            kept.append(group)
    placed, left = _spread(part, kept, _PLATEAU_S, _LEAST_S)
    return placed + [group for one in left for group in _steady(signals, one)]


def _groups(signals: Signals, part: Range) -> list[Group]:
    """Find the groups of movements in a part of a run, those that explain the others first."""
    turns = []
    for axis in ("heading", "pitch", "roll"):
        for group in _movements(signals, axis, part, *_AXES[axis][:2]):
            largest = max(abs(one.change) for one in group) / _AXES[axis][1]
            if axis == "heading":
                turns.append((largest, _heading(signals, group)))
            elif len(group) >= 2:
                turns.append((largest, _steps(signals, axis, group)))
    found = _several_axes([one for _, one in sorted(turns, key=lambda one: -one[0])])
    depth = _movements(signals, "depth", part, *_AXES["depth"][:2])
    return [*found, *(_steps(signals, "depth", group) for group in depth), *_surge(signals, part)]


def _movements(
    signals: Signals, axis: str, part: Range, least_slope: float, least_change: float
) -> list[list[Swing]]:
    """Movements of an axis, put together where they are near each other."""
    groups: list[list[Swing]] = []
    channel = signals.channels.get(axis)
    for one in () if channel is None else swings(channel, part, least_slope, least_change):
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
            if _shared(group, other) > 0.5 * max(group.end - group.begin, other.end - other.begin)
        ]
        if len({other.name for other in together}) >= 3:
            begin = min(other.begin for other in together)
            text = "; ".join(other.sentence for other in together)
            mixed = Group(begin, max(other.end for other in together), "mixed", text)
            return [mixed, *_several_axes([one for one in found if one not in together])]
    return found


def _surge(signals: Signals, part: Range) -> list[Group]:
    """Ramps, or steps between different speeds; to and fro at one speed is neither."""
    speed = np.abs(signals.channels.get("surge", np.zeros(signals.time_s.size)))
    fastest = float(speed[slice(*part)].max(initial=0.0))
    least = max(_SURGE_LEAST_MPS, _SURGE_SHARE * fastest)
    groups = _movements(signals, "surge", part, _SURGE_SLOPE, least)
    moves = [one for group in groups for one in group]
    push = np.abs(signals.command).max(axis=1)
    ramps = []
    for one in moves:
        first, _, last = np.array_split(push[one.begin : one.end], 3)
        rises = speed[one.end - 1] > speed[one.begin] and last.mean() > _RISES * first.mean()
        if rises and (one.end - one.begin) * PERIOD_S >= _LEAST_RAMP_S:
            ramps.append(one)
    if ramps:
        begin, end = ramps[0].begin, moves[-1].end
        slow = [one.begin for one in moves if one.begin >= ramps[-1].end]
        text = f"surge rises along a ramp to {speed[begin:end].max():.2f} m/s"
        if len(ramps) > 1:
            return [Group(begin, end, "surge_ramp", f"{text}, {len(ramps)} times")]
        if not slow:
            return [Group(begin, end, "surge_ramp", text)]
        said = f"slows down from {speed[slow[0]]:.2f} to {speed[end - 1]:.2f} m/s"
        ramp = Group(begin, slow[0], "surge_ramp", text)
        return [ramp, Group(slow[0], end, "coast_down", said)]
    found: list[Group] = []
    for group in groups:
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


def _spread(
    part: Range, groups: Sequence[Group], room_s: float, short_s: float
) -> tuple[list[Group], list[Range]]:
    """Widen groups by the plateaus beside them; also what of the part is left.

    Neighbours meet halfway where less than `short_s` would be left between them.
    """
    room, short = round(room_s / PERIOD_S), round(short_s / PERIOD_S)
    groups = sorted(groups, key=lambda one: one.begin)
    edges, left = [part[0], *(at for one in groups for at in (one.begin, one.end)), part[1]], []
    for k in range(0, len(edges), 2):
        before, after = k > 0, k + 2 < len(edges)
        begin, end = edges[k : k + 2]
        if groups and end - begin < (before + after) * room + short:
            begin = end = (begin + end) // 2 if before and after else end if before else begin
        else:
            begin, end = begin + before * room, end - after * room
            left.append((begin, end))
        edges[k : k + 2] = begin, end
    placed = [
        replace(one, begin=begin, end=end)
        for one, begin, end in zip(groups, edges[1:-1:2], edges[2::2], strict=True)
    ]
    return placed, left


def _steady(signals: Signals, part: Range) -> list[Group]:
    """Tell hovering from straight runs, where nothing else was found."""
    if not _long(part, _LEAST_LEG_S):
        return []
    if not signals.known[slice(*part)].mean() > 0.5:
        return [Group(*part, "mixed", "the commands are not known")]
    surge = signals.channels.get("surge")
    if surge is None:
        text = "heading, attitude and depth are held; the speed was not measured"
        return [Group(*part, "hover", text)]
    limit = max(_UNDER_WAY_MPS, _UNDER_WAY_SHARE * float(np.abs(surge).max()))
    under_way = np.zeros(surge.size, np.bool_)
    under_way[slice(*part)] = np.abs(surge[slice(*part)]) > limit
    # runs to and fro pass through rest in between
    legs = stretches(under_way, round(_PAUSE_S / PERIOD_S))
    moving = []
    for leg in legs:
        own = surge[slice(*leg)]
        speed = float(np.median(np.abs(own)))
        turns = int((np.diff(np.sign(own[np.abs(own) > 0.3 * speed])) != 0).sum())
        how = f"to and fro, {turns + 1} legs" if turns else "ahead" if own.mean() > 0 else "astern"
        if _long(leg, _LEAST_LEG_S):
            moving.append(Group(*leg, "straight", f"straight {how}, at {speed:.2f} m/s"))
    found, left = _spread(part, moving, 0.0, _PLATEAU_S)
    for one in left:
        text = f"holds its place: at most {np.abs(surge[slice(*one)]).max():.2f} m/s"
        found.append(Group(*one, "hover", text))
    return found
