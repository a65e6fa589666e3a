"""Find what was flown in a run: stretches of steps, turns, ramps, excitation, rest.

Where every thruster is off the vehicle idles, coasts or decays freely. Commands of many frequencies
are an excitation. Elsewhere movements one way are looked for, axis by axis (heading, pitch, roll,
depth, surge); several of them near each other are steps of that axis, turns of more than three
quarters are circles and spirals. What is left is hovering or a straight run. The limits are set to
the manoeuvres of `pipeline.simulate.manoeuvres` on the bundled vehicles.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pipeline.identify.manoeuvre_kinds import Group, broadband, groups_of
from pipeline.identify.manoeuvre_signals import (
    PERIOD_S,
    Range,
    Signals,
    signals_of,
    slope,
    stretches,
)
from pipeline.records.run_table import RunTable
from pipeline.records.trial import ManoeuvreFound
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
    return tuple(_told(signals, one) for one in sorted(found, key=lambda one: one.begin))


def _driven(signals: Signals, part: Range) -> list[Group]:
    """Name the stretches of a part in which thrusters are commanded."""
    excited = broadband(signals, part)
    if excited is not None:
        return [excited]
    placed, left = _spread(part, _chosen(groups_of(signals, part)), _PLATEAU_S, _LEAST_S)
    for one in left:
        placed += _steady(signals, one)
    return placed


def _chosen(groups: Sequence[Group]) -> list[Group]:
    """Drop groups that a stronger one covers; `groups` come strongest first."""
    kept: list[Group] = []
    for group in groups:
        covered = sum(
            max(min(group.end, other.end) - max(group.begin, other.begin), 0) for other in kept
        )
        if covered < 0.3 * (group.end - group.begin):
            kept.append(group)
    return kept


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
    moving = [_straight(surge, one) for one in legs if _long(one, _LEAST_LEG_S)]
    found, left = _spread(part, moving, 0.0, _PLATEAU_S)
    for one in left:
        text = f"holds its place: at most {np.abs(surge[slice(*one)]).max():.2f} m/s"
        found.append(Group(*one, "hover", text))
    return found


def _straight(channel: FloatArray, part: Range) -> Group:
    surge = channel[slice(*part)]
    speed = float(np.median(np.abs(surge)))
    turns = int((np.diff(np.sign(surge[np.abs(surge) > 0.3 * speed])) != 0).sum())
    how = f"to and fro, {turns + 1} legs" if turns else "ahead" if surge.mean() > 0 else "astern"
    return Group(*part, "straight", f"straight {how}, at {speed:.2f} m/s")


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


def _rest(whole: Range, taken: Sequence[Range]) -> Iterator[Range]:
    """Yield what of a range is not taken."""
    at = whole[0]
    for begin, end in sorted(taken):
        if begin > at:
            yield at, begin
        at = max(at, end)
    if at < whole[1]:
        yield at, whole[1]


def _told(signals: Signals, one: Group) -> ManoeuvreFound:
    time_s = signals.time_s
    return ManoeuvreFound(
        name=one.name,
        from_s=float(np.round(time_s[one.begin], 3)),
        to_s=float(np.round(time_s[min(one.end, time_s.size - 1)], 3)),
        sentence=one.sentence,
    )


def _long(part: Range, seconds: float) -> bool:
    return part[1] - part[0] >= round(seconds / PERIOD_S)
