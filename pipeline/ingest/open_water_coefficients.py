"""K_T and K_Q from whatever an open-water test states, and whether they can be true.

The papers' K_M is K_Q.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

#: Of the torque coefficient, by the quantity that a column holds.
TORQUE_FACTORS = {
    "torque_coefficient": 1.0,
    "torque_coefficient_x10": 0.1,
    "power_coefficient": 1.0 / (2.0 * math.pi),
}
#: Of 1 + J^2, to which the flow at a blade grows: no K_T or K_Q is larger.
_LARGEST_COEFFICIENT = 1.5
_EFFICIENCY_SHARE = 0.03
#: Slower than this the shaft stands still: a sensor's noise, not a point of a curve.
_STANDING_RPM = 1e-3
#: K_Q / K_T of a screw where K_T is large lies between about 0.08 and 0.3; ten times is a mix-up.
_LARGEST_TORQUE_SHARE = 0.6
_SMALLEST_TORQUE_SHARE = 0.02
#: Below this J a propeller all but stands; no screw has less thrust there; K_T falls by this share
#: at least where a correlation with J tells that it grows.
_NEAR_REST, _LEAST_K_T, _FALLS, _RISES, _LEAST_POINTS = 0.4, 0.02, 0.3, 0.8, 4
_DOUBTFUL_K_T = 0.06


class NoCoefficientError(ValueError):
    """A row does not give what is asked; the text says why."""


@dataclass(frozen=True)
class Coefficients:
    """One row: advance ratio J, K_T, K_Q. [-]."""

    advance_ratio: float
    thrust_coefficient: float | None
    torque_coefficient: float | None

    @property
    def is_impossible(self) -> bool:
        """Whether no propeller has these coefficients."""
        largest = max(abs(self.thrust_coefficient or 0.0), abs(self.torque_coefficient or 0.0))
        return largest > _LARGEST_COEFFICIENT * (1.0 + self.advance_ratio**2)


def coefficients(
    values: Mapping[str, float], density_kgpm3: float, diameter_m: float
) -> Coefficients:
    r"""Compute J, K_T and K_Q of one row.

    A stated coefficient goes before a computed one:
    :math:`J = V/(nD)`, :math:`K_T = T/(\rho n^2 D^4)`, :math:`K_Q = Q/(\rho n^2 D^5)`,
    :math:`K_Q = C_P/2\pi`, :math:`K_T = C_T`.

    `values` is what the row holds: these coefficients [-], thrust [N], torque [N m], shaft_speed
    [rpm], speed [m/s]. K_T or K_Q is None if the row has nothing that gives it. Raises
    `NoCoefficientError` if J is not known, or neither K_T nor K_Q.

    References
    ----------
    Kostenko 2023, eqs. (1), (2).

    Examples
    --------
    >>> row = {"speed": 1.0, "shaft_speed": 600.0, "thrust": 16.0, "torque": 0.64}
    >>> one = coefficients(row, 1000.0, 0.2)
    >>> round(one.advance_ratio, 9), round(one.thrust_coefficient, 9)
    (0.5, 0.1)
    >>> round(one.torque_coefficient, 9)
    0.02
    """
    shaft_speed_rpm = values.get("shaft_speed")
    turning = shaft_speed_rpm is not None and abs(shaft_speed_rpm) > _STANDING_RPM
    shaft_speed_rps = shaft_speed_rpm / 60.0 if shaft_speed_rpm is not None else math.nan
    head_pa = density_kgpm3 * shaft_speed_rps**2 * diameter_m**2  # rho n^2 D^2
    advance_ratio = values.get("advance_ratio")
    if advance_ratio is None and "speed" in values and turning:
        advance_ratio = values["speed"] / (shaft_speed_rps * diameter_m)
    if advance_ratio is None:
        raise NoCoefficientError(
            "the shaft stands still, J = V / (n D) is not defined"
            if shaft_speed_rpm is not None and "speed" in values
            else "no advance ratio, and no speed with shaft speed to compute it from"
        )
    thrust_coefficient = values.get("thrust_coefficient")
    if thrust_coefficient is None and "thrust" in values and turning:
        thrust_coefficient = values["thrust"] / (head_pa * diameter_m**2)
    torque_coefficient = next(
        (values[name] * factor for name, factor in TORQUE_FACTORS.items() if name in values), None
    )
    if torque_coefficient is None and "torque" in values and turning:
        torque_coefficient = values["torque"] / (head_pa * diameter_m**3)
    if thrust_coefficient is None and torque_coefficient is None:
        raise NoCoefficientError("neither a thrust nor a torque coefficient follows from the row")
    return Coefficients(advance_ratio, thrust_coefficient, torque_coefficient)


def efficiency(advance_ratio: float, thrust_coefficient: float, torque_coefficient: float) -> float:
    r"""Open-water efficiency :math:`\eta = J K_T / (2\pi K_Q)`, nan where K_Q is 0.

    >>> round(efficiency(0.7985, 0.5052, 0.11836), 3)
    0.542
    """
    if torque_coefficient == 0.0:
        return math.nan
    return advance_ratio * thrust_coefficient / (2.0 * math.pi * torque_coefficient)


@dataclass(frozen=True)
class EfficiencyCheck:
    """Computed over stated efficiency: median ratio, rows that differ from it, what to suspect."""

    ratio: float
    outliers: tuple[int, ...]
    suspicion: str


def check_efficiency(computed: Sequence[float], stated: Sequence[float]) -> EfficiencyCheck | None:
    """Compare the efficiency that follows from J, K_T and K_Q with the stated one.

    In the same order; rows where either is not finite or small are not compared. `suspicion` is
    empty if the two agree within 3 %; None if no row can be compared.

    >>> check_efficiency([0.0542, 0.0607], [0.542, 0.607]).suspicion.split(":")[0]
    'the torque coefficient looks ten times too large'
    """
    pairs = [
        (index, ours / theirs)
        for index, (ours, theirs) in enumerate(zip(computed, stated, strict=True))
        # Near zero thrust and far beyond it the ratio says nothing about the columns.
        if math.isfinite(ours) and math.isfinite(theirs) and theirs > 0.05
    ]
    if not pairs:
        return None
    ratio = float(np.median([one for _, one in pairs]))
    outliers = tuple(
        index for index, one in pairs if abs(one / ratio - 1.0) > max(_EFFICIENCY_SHARE, 0.05)
    )
    return EfficiencyCheck(ratio, outliers, _suspicion(ratio))


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


#: Where the two readings of an advance coefficient are alike: J at no thrust, largest efficiency.
_J_0, _ETA = 0.45, 0.32
#: K_T must fall to this share for its zero, and the largest efficiency, to be known.
_FALLS_TO = 0.6
#: Thrust ends at so much of the pitch ratio.
_ENDS_OF_PITCH = (0.7, 1.7)
#: K_T near rest is so many times that J, and no pitch is so large that it lies further.
_ENDS_OF_THRUST, _LAST_END = (0.09, 0.8), 1.8
#: What the name says for V / (pi n D), in nats: the letter lambda is used for both, J is not.
_NAMED = {"lambda": 1.0, "": 0.0, "J": -1.5}


def over_pi(points: Sequence[Coefficients], name: str, ratio: float | None) -> float | None:
    """Return the evidence [nats] that an advance coefficient is V / (pi n D), not J.

    None where the numbers tell nothing. What weighs: where K_T is zero and the largest efficiency,
    both pi too small then, the `name` ("lambda", "J", ""), the `ratio` of the efficiency to a
    stated one.

    >>> screw = [Coefficients(j, 0.4 * (1 - j), 0.05 * (1.1 - j)) for j in (0.0, 0.3, 0.6, 0.9)]
    >>> small = [Coefficients(j / 3.14, 0.4 * (1 - j), 0.05 * (1.1 - j)) for j in (0.0, 0.3, 0.9)]
    >>> over_pi(screw, "lambda", None) < -1.0, over_pi(small, "J", None) > 0.5
    (True, True)
    """
    if ratio is not None:
        return math.inf if abs(ratio * math.pi - 1.0) <= 0.1 else -math.inf
    ends = no_thrust_at(points)
    if ends is None:
        return None
    best = max(
        (
            efficiency(one.advance_ratio, one.thrust_coefficient, one.torque_coefficient)
            for one in points
            if one.thrust_coefficient and one.torque_coefficient and one.torque_coefficient > 0.0
        ),
        default=0.0,
    )
    score = _NAMED[name] - 3.0 * math.log(ends / _J_0)
    return score - (4.0 * math.log(best / _ETA) if best > 0.0 else 0.0)


def impossible(points: Sequence[Coefficients]) -> str:
    """Say what no propeller does, whatever its name: too little thrust, a sign; empty if nothing.

    Near rest a turning propeller pushes, and the less the faster it goes.

    >>> impossible([Coefficients(j, 0.4 + 0.4 * j, None) for j in (-0.8, -0.5, -0.2, 0.0)])
    'K_T grows with J: the sign of the speed'
    """
    both = [(one.advance_ratio, one.thrust_coefficient or 0.0) for one in points]
    advance, thrust = np.array(both).reshape(-1, 2).T
    near = np.abs(advance) < _NEAR_REST
    if not thrust.any() or not near.any():
        return ""
    largest = float(np.abs(thrust).max())
    if largest < _LEAST_K_T:
        return f"K_T is {largest:.2g} at most, a screw has 0.1 to 0.8: a unit, or another speed"
    if (thrust <= 0.0).all():
        return "K_T is negative throughout: the sign of the thrust sensor"
    torque = [one.torque_coefficient for one in points if one.torque_coefficient]
    if len(torque) >= _LEAST_POINTS and max(torque) < 0.0:
        return "K_Q is negative throughout: the sign of the torque sensor"
    least_of = thrust.size >= _LEAST_POINTS and np.ptp(thrust) > _FALLS * largest
    if least_of and np.ptp(advance) > 0.0 and np.corrcoef(advance, thrust)[0, 1] > _RISES:
        return "K_T grows with J: the sign of the speed"
    return ""


def no_thrust_at(points: Sequence[Coefficients]) -> float | None:
    """Return the J at which a straight line through K_T is zero; None where it is not known."""
    both = [(one.advance_ratio, one.thrust_coefficient or 0.0) for one in points]
    advance, thrust = np.array([one for one in both if one[0] >= 0.0]).reshape(-1, 2).T
    if thrust.size < 3 or min(np.ptp(advance), thrust.max()) <= 0.0:
        return None
    if thrust.min() > _FALLS_TO * thrust.max():
        return None
    slope, constant = np.polyfit(advance, thrust, 1)
    return None if slope >= 0.0 or constant <= 0.0 else float(-constant / slope)


def far_from_pitch(points: Sequence[Coefficients], pitch_ratio: float | None) -> str:
    """Say where thrust ends far from the J at which a screw of that pitch slips no more.

    Of a pitch that is not stated, where no screw with so much thrust near rest has that.

    >>> far_from_pitch([Coefficients(2.0 * j, 0.3 * (0.7 - j), None) for j in (0, 0.3, 0.6)], 0.6)
    'K_T is zero at J = 1.4, a screw of pitch ratio 0.6 has that at 0.42 to 1.02'
    """
    ends = no_thrust_at(points)
    if ends is None:
        return ""
    if pitch_ratio is None:
        largest = max(one.thrust_coefficient or 0.0 for one in points)
        at_rest = any(abs(one.advance_ratio) < _NEAR_REST for one in points)
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


def doubt(points: Sequence[Coefficients]) -> str:
    """Say what cannot be true of K_T and K_Q by themselves; empty if nothing is odd.

    >>> doubt([Coefficients(0.0, 0.4, 0.5), Coefficients(0.5, 0.2, 0.35)]).split(":")[0]
    'K_Q is 125 % of K_T where the thrust is large, a screw has 8 to 30 %'
    """
    both = [
        (one.advance_ratio, one.thrust_coefficient, one.torque_coefficient)
        for one in points
        if one.thrust_coefficient is not None and one.torque_coefficient is not None
    ]
    most = max((one.thrust_coefficient or 0.0 for one in points), default=0.0)
    at_rest = any(abs(one.advance_ratio) < _NEAR_REST for one in points)
    if at_rest and 0.0 < most < _DOUBTFUL_K_T:
        return (
            f"K_T is {most:.2g} at most, a screw has 0.1 to 0.8: a unit, the speed or the diameter"
        )
    if not both:
        return ""
    largest = max(thrust for _, thrust, _ in both)
    loaded = [torque / thrust for _, thrust, torque in both if thrust > 0.6 * largest > 0.0]
    share = float(np.median(loaded)) if loaded else 0.15
    text = f"K_Q is {100 * share:.3g} % of K_T where the thrust is large, a screw has 8 to 30 %"
    if share > _LARGEST_TORQUE_SHARE:
        return f"{text}: is the column 10K_Q, not K_Q?"
    if 0.0 < share < _SMALLEST_TORQUE_SHARE:
        return f"{text}: is the column K_Q, not 10K_Q?"
    best = max(
        (efficiency(*one) for one in both if one[2] > 0.0 and one[1] > 0.05 * largest), default=0.0
    )
    if best > 1.0:
        return f"the efficiency J K_T / (2 pi K_Q) reaches {best:.2f}, at most 1 is possible"
    return ""
