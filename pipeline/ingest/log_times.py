"""Times of a log that are none: all alike, in another unit, or of a clock that was not yet set.

The stamps in the messages tell it. What is mended is told; where the stamps cannot tell what the
time was, the log is refused.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.mcap_records import LATEST_NS, SET_NS
from pipeline.ingest.message_fields import NO_STAMP
from pipeline.ingest.pool_run_extract import TopicData
from pipeline.types import BoolArray, FloatArray, IntArray

Topics = Mapping[str, TopicData]
#: Log times further than this from the median one are damage. [ns]
LONGEST_RUN_NS = 7 * 86_400 * 1e9
#: What one of another unit is worth. [ns]
_UNITS = {1e3: "microseconds", 1e6: "milliseconds", 1e9: "seconds"}
#: Messages of one topic in a second that no recorder writes.
_MOST_HZ = 4e3
#: The step in which most recorders write. [s]
_USUAL_STEP_S = 0.05
_FEW = 10
#: Where counters begin anew: ticks of the counter, or a time [ns].
_TICKS = {2**16: "after 2^16", 2**32: "after 2^32"}
_TICK_NAMES = {10**6: "ms", 10**3: "us"}
_DAY_NS = 86_400 * 10**9
_TIMES_NS = {
    3600 * 10**9: "with the hour", _DAY_NS: "at midnight", 7 * _DAY_NS: "with the week",
}  # fmt: skip


def mend_log_times(data: Topics, place: Place, said: list[Problem]) -> Topics:
    """Return the topics with log times that can be believed; what was mended is `said`.

    Raises `InputError` where all messages have one time, and no message says its own.
    """
    every = [one.log_time_ns for one in data.values() if one.log_time_ns.size]
    if not every:
        return data
    data = _with_stamps_counted_on(data, place, said)
    times = np.concatenate(every).astype(float)
    factor = _factor(data, float(np.median(times)))
    if factor != 1.0 and times.min() < times.max():
        said.append(
            place.warning(
                f"the times of the log count {_UNITS[factor]} where MCAP has nanoseconds: they "
                "were converted.",
                remedy="Mend the program that wrote the log.",
            )
        )
        worth = np.int64(factor)
        return {
            name: replace(one, log_time_ns=one.log_time_ns * worth) for name, one in data.items()
        }
    return _by_stamps(data, times, place, said)


def _with_stamps_counted_on(data: Topics, place: Place, said: list[Problem]) -> Topics:
    """Count on the stamps of boards whose counters of milli- or microseconds begin anew."""
    mended, anew = dict(data), []
    for topic, one in data.items():
        stamps = _stamps(one)
        there = np.flatnonzero(stamps != NO_STAMP)
        for tick_ns in (10**6, 10**3):
            counted, how = counted_on(stamps[there], tick_ns)
            if how:
                stamps[there] = counted
                mended[topic] = replace(one, stamp_ns=stamps)
                anew.append(f"{topic} {how} {_TICK_NAMES[tick_ns]}")
                break
    if anew:
        said.append(place.note(f"stamps begin anew ({', '.join(anew)}): they were counted on."))
    return mended


def counted_on(time_ns: IntArray, tick_ns: int) -> tuple[IntArray, str]:
    """Return the times of a counter that begins anew, counted on, and where it begins anew.

    Of 16 or 32 bits of `tick_ns` each, or of the hour, the day, the week. Other falls are left.

    >>> counted_on(np.array([65534, 65535, 0, 1]) * 1000000, 1000000)[0].tolist()[2:]
    [65536000000, 65537000000]
    """
    step = np.diff(time_ns)
    falls = np.flatnonzero(step < 0)
    usual = np.abs(step[step > 0])
    if not falls.size or not usual.size:
        return time_ns, ""
    most = max(3 * int(np.quantile(usual, 0.99)), tick_ns)
    for whole, how in {**{n * tick_ns: said for n, said in _TICKS.items()}, **_TIMES_NS}.items():
        again = step[falls] + whole
        if ((again >= 0) & (again <= most)).all():
            return time_ns + whole * np.searchsorted(falls, np.arange(time_ns.size)), how
    return time_ns, ""


def _stamps(one: TopicData) -> IntArray:
    """Return the stamps (k,) of a topic, `NO_STAMP` where there is none."""
    if one.stamp_ns is None:
        return np.full(one.log_time_ns.size, NO_STAMP)
    return np.where(one.stamp_ns > 0, one.stamp_ns, NO_STAMP)


def _by_stamps(data: Topics, times: FloatArray, place: Place, said: list[Problem]) -> Topics:
    """Take the stamps of messages whose times of the log are none, if they are of the run.

    Those of a topic, or of all, are alike; or some are days from the others: a clock was not set.
    """
    are_alike = times.size >= _FEW and times.min() == times.max()
    of_today = times[(times >= SET_NS) & (times < LATEST_NS)]
    # most of a run may be over when the clock is set; a single wild time is no clock
    is_set = of_today.size >= max(_FEW, 0.05 * times.size)
    middle = float(np.median(of_today if is_set else times))
    mended, how = dict(data), []
    for topic, one in data.items():
        logged, stamps, usual_ns = one.log_time_ns, _stamps(one), 0.0
        there = stamps != NO_STAMP
        if not there.any():
            continue
        begin, end = int(stamps[there].min()), int(stamps[there].max())
        inside = times.min() - 1e9 <= stamps.min() and end <= times.max() + 1e9
        at_once = logged.size >= _FEW and np.ptp(logged) == 0 and begin < end and inside
        none, what = _is_far(logged, middle), "were logged days from the others"
        if are_alike or at_once:
            none = np.full(logged.size, begin < end)
            what = f"were logged at one time ({logged[0]} ns)"
        else:
            there &= ~_is_far(stamps, middle)
            late_ns = (logged - stamps)[there & ~none]
            usual_ns = float(np.median(late_ns)) if late_ns.size else 0.0
        rows = there & none
        # stamps of another clock do not tell the time of the log
        if rows.any() and abs(usual_ns) <= 1e9:
            mended[topic] = replace(
                one, log_time_ns=np.where(rows, stamps + np.int64(usual_ns), logged)
            )
            how.append(f"{int(rows.sum())} of {rows.size} messages of {topic} {what}")
    lost = sorted(topic for topic in data if mended[topic] is data[topic]) if are_alike else []
    if are_alike and not how:
        raise InputError.at(
            place,
            f"all messages were logged at one time ({int(times[0])} ns), and none has a stamp of "
            "its own.",
            expected="messages that tell when they were measured.",
            remedy="Record them anew with a recorder whose clock runs, or with stamps.",
        )
    if how:
        of_lost = (
            f" {', '.join(lost)} carry no stamps and cannot be placed in time." if lost else ""
        )
        said.append(
            place.warning(
                f"{', '.join(how)}: their stamps are taken for the times of the log.{of_lost}",
                remedy="Check the recorder's clock.",
            )
        )
    return mended


def _factor(data: Topics, middle_ns: float) -> float:
    """Return what one of the log's times is worth in nanoseconds."""
    if middle_ns >= SET_NS:
        return 1.0
    stamps = [_stamps(one) for one in data.values()]
    known = np.concatenate([one[one != NO_STAMP] for one in stamps])
    is_of_today = bool(known.size) and SET_NS < float(np.median(known)) < LATEST_NS
    busiest = max(data.values(), key=lambda one: one.log_time_ns.size).log_time_ns
    # messages come faster than any recorder writes them
    too_fast = busiest.size > max(_FEW, _MOST_HZ * float(np.ptp(busiest)) / 1e9)
    paces = [pace for one in data.values() if (pace := _pace(one)) is not None]
    for factor in _UNITS:
        agree = [abs(pace / factor - 1.0) < slack for pace, slack in paces]
        if agree:
            # the stamps have to be of this century where the log's times are of none
            if all(agree) and (SET_NS < middle_ns * factor < LATEST_NS or is_of_today):
                return factor
        elif too_fast and SET_NS < middle_ns * factor < LATEST_NS:
            return factor
    if too_fast and not paces and np.ptp(busiest):  # counted from the start of the run
        step_s = float(np.ptp(busiest)) / busiest.size / 1e9
        return min(_UNITS, key=lambda factor: abs(np.log10(step_s * factor / _USUAL_STEP_S)))
    return 1.0


def _pace(one: TopicData) -> tuple[float, float] | None:
    """Return nanoseconds of the stamps in one of the log's, and how well that can be told."""
    stamps = _stamps(one)
    there = stamps != NO_STAMP
    if there.sum() < _FEW:
        return None
    logged = float(np.ptp(one.log_time_ns[there]))
    if logged <= 0.0:
        return None
    return float(np.ptp(stamps[there])) / logged, 0.02 + 1.5 / logged


def _is_far(time_ns: IntArray, middle_ns: float) -> BoolArray:
    # as floats: the difference of two wild times may not fit into 64 bits
    return np.asarray(np.abs(time_ns.astype(float) - middle_ns) > LONGEST_RUN_NS)
