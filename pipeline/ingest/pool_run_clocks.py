"""Which time a reading has: the stamp in its message, or the time at which it was logged.

Stamps are preferred where they are there, move on and keep pace with the log, which comes later and
unsteadily so. A stamp of the recorder's own clock is taken as it is; one of another clock (a board
that counts from its start, a simulated time) is laid onto the time of the log by a straight line
through the median, so the median latency of such a clock stays in it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from pipeline.ingest.message_fields import NO_STAMP
from pipeline.records.pool_run import ClockRead
from pipeline.types import BoolArray, IntArray

#: A stamp that precedes its log time by no more than this is of the recorder's own clock. [s]
_MOST_LATENCY_S = 1.0
_MOST_LEAD_S = 0.05
#: A step between stamps that differs this much from that between log times is a jump. [s]
_JUMP_S = 1.0
#: A clock that drifts more is not believed.
_MOST_DRIFT = 0.02
#: Parts of fewer messages between two jumps are outliers, not a clock set anew.
_SMALLEST_SEGMENT = 5
_NORMAL = 1.4826
_MOST_JUMPS_TOLD = 3
_MOST_FITTED = 10_000


@dataclass(frozen=True)
class Timing:
    """Chosen times of a topic: `time_ns` (k,), marks (k,), and what to tell."""

    time_ns: IntArray
    clock: ClockRead
    marks: Mapping[str, BoolArray] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    line: "Segment | None" = None
    """How stamps of another clock were laid onto the log's, where one line did."""


@dataclass(frozen=True)
class Segment:
    """Line from stamps to log times: log = stamp + offset_s + drift (stamp - begin)."""

    begin: int
    end: int
    stamp_begin_ns: int
    offset_ns: int
    drift: float
    jitter_s: float

    def apply(self, stamp_ns: IntArray) -> IntArray:
        """Lay stamps onto the time of the log."""
        slow = self.drift * (stamp_ns - self.stamp_begin_ns).astype(np.float64)
        return np.asarray(stamp_ns + self.offset_ns + np.rint(slow).astype(np.int64))


def choose_time(
    log_time_ns: IntArray,
    stamp_ns: IntArray | None,
    wanted: str | None,
    expected_delay_s: float = 0.0,
) -> Timing:
    """Choose the time of a topic's messages.

    `stamp_ns` (k,) are stamps, `NO_STAMP` where there is none; `wanted` is "header", "log", "field"
    as the vehicle file says, None leaves the choice here. `expected_delay_s` is the known age of a
    reading when it is logged: so much latency is no difference of clocks.
    """
    if wanted == "log":
        return _logged(log_time_ns, "the vehicle file says so")
    if stamp_ns is None:
        return _logged(log_time_ns, "the messages have no stamp", told=wanted is not None)
    there = (stamp_ns != NO_STAMP) & (stamp_ns > 0)
    known = stamp_ns[there]
    if known.size < 0.5 * stamp_ns.size or not stamp_ns.size:
        why = "most messages have no stamp" if known.size else "the stamps are all zero"
        return _logged(log_time_ns, why, told=wanted is not None)
    if stamp_ns.size > 1 and np.ptp(log_time_ns[there]) == 0:
        why = "all its messages were logged at one time, as a topic is that was latched"
        return _logged(log_time_ns, why, told=True)
    if known.size > 2 and (known == known[0]).all():
        return _logged(log_time_ns, "the stamps never move on", told=True)
    used: Literal["header", "field"] = "field" if wanted == "field" else "header"
    return _stamped(log_time_ns, stamp_ns, there, used, expected_delay_s)


def _logged(log_time_ns: IntArray, why: str, what: str = "", *, told: bool = False) -> Timing:
    said = (f"{what or why}; the time of the log is used.",) if told else ()
    return Timing(log_time_ns, ClockRead(used="log", why=why), {}, said)


def _stamped(
    log_time_ns: IntArray,
    stamp_ns: IntArray,
    there: BoolArray,
    used: Literal["header", "field"],
    expected_delay_s: float,
) -> Timing:
    rows = np.flatnonzero(there)
    stamps, logged = stamp_ns[rows], log_time_ns[rows]
    segments, jumped = _segments(stamps, logged)
    pace = _pace(stamps, logged, segments)
    if abs(pace - 1.0) > _MOST_DRIFT:
        what = f"the stamps move on by {1.0 / pace:.4g} s in a second of the log"
        for factor in (1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9):
            if abs(pace / factor - 1.0) < _MOST_DRIFT:
                what = f"the stamps run {1.0 / factor:g} times as fast as the log: a wrong unit"
        return _logged(log_time_ns, "the stamps do not keep pace with the log", what, told=True)
    fits = [_fit(stamps, logged, ~jumped, slice(begin, end)) for begin, end in segments]
    # None of the clock's own: latency up to a second, plus what the sensor is known to take.
    own = all(
        -_MOST_LEAD_S <= fit.offset_ns / 1e9 <= _MOST_LATENCY_S + expected_delay_s for fit in fits
    )
    set_anew = [begin for begin, _ in segments[1:]]
    aligned, why = stamps, "stamps of the recorder's own clock"
    if not own:
        parts = zip(fits, np.split(stamps, set_anew), strict=True)
        aligned = np.concatenate([fit.apply(part) for fit, part in parts])
        why = "stamps of another clock, laid onto the time of the log"
    time_ns = log_time_ns.copy()
    time_ns[rows] = aligned
    age = (logged - aligned) / 1e9
    longest = max(fits, key=lambda fit: fit.end - fit.begin)
    usual = age[~jumped] if (~jumped).any() else age
    latency = float(np.median(usual))
    jitter = _NORMAL * float(np.median(np.abs(usual - latency)))
    resets = np.zeros(rows.size, np.bool_)
    resets[set_anew] = True
    warnings: list[str] = []
    for begin in set_anew[:_MOST_JUMPS_TOLD]:
        steps = ((int(one[begin]) - int(one[begin - 1])) / 1e9 for one in (stamps, logged))
        at = (int(logged[begin]) - int(log_time_ns[0])) / 1e9
        warnings.append(
            f"the clock jumps by {next(steps) - next(steps):+.3f} s at {at:.3f} s; what follows is "
            "aligned by itself."
        )
    if len(segments) > _MOST_JUMPS_TOLD + 1:
        warnings.append(f"the clock jumps {len(segments) - 1} times in all.")
    # messages that took much longer than the others
    late = age > latency + max(0.1, 10.0 * jitter)
    marks = {"no_stamp": ~there}
    for name, found in (("clock_jump", jumped), ("reset", resets), ("late", late)):
        marks[name] = np.zeros(there.size, np.bool_)
        marks[name][rows] = found
    marks = {name: mark for name, mark in marks.items() if mark.any()}
    clock = ClockRead(
        used=used,
        why=why,
        offset_s=0.0 if own else longest.offset_ns / 1e9,
        drift_ppm=1e6 * longest.drift,
        latency_s=latency if own else None,
        jitter_s=jitter,
        segments=len(segments),
    )
    line = longest if not own and len(fits) == 1 else None
    return Timing(time_ns, clock, marks, tuple(warnings), line)


def share_clocks(
    timings: Mapping[str, Timing], stamps: Mapping[str, IntArray | None]
) -> dict[str, Timing]:
    """Lay topics that one other clock stamped onto the log by one line, not by a line each.

    A line each would move topics of different latency against each other. That of the steadiest
    topic is taken for all whose offsets agree within a second.
    """
    shared = dict(timings)
    apart = {
        topic: one.line
        for topic, one in timings.items()
        if one.line is not None and one.clock.used == "header"
    }
    while apart:
        steadiest = min(apart, key=lambda topic: (timings[topic].clock.jitter_s or 0.0, topic))
        line = apart[steadiest]
        for topic in list(apart):
            timing, stamp = timings[topic], stamps[topic]
            away_s = (timing.clock.offset_s or 0.0) - line.offset_ns / 1e9
            if abs(away_s) >= _MOST_LATENCY_S:
                continue
            del apart[topic]
            if topic == steadiest or stamp is None:
                continue
            there = (stamp != NO_STAMP) & (stamp > 0)
            time_ns = timing.time_ns.copy()
            time_ns[there] = line.apply(stamp[there])
            clock = timing.clock.model_copy(
                update={
                    "why": f"stamps of another clock, laid onto the log as those of {steadiest}",
                    "offset_s": line.offset_ns / 1e9,
                    "drift_ppm": 1e6 * line.drift,
                }
            )
            shared[topic] = replace(timing, time_ns=time_ns, clock=clock, line=line)
    return shared


def _segments(stamp_ns: IntArray, log_ns: IntArray) -> tuple[list[tuple[int, int]], BoolArray]:
    """Part the messages where the clock was set anew; single wild stamps are marked, not parts."""
    count = stamp_ns.size
    apart = np.abs(np.diff(stamp_ns - log_ns)) > _JUMP_S * 1e9
    cuts = np.concatenate([[0], np.flatnonzero(apart) + 1, [count]])
    jumped = np.zeros(count, np.bool_)
    segments: list[tuple[int, int]] = []
    level: list[int] = []
    for begin, end in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        here = int(np.median((stamp_ns - log_ns)[begin:end]))
        if end - begin < min(_SMALLEST_SEGMENT, count):
            jumped[begin:end] = True
        elif segments and abs(here - level[-1]) <= _JUMP_S * 1e9:
            segments[-1] = (segments[-1][0], end)
        else:
            segments.append((begin, end))
            level.append(here)
    if not segments:
        return [(0, count)], np.zeros(count, np.bool_)
    return segments, jumped


def _pace(stamp_ns: IntArray, log_ns: IntArray, segments: list[tuple[int, int]]) -> float:
    """Seconds of the log in one second of the stamps, over all parts together."""
    stamps = float(sum(stamp_ns[end - 1] - stamp_ns[begin] for begin, end in segments))
    logged = float(sum(log_ns[end - 1] - log_ns[begin] for begin, end in segments))
    if stamps == 0 or logged == 0:
        return float("inf") if stamps == 0 else 1.0
    pace = logged / stamps
    if logged < 2e9 and 0.1 < pace < 10.0:
        return 1.0  # too short to tell drift from latency
    return pace


def _fit(stamp_ns: IntArray, log_ns: IntArray, good: BoolArray, part: slice) -> Segment:
    """Fit log - stamp = offset + drift stamp, leaving out what lies far off, until that settles."""
    chosen = good[part] if good[part].any() else ~good[part]
    # a few thousand messages settle the line as well as all of them
    rows = np.flatnonzero(chosen)[:: max(1, int(chosen.sum()) // _MOST_FITTED)]
    stamps = stamp_ns[part][rows]
    difference = log_ns[part][rows] - stamps
    level = int(np.median(difference))
    y = (difference - level) / 1e9
    x = (stamps - stamps[0]) / 1e9
    slope, constant, scale = 0.0, 0.0, 0.0
    kept = np.ones(y.size, np.bool_)
    span = float(np.ptp(x))
    for _ in range(20):
        if kept.sum() >= 10 and span >= 2.0:
            centre = x[kept].mean()
            away = x[kept] - centre
            slope = float(away @ y[kept] / max(away @ away, 1e-12))
            constant = float(y[kept].mean() - slope * centre)
        rest = y - constant - slope * x
        middle = float(np.median(rest))
        scale = _NORMAL * float(np.median(np.abs(rest - middle)))
        new = np.abs(rest - middle) <= max(3.5 * scale, 1e-6)
        if (new == kept).all():
            break
        kept = new
    # the line goes through the median, not through the mean of what was kept
    rest = y - constant - slope * x
    constant += float(np.median(rest))
    return Segment(
        part.start, part.stop, int(stamps[0]), level + round(constant * 1e9), slope, scale
    )
