"""A monotone curve T(N) of one sign at one speed, and its inverse."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.types import ArrayLike, FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

#: Smallest rise of thrust between knots: keeps the inverse defined on flat stretches. [N]
SMALLEST_RISE_N = 1e-6
#: A measured curve with fewer codes beyond the dead zone is not worth smoothing.
FEWEST_CODES = 5
#: Thrust of this share of the largest is beyond the dead zone, whatever the noise of its edge.
_LIVE_SHARE = 0.1


@dataclass(frozen=True)
class ThrustCurve:
    """T(N) from the edge of the dead zone (thrust 0) to the last code, both strictly rising.

    `code` and `thrust_n` are magnitudes of shape (m,); between them a monotone cubic (PCHIP;
    Fritsch and Carlson 1980) runs.
    """

    code: FloatArray
    thrust_n: FloatArray

    @property
    def thrust_max_n(self) -> float:
        """Thrust at the last code [N]."""
        return float(self.thrust_n[-1])

    @cached_property
    def _cubic(self) -> "PchipInterpolator":
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.code, self.thrust_n)

    def thrust(self, code: ArrayLike) -> FloatArray:
        """Thrust at codes; zero inside the dead zone, clamped beyond the last code [N]."""
        return np.asarray(self._cubic(np.clip(code, self.code[0], self.code[-1])))

    def slope(self, code: ArrayLike) -> FloatArray:
        """Slope dT/dN [N]."""
        return np.asarray(self._cubic.derivative()(np.clip(code, self.code[0], self.code[-1])))

    def code_at(self, thrust_n: ArrayLike) -> FloatArray:
        """Code that gives a thrust: the inverse by a bracketed root of the same cubic."""
        from scipy.optimize import elementwise

        wanted = np.clip(np.asarray(thrust_n, float), self.thrust_n[0], self.thrust_n[-1])
        upper = np.clip(np.searchsorted(self.thrust_n, wanted), 1, len(self.code) - 1)
        low, high = self.code[upper - 1], self.code[upper]

        def excess(code: FloatArray, target: FloatArray) -> FloatArray:
            return np.asarray(self._cubic(code)) - target

        result = elementwise.find_root(excess, (low, high), args=(wanted,))
        # at a knot round-off can leave no sign change: the knot itself is the answer
        nearer_high = np.abs(self.thrust_n[upper] - wanted) < np.abs(
            self.thrust_n[upper - 1] - wanted
        )
        return np.where(result.success, result.x, np.where(nearer_high, high, low))


def curve_from_family(code: FloatArray, thrust_n: FloatArray) -> ThrustCurve | None:
    """Curve through rising codes and thrusts (m,) of the static family, None where it gives none.

    The edge of the dead zone lies between the last code without thrust and the first with it,
    where the line through the first two live points meets zero.
    """
    live = np.flatnonzero(thrust_n > 0)
    if live.size < 2:
        return None
    first = int(live[0])
    return _from_edge(code, first, _strictly_rising(thrust_n[first:]))


def _from_edge(code: FloatArray, first: int, thrust_n: FloatArray) -> ThrustCurve:
    """Begin a curve where the line through its first two points meets zero.

    Not below the last code without thrust; `first` is the place of that with the first of thrusts.
    """
    codes = code[first:]
    gradient = (thrust_n[1] - thrust_n[0]) / (codes[1] - codes[0])
    lowest = float(code[first - 1]) if first > 0 else 0.0
    edge = min(max(codes[0] - thrust_n[0] / gradient, lowest), codes[0] - 1e-6)
    return ThrustCurve(np.concatenate([[edge], codes]), np.concatenate([[0.0], thrust_n]))


def curve_from_measurements(code: FloatArray, thrust_n: FloatArray) -> ThrustCurve:
    """Smooth monotone curve through measured points of one sign.

    Readings at one code are averaged; a cubic smoothing spline (penalty by generalised cross
    validation; Craven and Wahba 1979) takes the noise out, isotonic regression any fall that is
    left. `code`, `thrust_n` (m,) are magnitudes in any order, code 0 and the dead zone included or
    not.

    Raises
    ------
    CannotComputeError
        With fewer than five codes that give thrust, or where one beyond them gives none.
    """
    from scipy.interpolate import make_smoothing_spline
    from scipy.optimize import isotonic_regression

    if not np.any(code):
        raise CannotComputeError("none was measured")
    codes, index = np.unique(code, return_inverse=True)
    mean = np.bincount(index, weights=thrust_n) / np.bincount(index)
    dead = np.flatnonzero(mean <= 0)
    live_before = np.maximum.accumulate(mean) > _LIVE_SHARE * mean.max()
    lost = dead[live_before[dead]]
    if lost.size:
        # taken for the end of the dead zone it would take all codes below it along
        reached = mean[: lost[0]].max()
        raise CannotComputeError(
            f"code {codes[lost[0]]:g} gives no thrust, although a smaller one gives "
            f"{reached:.3g} N: was the force lost there? Mark those rows to leave them out"
        )
    first = int(dead[-1]) + 1 if dead.size else 0
    live = codes[first:]
    if live.size < FEWEST_CODES:
        raise CannotComputeError(
            f"thrust was measured at {live.size} codes beyond the dead zone; "
            f"{FEWEST_CODES} are the least for a characteristic"
        )
    smooth = make_smoothing_spline(live, mean[first:])(live)
    rising = _strictly_rising(np.maximum(isotonic_regression(smooth).x, SMALLEST_RISE_N))
    return _from_edge(codes, first, rising)


def _strictly_rising(values: FloatArray) -> FloatArray:
    steps = SMALLEST_RISE_N * np.arange(len(values))
    return np.asarray(np.maximum.accumulate(values - steps) + steps)
