"""Channels that no window of a fit has: slower than stated, or with most of their readings lost."""

from collections.abc import Sequence

import numpy as np

from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.windows import FASTEST_HZ, SMALLEST_SHARE, readings_of
from pipeline.records.run_table import RunTable

#: Readings that get lost here and there leave this share of the gaps as short as the sensor's own.
_SHORT_GAPS = 0.2


def notes_on_unused(
    runs: Sequence[RunTable], channels: Sequence[ChannelNoise], used: set[str]
) -> tuple[str, ...]:
    """Say which channels were measured and not used, and what to do about each.

    `channels` are what the fit has a sensor for, with the rate expected of it; `used` what some
    window has.
    """
    slow, lost = [], []
    for channel in channels:
        if channel.quantity in used:
            continue
        seconds, count, rate_hz = _found(runs, channel)
        expected = f"{channel.rate_hz:g} Hz expected"
        if rate_hz < SMALLEST_SHARE * min(channel.rate_hz, FASTEST_HZ):
            slow.append(f"{channel.quantity} ({rate_hz:.2g} Hz in these runs, {expected})")
        else:
            share = count / max(channel.rate_hz * seconds, 1e-9)
            lost.append(f"{channel.quantity} ({100 * share:.0f} % of the readings, {expected})")
    why = (
        "A window goes without a channel that has less than "
        f"{100 * SMALLEST_SHARE:.0f} % of the readings that its rate promises"
    )
    notes = []
    if slow:
        notes.append(
            f"Measured, but not used: {', '.join(slow)}. {why}: state the sensor's true rate_hz "
            "under sensors: in vehicle.yaml."
        )
    if lost:
        notes.append(
            f"Measured, but not used: {', '.join(lost)}. {why}: most of its readings are invalid "
            "or missing; see on the page of the run when the sensor lost them."
        )
    return tuple(notes)


def _found(runs: Sequence[RunTable], channel: ChannelNoise) -> tuple[float, int, float]:
    """Seconds of the runs with the channel, its readings there, and their rate where it has any."""
    seconds, count = 0.0, 0
    gaps = [np.zeros(0)]
    for run in runs:
        if channel.quantity not in run.values or not run.time_s.size:
            continue
        index = readings_of(run, channel.quantity, channel.rate_hz, np.inf)
        seconds += float(run.time_s[-1] - run.time_s[0])
        count += index.size
        gaps.append(np.diff(run.time_s[index]))
    between = np.concatenate(gaps)
    if not between.size:
        # one reading has no rate: what was stated is not in doubt
        return seconds, count, channel.rate_hz
    return seconds, count, 1.0 / float(np.quantile(between, _SHORT_GAPS))
