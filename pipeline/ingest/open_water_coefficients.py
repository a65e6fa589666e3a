"""K_T and K_Q from whatever an open-water test states, and whether they can be true.

The papers' K_M is K_Q.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeline.types import BoolArray, FloatArray, IntArray

#: Of the torque coefficient, by the quantity that a column holds.
TORQUE_FACTORS = {
    "torque_coefficient": 1.0,
    "torque_coefficient_x10": 0.1,
    "power_coefficient": 1.0 / (2.0 * math.pi),
}
#: Of 1 + J^2, to which the flow at a blade grows: no K_T or K_Q is larger.
_LARGEST_COEFFICIENT = 1.5
_EFFICIENCY_SHARE, _EFFICIENCY_OFF = 0.03, 0.05
#: A smaller K_Q is a zero: nothing is divided by it.
_NO_TORQUE_COEFFICIENT = 1e-12
#: Slower than this the shaft stands still: a sensor's noise, not a point of a curve.
_STANDING_RPM = 1e-3
#: K_Q / K_T of a screw where K_T is large lies between about 0.08 and 0.3; ten times is a mix-up.
_LARGEST_TORQUE_SHARE = 0.6
_SMALLEST_TORQUE_SHARE = 0.02
#: Below this J a propeller all but stands; no screw has less thrust there; K_T falls by this share
#: at least where a correlation with J tells that it grows.
_NEAR_REST, _LEAST_K_T, _FALLS, _RISES, _LEAST_POINTS = 0.4, 0.02, 0.3, 0.8, 4
_DOUBTFUL_K_T = 0.06
#: Of 450 small propellers in air one in a hundred has less at its best, and none has more; which
#: shows where K_T has fallen to this share.
_BEST_EFFICIENCIES, _PAST_BEST = (0.27, 0.87), 0.4
#: K_T must fall to this share for its zero to be known.
_FALLS_TO = 0.6
#: Thrust ends at so much of the pitch ratio.
_ENDS_OF_PITCH = (0.7, 1.7)
#: K_T near rest is so many times that J, and no pitch is so large that it lies further.
_ENDS_OF_THRUST, _LAST_END = (0.09, 0.8), 1.8
#: More is of no screw, but of V / (pi n D) in place of J: the letter J is used for that seldom.
_ENDS_TOO_EARLY, _SO_OF_J = 0.7, 1.0


@dataclass(frozen=True)
class Coefficients:
    """Advance ratio J, K_T and K_Q of rows (n,) [-], NaN where nothing gives one."""

    advance_ratio: FloatArray
    thrust_coefficient: FloatArray
    torque_coefficient: FloatArray

    def of(self, rows: IntArray | BoolArray) -> "Coefficients":
        """Return those of some rows."""
        return Coefficients(
            self.advance_ratio[rows], self.thrust_coefficient[rows], self.torque_coefficient[rows]
        )

    @property
    def efficiency(self) -> FloatArray:
        r"""Open-water efficiency :math:`\eta = J K_T / (2\pi K_Q)`, NaN where it has none."""
        q = self.torque_coefficient
        q = np.where(np.abs(q) < _NO_TORQUE_COEFFICIENT, np.nan, q)
        return self.advance_ratio * self.thrust_coefficient / (2.0 * math.pi * q)

    @property
    def are_impossible(self) -> BoolArray:
        """Whether no propeller has these coefficients."""
        largest = np.fmax(np.abs(self.thrust_coefficient), np.abs(self.torque_coefficient))
        return np.asarray(largest > _LARGEST_COEFFICIENT * (1.0 + self.advance_ratio**2))


def coefficients(
    values: Mapping[str, FloatArray], density_kgpm3: float, diameter_m: float
) -> Coefficients:
    r"""Compute J, K_T and K_Q of rows.

    A stated coefficient goes before a computed one:
    :math:`J = V/(nD)`, :math:`K_T = T/(\rho n^2 D^4)`, :math:`K_Q = Q/(\rho n^2 D^5)`,
    :math:`K_Q = C_P/2\pi`, :math:`K_T = C_T`.

    `values` is what the rows hold (n,), NaN where nothing: these coefficients [-], thrust [N],
    torque [N m], shaft_speed [rpm], speed [m/s].

    References
    ----------
    Kostenko 2023, eqs. (1), (2).

    Examples
    --------
    >>> row = {"speed": 1.0, "shaft_speed": 600.0, "thrust": 16.0, "torque": 0.64}
    >>> one = coefficients({name: np.array([value]) for name, value in row.items()}, 1000.0, 0.2)
    >>> one.advance_ratio, one.thrust_coefficient, one.torque_coefficient.round(9)
    (array([0.5]), array([0.1]), array([0.02]))
    """
    none = np.full(next(iter(values.values())).shape, np.nan)
    speed_rpm = values.get("shaft_speed", none)
    n = np.where(np.abs(speed_rpm) > _STANDING_RPM, speed_rpm / 60.0, np.nan)
    head_pa = density_kgpm3 * n**2 * diameter_m**2  # rho n^2 D^2

    def stated_or(computed: FloatArray, **factors: float) -> FloatArray:
        for name, factor in reversed(factors.items()):
            own = values.get(name, none) * factor
            computed = np.where(np.isfinite(own), own, computed)
        return computed

    return Coefficients(
        stated_or(values.get("speed", none) / (n * diameter_m), advance_ratio=1.0),
        stated_or(values.get("thrust", none) / (head_pa * diameter_m**2), thrust_coefficient=1.0),
        stated_or(values.get("torque", none) / (head_pa * diameter_m**3), **TORQUE_FACTORS),
    )


class EfficiencyCheck(NamedTuple):
    """Computed over stated efficiency: median ratio, rows that differ from it, what to suspect."""

    ratio: float
    outliers: tuple[int, ...]
    suspicion: str


def check_efficiency(computed: FloatArray, stated: FloatArray) -> EfficiencyCheck | None:
    """Compare the efficiency (n,) that follows from J, K_T and K_Q with the stated one.

    Rows where either is not finite or small are not compared. `suspicion` is empty if the two agree
    within 3 %; None if no row can be compared.

    >>> check_efficiency(np.array([0.0542, 0.0607]), np.array([0.542, 0.607])).suspicion[:51]
    'the torque coefficient looks ten times too large: i'
    """
    # Near zero thrust and far beyond it the ratio says nothing about the columns.
    rows = np.flatnonzero(np.isfinite(computed) & (stated > 0.05) & np.isfinite(stated))
    if not rows.size:
        return None
    ratios = computed[rows] / stated[rows]
    ratio = float(np.median(ratios))
    off = rows[np.abs(ratios - ratio) > _EFFICIENCY_OFF * abs(ratio)]
    return EfficiencyCheck(ratio, tuple(off.tolist()), _suspicion(ratio))


def _suspicion(ratio: float) -> str:
    if abs(ratio - 1.0) <= _EFFICIENCY_SHARE:
        return ""
    two_pi = 2.0 * math.pi
    for factor, text in (
        (0.1, "the torque coefficient looks ten times too large: is the column 10K_Q, not K_Q?"),
        (10.0, "the torque coefficient looks ten times too small: is the column K_Q, not 10K_Q?"),
        (1 / math.pi, "J looks pi too small: is the column V / (pi n D), not V / (n D)?"),
        (0.01, "the stated efficiency looks to be in percent: state its unit as %"),
        (two_pi, "the torque coefficient looks 2 pi too small: is the column K_Q, not C_P?"),
        (1 / two_pi, "the torque coefficient looks 2 pi too large: is the column C_P, not K_Q?"),
        (0.1 / two_pi, "the torque coefficient looks 20 pi too large: is the column 10 C_P?"),
    ):
        if abs(ratio / factor - 1.0) <= 0.1:
            return text
    return "J, K_T, K_Q and the efficiency do not belong together"


def impossible(points: Coefficients) -> str:
    """Say what no propeller does, whatever its name: too little thrust, a sign; empty if nothing.

    Near rest a turning propeller pushes, and the less the faster it goes.

    >>> j = np.array([-0.8, -0.5, -0.2, 0.0])
    >>> impossible(Coefficients(j, 0.4 + 0.4 * j, np.full(4, np.nan)))
    'K_T grows with J: the sign of the speed'
    """
    advance, thrust = points.advance_ratio, np.nan_to_num(points.thrust_coefficient)
    if not thrust.any() or not (np.abs(advance) < _NEAR_REST).any():
        return ""
    largest = float(np.abs(thrust).max())
    torque = points.torque_coefficient[np.nan_to_num(points.torque_coefficient) != 0.0]
    least_of = thrust.size >= _LEAST_POINTS and np.ptp(thrust) > _FALLS * largest
    if largest < _LEAST_K_T:
        return f"K_T is {largest:.2g} at most, a screw has 0.1 to 0.8: a unit, or another speed"
    if (thrust <= 0.0).all():
        return "K_T is negative throughout: the sign of the thrust sensor"
    if torque.size >= _LEAST_POINTS and torque.max() < 0.0:
        return "K_Q is negative throughout: the sign of the torque sensor"
    if least_of and np.ptp(advance) > 0.0 and np.corrcoef(advance, thrust)[0, 1] > _RISES:
        return "K_T grows with J: the sign of the speed"
    return ""


def no_thrust_at(points: Coefficients) -> float | None:
    """Return the J at which a straight line through K_T is zero; None where it is not known."""
    ahead = points.of(points.advance_ratio >= 0.0)
    advance, thrust = ahead.advance_ratio, np.nan_to_num(ahead.thrust_coefficient)
    if thrust.size < 3 or min(np.ptp(advance), thrust.max()) <= 0.0:
        return None
    if thrust.min() > _FALLS_TO * thrust.max():
        return None
    slope, constant = np.polyfit(advance, thrust, 1)
    return None if slope >= 0.0 or constant <= 0.0 else float(-constant / slope)


def ends_too_early(points: Coefficients, *, is_called_j: bool) -> str:
    """Say where thrust is zero so early that no screw has it: V / (pi n D), perhaps, in place of J.

    >>> j = np.linspace(0.0, 0.3, 4)
    >>> ends_too_early(Coefficients(j, 0.4 - 1.2 * j, j), is_called_j=False)
    'K_T is 0.4 at most and zero at 0.333'
    """
    ends, thrust = no_thrust_at(points), np.nan_to_num(points.thrust_coefficient)
    largest = float(thrust.max(initial=0.0))
    most = _SO_OF_J if is_called_j else _ENDS_TOO_EARLY
    if ends is None or largest <= most * ends or np.abs(points.advance_ratio).min() > ends / 2.0:
        return ""
    return f"K_T is {largest:.2g} at most and zero at {ends:.3g}"


def far_from_pitch(points: Coefficients, pitch_ratio: float | None) -> str:
    """Say where thrust ends far from the J at which a screw of that pitch slips no more.

    Of a pitch that is not stated, where no screw with so much thrust near rest has that.
    """
    ends = no_thrust_at(points)
    if ends is None:
        return ""
    if pitch_ratio is None:
        largest = float(np.nan_to_num(points.thrust_coefficient).max())
        at_rest = (np.abs(points.advance_ratio) < _NEAR_REST).any()
        least, most = _ENDS_OF_THRUST
        if not at_rest or (least <= largest / ends <= most and ends <= _LAST_END):
            return ""
        return f"K_T is {largest:.2g} at most and zero at J = {ends:.3g}, as of no screw"
    least, most = (one * pitch_ratio for one in _ENDS_OF_PITCH)
    if least <= ends <= most:
        return ""
    return (
        f"K_T is zero at J = {ends:.3g}, a screw of pitch ratio {pitch_ratio:g} has that at "
        f"{least:.3g} to {most:.3g}"
    )


def doubt(points: Coefficients) -> str:
    """Say what cannot be true of K_T and K_Q by themselves; empty if nothing is odd.

    >>> doubt(Coefficients(*map(np.array, ([0.0, 0.5], [0.4, 0.2], [0.5, 0.35])))).split(":")[0]
    'K_Q is 125 % of K_T where the thrust is large, a screw has 8 to 30 %'
    """
    most = float(np.nan_to_num(points.thrust_coefficient).max(initial=0.0))
    at_rest = (np.abs(points.advance_ratio) < _NEAR_REST).any()
    if at_rest and 0.0 < most < _DOUBTFUL_K_T:
        return (
            f"K_T is {most:.2g} at most, a screw has 0.1 to 0.8: a unit, the speed or the diameter"
        )
    both = points.of(np.isfinite(points.thrust_coefficient + points.torque_coefficient))
    thrust, torque = both.thrust_coefficient, both.torque_coefficient
    largest = float(thrust.max(initial=0.0))
    loaded = thrust > 0.6 * largest
    share = float(np.median(torque[loaded] / thrust[loaded])) if largest > 0.0 else 0.15
    text = f"K_Q is {100 * share:.3g} % of K_T where the thrust is large, a screw has 8 to 30 %"
    if share > _LARGEST_TORQUE_SHARE:
        return f"{text}: is the column 10K_Q, not K_Q?"
    if 0.0 < share < _SMALLEST_TORQUE_SHARE:
        return f"{text}: is the column K_Q, not 10K_Q?"
    best = both.efficiency[(torque > 0.0) & (thrust > 0.05 * largest)].max(initial=0.0)
    is_past_best = largest > 0.0 and float(thrust.min()) < _PAST_BEST * largest
    if best > _BEST_EFFICIENCIES[1] or (is_past_best and 0.0 < best < _BEST_EFFICIENCIES[0]):
        return (
            f"the efficiency J K_T / (2 pi K_Q) is {best:.2f} at best, a screw has 0.4 to 0.8: the "
            "speed, or the torque, is in another unit"
        )
    return ""
