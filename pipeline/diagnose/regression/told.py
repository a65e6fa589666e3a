"""What a run says of the directions in which a vehicle may differ from what was learned of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.types import FloatArray

#: Channels beside the velocities.
BESIDE = 2


@dataclass(frozen=True)
class Told:
    """What the channels of a run say of the directions: information (c, d, d) and score (c, d).

    The last channels are the logged supply voltage and the measured place, which say nothing where
    there is none.

    `thrust` (d,) is the share by which a unit of each direction changes the thrust of the run.
    """

    by_channel: FloatArray
    score_by_channel: FloatArray
    thrust: FloatArray

    @property
    def information(self) -> FloatArray:
        """Information (d, d) of all channels."""
        return np.asarray(self.by_channel.sum(axis=0))

    @property
    def score(self) -> FloatArray:
        """Score (d,) of all channels."""
        return np.asarray(self.score_by_channel.sum(axis=0))

    def tempered(self, share: FloatArray) -> "Told":
        """Count the noise of each channel as larger: a share (c,) of its information is left."""
        return Told(
            share[:, None, None] * self.by_channel,
            share[:, None] * self.score_by_channel,
            self.thrust,
        )

    def at(self, places: Sequence[int]) -> "Told":
        """Keep some directions, have them more than once, or (-1) one of which nothing is said."""
        own, one = list(places), (0, 1)
        return Told(
            np.pad(self.by_channel, ((0, 0), one, one))[:, own][:, :, own],
            np.pad(self.score_by_channel, ((0, 0), one))[:, own],
            np.pad(self.thrust, one)[own],
        )

    def of_channel(self, channel: int) -> "Told":
        """Keep what one channel says."""
        own = slice(channel, channel + 1)
        return Told(self.by_channel[own], self.score_by_channel[own], self.thrust)
