"""How large the outside force is where sound runs have shown what is ordinary."""

import numpy as np

from pipeline.diagnose.linear.elimination import ForcePrior
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.diagnose.linear.scales import LEFT_OVER, Level, time_covariance
from pipeline.types import FloatArray

#: Standard deviation of the logarithm of the outside force from one run to the next, at the least.
_LEAST_SPREAD = 0.35
#: Steps of the levels, and how many there are.
_STEP, _ORDINARY = 2.0**0.5, 4


def usual_levels(spread: float) -> tuple[Level, ...]:
    """Levels where sound runs have shown what is ordinary: log-normal about it.

    Parameters
    ----------
    spread : float
        Standard deviation of the logarithm between runs.
    """
    width = float(np.hypot(spread, _LEAST_SPREAD))
    size = _STEP ** np.arange(-_ORDINARY, _ORDINARY + 1)
    weight = np.exp(-0.5 * (np.log(size) / width) ** 2)
    weight *= (1.0 - LEFT_OVER) / weight.sum()
    found = [
        Level(np.full(6, one), float(w), True)
        for one, w in zip(size, weight, strict=True)
        if w > 1e-3
    ]
    larger = found[-1].size * 2.0 ** np.arange(1, 7)
    share = 0.5 * LEFT_OVER / len(larger)
    found += [Level(np.full(6, factor), share, False) for factor in larger]
    share = 0.5 * LEFT_OVER / (6 * 3)
    for axis in range(6):
        for factor in larger[::2]:
            by_axis = np.ones(6)
            by_axis[axis] = factor
            found.append(Level(by_axis, share, False))
    return tuple(found)


def time_course(setting: Setting) -> FloatArray:
    """Correlation (pieces, pieces) of the outside force over a window of a setting."""
    window = max(w.duration_s for w in setting.bench.stack.windows)
    return time_covariance(setting.bench.pieces, window / setting.bench.pieces)


def force_prior(setting: Setting, level: Level) -> ForcePrior:
    """Prior of the outside forces of a setting under a level."""
    window = max(w.duration_s for w in setting.bench.stack.windows)
    return level.prior(setting.bench.pieces, window / setting.bench.pieces)
