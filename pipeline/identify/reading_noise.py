"""How far one reading of a channel may be off: what an error of prediction is compared with."""

import numpy as np

from pipeline.identify.channel_noise import ChannelNoise


def reading_noise(channel: ChannelNoise, *, offset: bool) -> float:
    """Return the standard deviation of one reading that the vehicle file states, in its unit.

    Parameters
    ----------
    channel : ChannelNoise
        Noise, slow error and offset of the sensor.
    offset : bool
        Whether the offset counts: not where it was estimated and taken off the readings.
    """
    slow = np.hypot(channel.white, channel.wander)
    return float(np.hypot(slow, channel.bias) if offset else slow)
