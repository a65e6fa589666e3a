"""What a force that is left goes with, and its course in time."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.gap.regimes import Regressor, Stretch, rank_correlation
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

#: A correlation (of ranks) from which a dependence is told.
_TOLD = 0.5
#: Energy after a time over that before it, from which a beginning is told.
_BEGINS = 6.0


def dependence(
    means: FloatArray, size: FloatArray, every: Sequence[Regressor]
) -> tuple[str | None, float | None]:
    """Return the regressor with the largest rank correlation to a force or to its size.

    Both and the regressors are over windows; None where none is large enough.
    """
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


def time_course(
    windows: Sequence[Stretch],
    size: FloatArray,
    means: FloatArray,
    runs: Sequence[RunTable],
) -> str:
    """Say whether a force is always there, sets in, grows, or comes and goes.

    Parameters
    ----------
    windows : sequence of Stretch
        Pieces of the runs, in order.
    size, means : ndarray, shape (windows,)
        Mean square of the force in each, over what is ordinary, and its mean with its sign.
    runs : sequence of RunTable
        The runs.
    """
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
