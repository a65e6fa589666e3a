"""How much force the model lacks along the sound runs, and how much of it is always the same."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.asking.run_marginals import of_curves, of_rest, possible
from pipeline.diagnose.case import Case
from pipeline.diagnose.linear.follow import follow
from pipeline.diagnose.linear.linear_model import Setting, mass_of, vector_of
from pipeline.diagnose.reference.departures import AXES, force_unit_of
from pipeline.diagnose.reference.learn import Learned
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.records.reference import AxisForce
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray, IntArray


def lacking(
    case: Case,
    setting: Setting,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    learned: Learned,
) -> dict[str, AxisForce]:
    """Compare the forces that lead the model along the measured motion, before and after learning.

    Parameters
    ----------
    case : Case
        The vehicle.
    setting : Setting
        Windows of the sound runs with the forces of the rest, as it was learned from.
    runs : sequence of RunTable
        The sound runs.
    channels : sequence of ChannelNoise
        What was used of them.
    learned : Learned
        What they showed.
    """
    owner = np.array([window.run for window in setting.bench.stack.windows])
    before = _by_piece(setting, np.concatenate(setting.bench.pulls))
    every = np.arange(owner.size)
    left = _left(case, setting, runs, channels, every, learned.vehicle)
    in_run = np.zeros_like(before)
    for number, departures in zip(np.unique(owner), learned.of_runs, strict=True):
        own = np.flatnonzero(owner == number)
        in_run[own] = _left(case, setting, runs, channels, own, departures)
    lacked, after, last = (np.sqrt(np.mean(one**2, axis=(0, 1))) for one in (before, left, in_run))
    share = 1.0 - (after / np.maximum(lacked, 1e-12)) ** 2
    return {
        axis: AxisForce(
            unit=force_unit_of(k),
            lacked=float(lacked[k]),
            left=float(after[k]),
            left_in_run=float(last[k]),
            same_share=float(np.clip(share[k], 0.0, 1.0)),
            outside=float(learned.beliefs.force_unit[k]),
            outside_of_file=float(setting.force_unit[k]),
        )
        for k, axis in enumerate(AXES)
    }


def _left(  # noqa: PLR0917 - what is led, then by what
    case: Case,
    setting: Setting,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    own: IntArray,
    departures: FloatArray,
) -> FloatArray:
    """Force that the model lacks with some departures (d,) in some windows, (own, pieces, 6)."""
    bench = setting.bench
    able = possible(setting, departures)
    vector = vector_of(setting, able[: len(setting.coordinates)])
    windows = [bench.stack.windows[k] for k in own]
    nearby = [bench.pulls[k] for k in own]
    _, pulls = follow(case.packed, runs, windows, channels, vector, nearby, bench.workers)
    forces = np.concatenate(bench.pulls)
    bounds = bench.whole.bounds
    for k, pull in zip(own, pulls, strict=True):
        forces[bounds[k] : bounds[k + 1]] = pull
    forces = forces - setting.profiles @ able[of_curves(setting)]
    same = np.linalg.solve(mass_of(bench.stack.packed.vector), mass_of(vector))
    rest = setting.rest.of(able[of_rest(setting)]) * np.tile(setting.force_unit, bench.pieces)
    rest = rest.reshape(bench.window_count, bench.pieces, 6) @ same
    return np.asarray((_by_piece(setting, forces) - rest)[own])


def _by_piece(setting: Setting, forces: FloatArray) -> FloatArray:
    """Average forces (steps, 6) over the pieces of the windows, (windows, pieces, 6)."""
    bounds, bench = setting.bench.cut.bounds, setting.bench
    total = np.concatenate([np.zeros((1, 6)), np.cumsum(forces, axis=0)])
    mean = (total[bounds[1:]] - total[bounds[:-1]]) / np.maximum(np.diff(bounds), 1)[:, None]
    return np.asarray(mean.reshape(bench.window_count, bench.pieces, 6))
