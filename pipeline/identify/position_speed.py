"""Velocity from a position that is known well, where no velocity was measured."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.identify.channel_noise import ChannelNoise, was_measured
from pipeline.identify.smoothing import local_polynomial, smooth
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: A position less sure than this shows no speed. [m]
SURE_M = 0.05
#: What a slope is taken through: at least so long, and so many readings.
_SLOPE_S, _READINGS = 0.7, 5


def sure_position(channels: Sequence[ChannelNoise]) -> ChannelNoise | None:
    """Return the channel of a position that is sure enough to show where a vehicle goes."""
    return next((c for c in channels if c.quantity == "position" and c.white <= SURE_M), None)


def velocity_of_position(
    run: RunTable, channels: Sequence[ChannelNoise]
) -> tuple[FloatArray, BoolArray] | None:
    """Velocity over ground of the origin in body axes (m, 3), and where it is known (m,). [m/s].

    The slope of the local quadratic through the positions, turned by the attitude. The motion
    capture of a pool (5 mm, 10 Hz) gives 0.01 m/s.

    Returns
    -------
    tuple of ndarray, or None
        None where the run has a velocity of its own, or no position that is sure, or no attitude.
    """
    channel = sure_position(channels)
    if channel is None or was_measured(run, "velocity"):
        return None
    if not was_measured(run, "position") or not was_measured(run, "attitude"):
        return None
    period = run.period_s
    length = max(_SLOPE_S, _READINGS / channel.rate_hz)
    samples = 2 * max(round(length / (2.0 * period)), 1) + 1
    trusted = run.valid["position"][:, None]
    position = np.where(trusted, run.values["position"], np.nan)
    slope = smooth(position, local_polynomial(samples, period, order=2))
    attitude = run.values["attitude"]
    known = slope.valid & run.trusted("attitude")
    velocity = np.zeros((run.time_s.size, 3))
    turn = Rotation.from_quat(attitude[known][:, [1, 2, 3, 0]])
    velocity[known] = turn.inv().apply(slope.derivative[known])
    return velocity, known
