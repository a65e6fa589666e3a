"""Where windows start, estimated from the readings of their first part alone.

What comes after is then a prediction from the commands. Whatever predicts windows begins here.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.output_error import solve
from pipeline.identify.run_nuisance import run_nuisance
from pipeline.identify.window_derivatives import FitProblem
from pipeline.identify.window_outputs import OFFSETS, WindowStack, stack_windows
from pipeline.identify.windows import Window
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray


def lead_starts(
    packed: PackedVehicle,
    vector: FloatArray,
    leads: Sequence[Window],
    channels: Sequence[ChannelNoise],
    *,
    offsets: FloatArray | None = None,
    threads: int = 2,
) -> FloatArray | None:
    """Estimate first states (windows, STATE); None where the model runs away within a lead.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle.
    vector : ndarray
        Its parameter vector.
    leads : sequence of Window
        First parts of the windows, each with readings.
    channels : sequence of ChannelNoise
        What was measured.
    offsets : ndarray, shape (runs, OFFSET_COUNT), optional
        The runs' known offsets, zero otherwise.
    threads : int
        Simulations at a time.
    """
    stack = stack_windows(packed, leads, channels)
    if offsets is not None:
        stack = _shifted(stack, offsets)
    shared = run_nuisance(stack, 1 + max(one.run for one in leads), offsets=False)
    problem = FitProblem(stack, (), vector, shared, threads)
    try:
        fitted = solve(problem, smallest_gain=0.5)
    except (CannotComputeError, np.linalg.LinAlgError):
        return None
    return problem.starts(fitted.point.starts)


def _shifted(stack: WindowStack, offsets: FloatArray) -> WindowStack:
    """Take the runs' known offsets off the readings."""
    run_of = np.array([w.run for w in stack.windows])
    rows = [
        replace(one, measured=one.measured - offsets[run_of[one.window], OFFSETS[quantity]])
        if (quantity := one.channel.quantity) in OFFSETS
        else one
        for one in stack.rows
    ]
    return replace(stack, rows=tuple(rows))
