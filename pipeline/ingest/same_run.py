"""Logs that hold one run twice: a copy, a part, a conversion, two recorders of one vehicle."""

from collections.abc import Iterator, Mapping

from pipeline.records.pool_run import ChannelSummary, PoolRunRecord

#: Starts and lengths of one run agree to this, whatever its recorders were. [s]
_CLOSE_S = 2.0
#: Extremes of a channel agree to this share of its range, which the formats may round; those that
#: are one reading agree to that.
_CLOSE, _SAME = 0.02, 1e-5
_LEAST_CHANNELS = 2
#: Columns of noise whose extremes are the same readings, for so large a share, are of one run
#: whatever the clocks say.
_LEAST_COLUMNS, _LEAST_SAME = 4, 0.25

_Range = tuple[float, float]


def repeated_runs(runs: Mapping[str, PoolRunRecord]) -> dict[str, str]:
    """Find logs that hold the run of another: the name of each copy -> the log that counts.

    That is the longer one, of equals the first by name. A vehicle makes one run at a time; but
    clocks that nobody set make all runs begin alike, so the readings are compared too: the extremes
    of every channel that both have, some of which moves.
    """
    copies: dict[str, str] = {}
    for name in sorted(runs):
        for earlier in [one for one in sorted(runs) if one < name and one not in copies]:
            if not _is_one_run(runs[earlier], runs[name]):
                continue
            if runs[name].duration_s > runs[earlier].duration_s + _CLOSE_S:
                copies |= {one: name for one in copies if copies[one] == earlier}
                copies[earlier] = name
            else:
                copies[name] = earlier
                break
    return copies


def _is_one_run(one: PoolRunRecord, other: PoolRunRecord) -> bool:
    apart_s = abs(one.start_time_ns - other.start_time_ns) / 1e9
    longer_by_s = abs(one.duration_s - other.duration_s)
    theirs = {column: found for channel in other.channels for column, found in _ranges(channel)}
    shared = {
        column: (found, theirs[column])
        for channel in one.channels
        for column, found in _ranges(channel)
        if column in theirs
    }
    moving = {column: (a, b) for column, (a, b) in shared.items() if max(a[1] - a[0], b[1] - b[0])}
    if max(apart_s, longer_by_s) <= _CLOSE_S:
        return len(moving) >= _LEAST_CHANNELS and all(
            away <= _CLOSE for a, b in moving.values() for away in _off(a, b)
        )
    measured = [
        (a, b) if one.duration_s >= other.duration_s else (b, a)
        for column, (a, b) in moving.items()
        if not column.startswith("command.")
    ]
    inside = all(
        b[0] >= a[0] - _CLOSE * (a[1] - a[0]) and b[1] <= a[1] + _CLOSE * (a[1] - a[0])
        for a, b in measured
    )
    same = [away <= _SAME for a, b in measured for away in _off(a, b, of_noise=True)]
    return len(measured) >= _LEAST_COLUMNS and inside and sum(same) >= _LEAST_SAME * len(same)


def _off(one: _Range, other: _Range, *, of_noise: bool = False) -> Iterator[float]:
    """Yield by what share of their range the ends of two ranges differ; none is equal at 0."""
    width = max(one[1] - one[0], other[1] - other[0])
    for a, b in zip(one, other, strict=True):
        yield float("inf") if of_noise and a == b == 0.0 else abs(a - b) / width


def _ranges(channel: ChannelSummary) -> list[tuple[str, _Range]]:
    """Return the extremes of each column that has numbers; of an attitude either sign is meant."""
    if "attitude" in channel.name:
        return []
    return [
        (column, (low, high))
        for column, low, high in zip(channel.columns, channel.lowest, channel.highest, strict=True)
        if low is not None and high is not None
    ]
