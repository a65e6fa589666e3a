"""How large the outside force may be: from what is ordinary on a healthy vehicle to what is not.

Each hypothesis is judged under every level of an outside force that no effect explains. Levels that
a healthy vehicle can have are ordinary; where the readings want more, something is left over.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.linear.elimination import ForcePrior
from pipeline.types import FloatArray

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


#: Time constants of the outside force: thrusters' wash and gusts, and what changes slowly; half of
#: the variance each. [s]
FAST_S, SLOW_S = 0.8, 10.0


def time_covariance(pieces: int, piece_s: float) -> FloatArray:
    """Correlation (pieces, pieces) of the outside force in time."""
    apart = piece_s * np.abs(np.subtract.outer(np.arange(pieces), np.arange(pieces)))
    return np.asarray(0.5 * np.exp(-apart / FAST_S) + 0.5 * np.exp(-apart / SLOW_S))


@dataclass(frozen=True)
class Level:
    """Standard deviation of the outside force over that of a healthy vehicle, by axis.

    `weight` is the prior probability of the level; `ordinary` whether a healthy vehicle has it.
    """

    factor: FloatArray
    weight: float
    ordinary: bool

    def prior(self, pieces: int, piece_s: float) -> ForcePrior:
        """Prior of the forces of a window that is cut into pieces, in squared units."""
        time = time_covariance(pieces, piece_s)
        return ForcePrior(
            np.kron(np.linalg.inv(time), np.diag(1.0 / self.factor**2)),
            float(6 * np.linalg.slogdet(time)[1] + 2 * pieces * np.log(self.factor).sum()),
        )

    @property
    def size(self) -> float:
        """Largest factor."""
        return float(self.factor.max())


#: Prior probability that something is left over that no effect explains.
LEFT_OVER = 0.1


def levels(*, healthy_known: bool) -> tuple[Level, ...]:
    """Levels to try; narrower where healthy runs have shown what is ordinary."""
    if healthy_known:
        ordinary = {0.7: 0.25, 1.0: 0.4, 1.4: 0.25, 2.0: 0.1}
        larger = (3.0, 6.0, 12.0, 24.0, 48.0, 96.0)
    else:
        ordinary = {0.25: 0.2, 0.5: 0.3, 1.0: 0.3, 2.0: 0.2}
        larger = (4.0, 8.0, 16.0, 32.0, 64.0, 128.0)
    found = [
        Level(np.full(6, factor), (1.0 - LEFT_OVER) * weight, True)
        for factor, weight in ordinary.items()
    ]
    share = 0.5 * LEFT_OVER / len(larger)
    found += [Level(np.full(6, factor), share, False) for factor in larger]
    share = 0.5 * LEFT_OVER / (6 * len(larger[::2]))
    for axis in range(6):
        for factor in larger[::2]:
            by_axis = np.ones(6)
            by_axis[axis] = factor
            found.append(Level(by_axis, share, False))
    return tuple(found)
