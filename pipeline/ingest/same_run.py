"""Logs that hold one run twice: a copy, a conversion, two recorders of one vehicle."""

from collections.abc import Mapping

from pipeline.records.pool_run import ChannelSummary, PoolRunRecord

#: Starts and lengths of one run agree to this, whatever its recorders were. [s]
_CLOSE_S = 2.0
#: Extremes of a channel agree to this share of its range, which the formats may round.
_CLOSE = 0.02
_LEAST_CHANNELS = 2


def repeated_runs(runs: Mapping[str, PoolRunRecord]) -> dict[str, str]:
    """Find logs that hold the run of another: the name of each copy -> the first such log by name.

    A vehicle makes one run at a time; but clocks that nobody set make all runs begin alike, so the
    readings are compared too: the extremes of every channel that both have, some of which moves.
    """
    copies: dict[str, str] = {}
    names = sorted(runs)
    for number, name in enumerate(names):
        for earlier in names[:number]:
            if earlier not in copies and _is_one_run(runs[earlier], runs[name]):
                copies[name] = earlier
                break
    return copies


def _is_one_run(one: PoolRunRecord, other: PoolRunRecord) -> bool:
    apart_s = abs(one.start_time_ns - other.start_time_ns) / 1e9
    if max(apart_s, abs(one.duration_s - other.duration_s)) > _CLOSE_S:
        return False
    theirs = {column: found for channel in other.channels for column, found in _ranges(channel)}
    shared = [
        (found, theirs[column])
        for channel in one.channels
        for column, found in _ranges(channel)
        if column in theirs
    ]
    moving = [(a, b) for a, b in shared if a[1] > a[0]]
    return len(moving) >= _LEAST_CHANNELS and all(
        max(abs(a[0] - b[0]), abs(a[1] - b[1])) <= _CLOSE * (a[1] - a[0]) + 1e-9 for a, b in moving
    )


def _ranges(channel: ChannelSummary) -> list[tuple[str, tuple[float, float]]]:
    """Return the extremes of each column that has numbers; of an attitude either sign is meant."""
    if "attitude" in channel.name:
        return []
    return [
        (column, (low, high))
        for column, low, high in zip(channel.columns, channel.lowest, channel.highest, strict=True)
        if low is not None and high is not None
    ]
