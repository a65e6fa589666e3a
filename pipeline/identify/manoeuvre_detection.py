"""Find what was flown in a run: stretches of steps, turns, ramps, excitation, rest.

Where every thruster is off the vehicle idles, coasts or decays freely. Commands of many frequencies
are an excitation. Elsewhere movements one way are looked for, axis by axis; several of them near
each other are steps of that axis, turns of more than three quarters are circles and spirals. What
is left is hovering or a straight run. The limits are set to the manoeuvres of
`pipeline.simulate.manoeuvres` on the bundled vehicles.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pipeline.records.run_table import Range, RunTable, angles, stretches
from pipeline.records.trial import ManoeuvreFound, ManoeuvreName
from pipeline.types import BoolArray, FloatArray

#: Everything is looked at every 0.1 s, smoothed over 1 s, with slopes over 2 s. [s]
PERIOD_S, _SMOOTH, _SLOPE_S = 0.1, 10, 2.0
#: A channel that is valid for less of the run is not used.
_LEAST_VALID = 0.3
#: A command below this share of its range is off; thrusters are if all are for so many samples.
_OFF, _LEAST_OFF = 0.01, 30
#: Steps begin and end so many samples before and after they move; what is left beside them belongs
#: to them where it is shorter than that.
_PLATEAU, _LEAST = 120, 80
#: Ahead or astern of this speed is under way; so is this share of the fastest of the run. [m/s]
_UNDER_WAY_MPS, _UNDER_WAY_SHARE = 0.1, 0.25
#: Samples of a pause between legs to and fro, and of the shortest leg.
_PAUSE, _LEAST_LEG = 60, 40
#: What begins with less is no free decay, no coasting. [deg/s], [m/s]
_TURNING_DEGPS, _COASTING_MPS = 1.7, 0.1
#: Axis -> slope above which it moves and smallest change that counts ([deg/s], [deg]; [m/s], [m]),
#: what its steps are called, and their unit.
_AXES: dict[str, tuple[float, float, ManoeuvreName, str]] = {
    "heading": (0.7, 5.0, "heading_steps", "deg"),
    "pitch": (0.5, 3.0, "pitch_steps", "deg"),
    "roll": (0.7, 4.0, "roll_steps", "deg"),
    "depth": (0.025, 0.2, "heave_steps", "m"),
}
#: A step of surge: slope [m/s2], change as a share of the fastest, and at least [m/s].
_SURGE_SLOPE, _SURGE_SHARE, _SURGE_LEAST_MPS = 0.02, 0.18, 0.07
#: Speed that rises for so many samples rises along a ramp where the commands of the last third are
#: so much larger than those of the first. [1]
_LEAST_RAMP, _RISES = 75, 1.3
#: Movements of an axis with more samples between them do not belong together.
_LONGEST_PAUSE = 400
#: One turn this way is a circle; as much each way a spiral.
_CIRCLE_DEG, _SPIRAL_DEG = 270.0, 150.0
#: Excitation: least size of the commands, how evenly their power is spread between 0.02 and 0.6 Hz
#: (a controller that feeds one sine through is none), its share above 0.1 Hz at least and above
#: 1 Hz (noise that is fed through) at most, and a jump from one sample to the next.
_LEAST_SIZE, _LEAST_EVEN, _LEAST_FAST, _MOST_NOISY, _JUMP = 0.08, 0.78, 0.55, 0.12, 0.1


@dataclass(frozen=True)
class _Signals:
    """A run every 0.1 s.

    `channels` (m,) are heading (continuous), pitch, roll [deg], surge [m/s] and depth [m], those
    that were measured, smoothed. `command` (m, n) is each code as a share of its range, `known`
    (m,) where the commands are known.
    """

    time_s: FloatArray
    command: FloatArray
    known: BoolArray
    channels: Mapping[str, FloatArray]


@dataclass(frozen=True)
class _Group:
    """Samples `begin` to `end`, what they are, and their largest movement in those that count."""

    begin: int
    end: int
    name: ManoeuvreName
    sentence: str
    size: float = 0.0

    def shared(self, other: "_Group") -> int:
        """Count the samples that two groups have in common."""
        return max(min(self.end, other.end) - max(self.begin, other.begin), 0)


def find_manoeuvres(
    run: RunTable, code_max: FloatArray | None = None
) -> tuple[ManoeuvreFound, ...]:
    """Part a run into stretches and say what each was, in the order of time, without overlap.

    Needs commands, uses attitude (or yaw rate), velocity and depth as far as there. `code_max` (n,)
    is the largest code of each thruster; default the largest code of the run. Empty for a run
    without commands or of less than three seconds.
    """
    signals = _signals_of(run, code_max)
    if signals is None:
        return ()
    time_s = signals.time_s
    off = (np.abs(signals.command) <= _OFF).all(axis=1) & signals.known
    still = [part for part in stretches(off) if part[1] - part[0] >= _LEAST_OFF]
    found = [_off(signals, part) for part in still]
    edges = [0, *(at for part in still for at in part), time_s.size]
    for part in zip(edges[::2], edges[1::2], strict=True):
        found += _driven(signals, part) if part[0] < part[1] else []
    return tuple(
        ManoeuvreFound(
            name=one.name,
            from_s=float(np.round(time_s[one.begin], 3)),
            to_s=float(np.round(time_s[min(one.end, time_s.size - 1)], 3)),
            sentence=one.sentence,
        )
        for one in sorted(found, key=lambda one: one.begin)
    )


def _signals_of(run: RunTable, code_max: FloatArray | None) -> _Signals | None:
    """Bring a run to the form that is looked at; None where it has no commands or is too short."""
    from scipy.ndimage import uniform_filter1d

    if "command" not in run.values or run.time_s.size < 2 or run.time_s[-1] < _LEAST_OFF * PERIOD_S:
        return None
    time_s = np.arange(0.0, float(run.time_s[-1]) + 1e-9, PERIOD_S)
    index = np.clip(np.searchsorted(run.time_s, time_s - 1e-9), 0, run.time_s.size - 1)
    command = run.values["command"][index]
    known = run.valid["command"][index] & np.isfinite(command).all(axis=1)
    command = np.where(known[:, None], command, 0.0)
    size = np.abs(command).max(initial=0.0) if code_max is None else code_max
    found: dict[str, FloatArray] = {}
    for quantity in ("angular_velocity", "attitude", "velocity", "position", "depth"):
        if quantity not in run.values or (good := run.trusted(quantity)).mean() < _LEAST_VALID:
            continue
        values, at_s = run.values[quantity][good], run.time_s[good]
        if quantity == "attitude":
            values = np.degrees(np.unwrap(angles(values), axis=0))
        # bridged on a line where there is nothing
        values = np.stack([np.interp(time_s, at_s, one) for one in values.T], axis=1)
        values = uniform_filter1d(values, _SMOOTH, axis=0, mode="nearest")
        if quantity == "angular_velocity":
            # the heading alone, where the yaw rate is all there is
            rate = np.degrees(values[:, 2])
            found["heading"] = PERIOD_S * np.cumsum(rate - np.median(rate))
        elif quantity == "attitude":
            found |= dict(zip(("roll", "pitch", "heading"), values.T, strict=True))
        else:
            name, column = ("surge", 0) if quantity == "velocity" else ("depth", -1)
            found[name] = values[:, column]
    return _Signals(time_s, command / np.maximum(size, 1e-9), known, found)


def _slope(values: FloatArray) -> FloatArray:
    """Change a second over two seconds around each sample (m,)."""
    half = round(_SLOPE_S / PERIOD_S / 2)
    padded = np.pad(values, half, mode="edge")
    return np.asarray((padded[2 * half :] - padded[: -2 * half]) / _SLOPE_S)


def _off(signals: _Signals, part: Range) -> _Group:
    """Name a stretch without commands by the motion that it begins with."""
    first = slice(part[0], min(part[0] + 50, part[1]))
    largest = {
        name: float(np.abs(channel if name == "surge" else _slope(channel))[first].max())
        for name, channel in signals.channels.items()
    }
    turning = max(largest.get(name, 0.0) for name in ("heading", "pitch", "roll"))
    speed = largest.get("surge", 0.0)
    if turning > _TURNING_DEGPS:
        text = f"no command; it begins with {turning:.1f} deg/s, {speed:.2f} m/s"
        return _Group(*part, "free_decay", text)
    if speed > _COASTING_MPS:
        return _Group(*part, "coast_down", f"no command; it slows down from {speed:.2f} m/s")
    return _Group(*part, "idle", "no command and no motion")


def _driven(signals: _Signals, part: Range) -> list[_Group]:
    """Name the stretches of a part in which thrusters are commanded."""
    excited = _excitation(signals.command[slice(*part)])
    moves = [
        axis
        for axis, one in signals.channels.items()
        if (np.abs(_slope(one[slice(*part)])) > _AXES.get(axis, [_SURGE_SLOPE])[0]).mean() > 0.5
    ]
    if excited is not None and moves:
        text = f"commands of many frequencies; {', '.join(moves)} move"
        return [_Group(*part, excited, text)]
    turns = [one for axis in ("heading", "pitch", "roll") for one in _groups(signals, axis, part)]
    turns.sort(key=lambda one: -one.size)
    kept: list[_Group] = []
    for one in (*_mixed(turns), *_groups(signals, "depth", part), *_surge(signals, part)):
        # one that a stronger one covers is dropped
        if sum(map(one.shared, kept)) < 0.3 * (one.end - one.begin):
            kept.append(one)
    placed, left = _spread(part, kept, _PLATEAU, _LEAST)
    return placed + [group for one in left for group in _steady(signals, one)]


def _excitation(command: FloatArray) -> ManoeuvreName | None:
    """Tell whether commands (m, n) are an excitation, and which."""
    varied, steps = command - command.mean(axis=0), np.abs(np.diff(command, axis=0))
    if len(command) < 100 or varied.std(axis=0).max() < _LEAST_SIZE:
        return None
    if (steps <= 0.2 * _JUMP).all(axis=1).mean() > 0.6 and (steps > _JUMP).any(
        axis=1
    ).mean() < 0.04:
        # steps of a pilot: held for most of the time, with few jumps
        return None
    frequency, power = _spectrum(varied)
    band = power[(frequency > 0.02) & (frequency < 0.6)]
    band = band / max(float(band.sum()), 1e-12)
    # entropy of the spectrum: 1 where every line is as strong, near 0 for one line
    even = -float(band @ np.log(band + 1e-12)) / np.log(max(band.size, 2))
    fast, noisy = (power[frequency > edge].sum() for edge in (0.1, 1.0))
    if even < _LEAST_EVEN or fast < _LEAST_FAST or noisy > _MOST_NOISY:
        return None
    step = steps[:, int(np.argmax(varied.std(axis=0)))]
    if step[step > _JUMP].sum() > 0.6 * step.sum() and (step <= _OFF).mean() > 0.35:
        # nearly all of the change is in a few jumps
        return "prbs"
    middle = [float(np.dot(*_spectrum(quarter))) for quarter in np.array_split(varied, 4)]
    rising = all(b > 1.1 * a for a, b in pairwise(middle)) and middle[3] > 2.0 * middle[0]
    return "chirp" if rising else "multisine"


def _spectrum(varied: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequencies (k,) [Hz] and shares of the power (k,), all thrusters, less a line each."""
    from scipy.signal import detrend

    rest = np.hanning(len(varied))[:, None] * detrend(varied, axis=0)
    power = (np.abs(np.fft.rfft(rest, axis=0)) ** 2).sum(axis=1)
    frequency = np.fft.rfftfreq(len(rest), PERIOD_S)
    return np.asarray(frequency, float), power / max(float(power.sum()), 1e-12)


def _movements(
    channel: FloatArray | None, part: Range, slope: float, least: float
) -> list[list[Range]]:
    """Movements one way, faster than a slope and further than `least`, together where near."""
    if channel is None:
        return []
    values = channel[slice(*part)]
    speed = _slope(values)
    found = sorted(
        (part[0] + begin, part[0] + end)
        for sign in (1.0, -1.0)
        for begin, end in stretches(sign * speed > slope, 8)
        if sign * (values[end - 1] - values[begin]) >= least
    )
    groups: list[list[Range]] = []
    for one in found:
        if groups and one[0] - groups[-1][-1][1] <= _LONGEST_PAUSE:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def _groups(signals: _Signals, axis: str, part: Range) -> Iterator[_Group]:
    """Find the steps of an axis; of the heading also circles, spirals and zig-zags."""
    slope, least, name, unit = _AXES[axis]
    for moves in _movements(signals.channels.get(axis), part, slope, least):
        begin, end = moves[0][0], moves[-1][1]
        channel = signals.channels[axis]
        changes = np.array([channel[last - 1] - channel[first] for first, last in moves])
        largest = float(np.abs(changes).max())
        low, high = channel[begin:end].min(), channel[begin:end].max()
        times = "1 movement" if len(moves) == 1 else f"{len(moves)} movements"
        called, text = name, f"{times} of {axis} between {low:.3g} and {high:.3g} {unit}"
        if axis == "heading":
            called, text = _turn(signals, (begin, end), changes, text)
        elif axis != "depth" and len(moves) < 2:
            continue
        yield _Group(begin, end, called, text, largest / least)


def _turn(
    signals: _Signals, part: Range, changes: FloatArray, steps: str
) -> tuple[ManoeuvreName, str]:
    """Name movements of the heading [deg]; what is said of them, of `steps` if they are no more."""
    starboard, port = float(changes[changes > 0].sum()), -float(changes[changes < 0].sum())
    largest, (less, more) = float(np.abs(changes).max()), sorted((starboard, port))
    surge = signals.channels.get("surge")
    speed = 0.0 if surge is None else float(np.median(np.abs(surge[slice(*part)])))
    at = ", at a speed not measured" if surge is None else f", at {speed:.2f} m/s"
    swings = int((changes[1:] * changes[:-1] < 0).sum())
    if min(less, largest) > _SPIRAL_DEG:
        return "spiral", f"turns {starboard:.0f} deg to starboard and {port:.0f} to port{at}"
    if more > _CIRCLE_DEG and less < 0.2 * more:
        return (
            "circle",
            f"turns {more:.0f} deg to {'starboard' if starboard > port else 'port'}{at}",
        )
    if swings >= 2 and speed > _UNDER_WAY_MPS:
        text = f"heading swings {swings} times to the other side, by up to {largest:.0f} deg"
        return "zig_zag", text + at
    return "heading_steps", steps + at


def _mixed(found: list[_Group]) -> list[_Group]:
    """Put groups of three axes that go on together into one that is mixed."""
    for group in found:
        together = [
            other
            for other in found
            if group.shared(other) > 0.5 * max(group.end - group.begin, other.end - other.begin)
        ]
        if len({other.name for other in together}) >= 3:
            begin, end = min(one.begin for one in together), max(one.end for one in together)
            mixed = _Group(begin, end, "mixed", "; ".join(other.sentence for other in together))
            return [mixed, *_mixed([one for one in found if one not in together])]
    return found


def _surge(signals: _Signals, part: Range) -> Iterator[_Group]:
    """Ramps, or steps between different speeds; to and fro at one speed is neither."""
    speed = np.abs(signals.channels.get("surge", np.zeros(signals.time_s.size)))
    fastest = float(speed[slice(*part)].max(initial=0.0))
    least = max(_SURGE_LEAST_MPS, _SURGE_SHARE * fastest)
    groups = _movements(signals.channels.get("surge"), part, _SURGE_SLOPE, least)
    push = np.abs(signals.command).max(axis=1)
    moves, ramps = [one for group in groups for one in group], []
    for begin, end in moves:
        first, _, last = np.array_split(push[begin:end], 3)
        rises = speed[end - 1] > speed[begin] and last.mean() > _RISES * first.mean()
        if rises and end - begin >= _LEAST_RAMP:
            ramps.append((begin, end))
    if ramps:
        begin, end = ramps[0][0], moves[-1][1]
        slow = [one[0] for one in moves if one[0] >= ramps[-1][1]] if len(ramps) == 1 else []
        text = f"surge rises along a ramp to {speed[begin:end].max():.2f} m/s"
        text += f", {len(ramps)} times" if len(ramps) > 1 else ""
        yield _Group(begin, slow[0] if slow else end, "surge_ramp", text)
        if slow:
            said = f"slows down from {speed[slow[0]]:.2f} to {speed[end - 1]:.2f} m/s"
            yield _Group(slow[0], end, "coast_down", said)
        return
    for group in groups:
        # between movements the vehicle keeps a speed; the last is kept to the end of the part
        end = group[-1][1]
        edges = [*(one[0] for one in group[1:]), min(end + 30, part[1])]
        levels = [
            float(np.median(speed[one[1] - 1 : max(edge, one[1])]))
            for one, edge in zip(group, edges, strict=True)
        ]
        under_way = [level for level in levels if level > 0.12 * fastest]
        if len(group) > 1 and under_way and max(under_way) - min(under_way) > 0.2 * fastest:
            text = f"steps of speed: {', '.join(f'{level:.2f}' for level in levels[:8])} m/s"
            yield _Group(group[0][0], end, "surge_steps", text)


def _spread(
    part: Range, groups: Sequence[_Group], room: int, short: int
) -> tuple[list[_Group], list[Range]]:
    """Widen groups by so much `room` each way; also what of the part is left.

    Neighbours meet halfway where less than `short` would be left between them.
    """
    groups = sorted(groups, key=lambda one: one.begin)
    edges, left = [part[0], *(at for one in groups for at in (one.begin, one.end)), part[1]], []
    for k in range(0, len(edges), 2):
        before, after = k > 0, k + 2 < len(edges)
        begin, end = edges[k : k + 2]
        if groups and end - begin < (before + after) * room + short:
            begin = end = begin + (end - begin) * before // (before + after)
        else:
            begin, end = begin + before * room, end - after * room
            left.append((begin, end))
        edges[k : k + 2] = begin, end
    spans = zip(groups, edges[1:-1:2], edges[2::2], strict=True)
    return [replace(one, begin=begin, end=end) for one, begin, end in spans], left


def _steady(signals: _Signals, part: Range) -> list[_Group]:
    """Tell hovering from straight runs, where nothing else was found."""
    if part[1] - part[0] < _LEAST_LEG:
        return []
    if not signals.known[slice(*part)].mean() > 0.5:
        return [_Group(*part, "mixed", "the commands are not known")]
    surge = signals.channels.get("surge")
    if surge is None:
        text = "heading, attitude and depth are held; the speed was not measured"
        return [_Group(*part, "hover", text)]
    limit = max(_UNDER_WAY_MPS, _UNDER_WAY_SHARE * float(np.abs(surge).max()))
    moving = []
    # runs to and fro pass through rest in between
    for begin, end in stretches(np.abs(surge[slice(*part)]) > limit, _PAUSE):
        leg = surge[part[0] + begin : part[0] + end]
        speed = float(np.median(np.abs(leg)))
        turns = int((np.diff(np.sign(leg[np.abs(leg) > 0.3 * speed])) != 0).sum())
        how = f"to and fro, {turns + 1} legs" if turns else "ahead" if leg.mean() > 0 else "astern"
        text = f"straight {how}, at {speed:.2f} m/s"
        if end - begin >= _LEAST_LEG:
            moving.append(_Group(part[0] + begin, part[0] + end, "straight", text))
    found, left = _spread(part, moving, 0, _PLATEAU)
    for one in left:
        fastest = np.abs(surge[slice(*one)]).max()
        found.append(_Group(*one, "hover", f"holds its place: at most {fastest:.2f} m/s"))
    return found
