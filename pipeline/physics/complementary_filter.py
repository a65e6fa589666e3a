"""A velocity by its own readings and by accelerations: a complementary filter.

The accelerations' sum has the course of the velocity and drifts; readings have its level and noise.
So the sum is taken, and the mean of what readings differ from it over a span of time, about each of
them: neither an offset of the accelerations nor a steady drift stays (Higgins 1975, IEEE Trans.
Aerosp. Electron. Syst. 11(3), 321-325; here on both sides of a reading, as all of a run is known).
"""

import numpy as np

from pipeline.physics.window_sums import means_over
from pipeline.types import BoolArray, FloatArray

#: Readings over so long say what level a velocity has. The same for all runs: what noise is left
#: has then the same course in each of them. [s]
LEVEL_S = 2.0
#: Weights of the two readings before and after one by which a parabola foretells it.
_PARABOLA = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0


def followed(
    values: FloatArray, read: BoolArray, summed: FloatArray, period_s: float
) -> FloatArray | None:
    """Follow accelerations, at the level of readings, (m, k).

    `values` (m, k) are a velocity, read where `read` (m,) is true; `summed` (m, k) the sum of the
    accelerations over time, of any constant; `period_s` between two rows. None where the readings
    about one foretell it better without accelerations, or are too few.
    """
    at = np.flatnonzero(read)
    if at.size < len(_PARABOLA):
        return None
    side = max(round(0.5 * LEVEL_S / (period_s * float(np.median(np.diff(at))))), 1)
    if 2 * side >= at.size:
        return None
    off = values[at] - summed[at]
    level = _mean_about(off, side)
    # what the others about a reading miss of it
    count = 2 * side + 1
    missed = (count * (off - level) / (count - 1))[side:-side]
    alone = [one[2:-2] - np.convolve(one, _PARABOLA, mode="valid") for one in values[at].T]
    if _spread(missed) >= _spread(np.stack(alone, axis=1)):
        return None
    rows = np.arange(len(values))
    return np.asarray(summed + np.stack([np.interp(rows, at, one) for one in level.T], axis=1))


def _mean_about(values: FloatArray, side: int) -> FloatArray:
    """Mean of as many values before each as after it, at most `side`."""
    rows = np.arange(len(values))
    reach = np.minimum(side, np.minimum(rows, rows[::-1]))
    return means_over(values, rows - reach, rows + reach + 1)


def _spread(error: FloatArray) -> float:
    """Size of errors of all columns, without regard to single ones that are far off."""
    return float(np.sqrt(np.sum(np.median(error**2, axis=0))))
