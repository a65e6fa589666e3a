"""What the best answer leaves: the outside force over time, and what it goes with."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.gap.course import dependence, time_course
from pipeline.diagnose.gap.regimes import Regressor
from pipeline.diagnose.judging.search import Search, force_prior
from pipeline.diagnose.linear.elimination import Grams, solve
from pipeline.diagnose.linear.scales import AXES, Level
from pipeline.records.diagnosis import Leftover
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray


def forces_left(found: Search, normal: Grams, departures: FloatArray, scale: float) -> FloatArray:
    """Estimate the outside force that an answer leaves.

    Returns
    -------
    ndarray, shape (windows, knots, 6)
        In units of the ordinary outside force.
    """
    level = Level(np.full(6, max(scale, 1.0)), 1.0, True)
    best = solve(normal, force_prior(found.setting, level), departures)
    return best.forces.reshape(len(normal.own), -1, 6)


def leftover(
    found: Search, forces: FloatArray, runs: Sequence[RunTable], every: Sequence[Regressor]
) -> Leftover:
    """Describe the outside force (windows, knots, 6) that the answer leaves."""
    axes = np.sqrt(np.mean(forces**2, axis=(0, 1)))
    worst = int(np.argmax(axes))
    means = forces[:, :, worst].mean(axis=1)
    size = np.mean(forces[:, :, worst] ** 2, axis=1)
    name, value = dependence(means, size, every)
    return Leftover(
        axes={axis: float(x) for axis, x in zip(AXES, axes, strict=True)},
        worst_axis=AXES[worst],
        time_course=time_course(found.setting.bench.stack.windows, size, means, runs),
        depends_on=name,
        correlation=value,
    )
