"""What the best answer leaves: the outside force over time, and what it goes with."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.gap.regimes import Regressor, rank_correlation
from pipeline.diagnose.judging.search import Search, force_prior
from pipeline.diagnose.linear.elimination import Grams, solve
from pipeline.diagnose.linear.scales import AXES, Level
from pipeline.records.diagnosis import Leftover
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: A correlation (of ranks) from which a dependence is told.
_TOLD = 0.5
#: Energy after a time over that before it, from which a beginning is told.
_BEGINS = 6.0


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
    name, value = _dependence(means, size, every)
    return Leftover(
        axes={axis: float(x) for axis, x in zip(AXES, axes, strict=True)},
        worst_axis=AXES[worst],
        time_course=_course(found, size, means, runs),
        depends_on=name,
        correlation=value,
    )


def _dependence(
    means: FloatArray, size: FloatArray, every: Sequence[Regressor]
) -> tuple[str | None, float | None]:
    """Regressor with the largest rank correlation to the force or to its size."""
    best: tuple[float, str] | None = None
    for one in every:
        known = np.isfinite(one.values)
        if known.sum() < 8:
            continue
        for values in (means, size):
            value = rank_correlation(values[known], one.values[known])
            if best is None or abs(value) > abs(best[0]):
                best = (value, one.name)
    if best is None or abs(best[0]) < _TOLD:
        return None, None
    return best[1], float(best[0])


def _course(found: Search, size: FloatArray, means: FloatArray, runs: Sequence[RunTable]) -> str:
    """In words: always there, sets in, grows, or comes and goes."""
    windows = found.setting.bench.stack.windows
    told = []
    for number, run in enumerate(runs):
        own = [k for k, window in enumerate(windows) if window.run == number]
        if len(own) < 6:
            continue
        energy, signed = size[own], means[own]
        time_s = np.array([windows[k].begin_s for k in own])
        ratios = [energy[k:].mean() / max(energy[:k].mean(), 1e-9) for k in range(2, len(own) - 1)]
        k = int(np.argmax(ratios)) + 2
        trend = abs(rank_correlation(signed, time_s))
        if trend > 0.8 and energy.mean() > 1.0:
            told.append(f"{run.name}: grows steadily")
        elif ratios[k - 2] > _BEGINS and energy[k:].mean() > 1.0:
            told.append(f"{run.name}: sets in at about {time_s[k]:.0f} s")
        elif energy.max() > 6.0 * max(float(np.median(energy)), 0.3):
            at = time_s[energy > 0.3 * energy.max()]
            told.append(
                f"{run.name}: comes and goes, strongest near "
                + ", ".join(f"{t:.0f} s" for t in at[:6])
            )
    return "; ".join(told) if told else "about alike all the time"
