"""What changed between two mooring tests: a common factor, or factors ahead and astern.

Thrust of B is regressed on that of A at equal codes, T_B = f T_A, once for all codes and once for
each sign. What is left of the common factor is what the readings scatter by, unless the two signs
have factors of their own.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.special import stdtr, stdtrit

from pipeline.errors import CannotComputeError
from pipeline.records.comparison import Curve, Difference
from pipeline.records.measurements import MooringPoint
from pipeline.types import FloatArray

#: Thrusts below this share of the largest say nothing of a factor.
_SMALL = 0.05
#: Two tests of one thruster differ by so much without a cause. [1]
ORDINARY = 0.02
_FEWEST = 3
_CHANCE = 0.01


def mean_curve(points: Sequence[MooringPoint]) -> tuple[FloatArray, FloatArray]:
    """Codes, rising, and the mean thrust at each [N]; marked points are left out."""
    fitted = [(point.code, point.thrust_n) for point in points if not point.marks]
    codes = np.unique([code for code, _ in fitted])
    thrust = [np.mean([one for code, one in fitted if code == each]) for each in codes]
    return codes, np.array(thrust, float)


def bench_changes(
    a: Sequence[MooringPoint], b: Sequence[MooringPoint]
) -> tuple[tuple[Difference, ...], tuple[Difference, ...], tuple[Curve, ...]]:
    """Compare two mooring tests: differences that stand, all that were asked for, and curves.

    Raises
    ------
    CannotComputeError
        When they have too few codes in common.
    """
    (code_a, thrust_a), (code_b, thrust_b) = mean_curve(a), mean_curve(b)
    if code_a.size < _FEWEST or code_b.size < _FEWEST:
        raise CannotComputeError("one of the two has fewer than three codes that can be used")
    inside = (code_b >= code_a.min()) & (code_b <= code_a.max())
    code, measured = code_b[inside], thrust_b[inside]
    before = np.interp(code, code_a, thrust_a)
    large = np.abs(before) > _SMALL * np.abs(thrust_a).max()
    if large.sum() < _FEWEST:
        raise CannotComputeError("they have no codes in common at which both give thrust")
    code, measured, before = code[large], measured[large], before[large]
    sides = {"thrust ahead": before > 0, "thrust astern": before < 0}
    sides = {what: own for what, own in sides.items() if own.sum() >= _FEWEST}
    asked = [_difference("common_factor", "thrust at every code", before, measured)]
    asked += [
        _difference("factor", what, before[own], measured[own]) for what, own in sides.items()
    ]
    factors = [_factor(before[own], measured[own]) for own in sides.values()]
    values, stds, _ = np.array(factors).reshape(-1, 3).T
    apart = values.size == 2 and abs(values[0] - values[1]) > 3.0 * float(
        np.sqrt(np.sum(np.square(stds)) + ORDINARY**2)
    )
    chosen = asked[1:] if apart else asked[:1]
    standing = tuple(one for one in chosen if one.p_value is not None and one.p_value < _CHANCE)
    curve = Curve(
        title="Thrust against code",
        x_label="control code",
        y_label="thrust  [N]",
        points=True,
        a_x=code_a.tolist(),
        a_y=thrust_a.tolist(),
        b_x=code_b.tolist(),
        b_y=thrust_b.tolist(),
    )
    return standing, tuple(asked), (curve,)


def _factor(before: FloatArray, measured: FloatArray) -> tuple[float, float, float]:
    """Factor, its standard deviation, and what it leaves [N rms]."""
    power = float(before @ before)
    value = float(before @ measured) / power
    left = measured - value * before
    scatter = float(left @ left) / max(left.size - 1, 1)
    return value, (scatter / power) ** 0.5, float(np.sqrt(np.mean(left**2)))


def _difference(
    kind: Literal["common_factor", "factor"], what: str, before: FloatArray, measured: FloatArray
) -> Difference:
    value, std, left = _factor(before, measured)
    degrees = max(before.size - 1, 1)
    wide = float(np.hypot(std, ORDINARY / 2.0))
    chance = 2.0 * float(stdtr(degrees, -abs(value - 1.0) / wide))
    half = float(stdtrit(degrees, 0.975)) * std
    text = (
        f"{what}: B gives {value:.2f} ({value - half:.2f} to {value + half:.2f}) of A; "
        f"what is left is {left:.2g} N rms."
    )
    return Difference(
        kind=kind,
        what=what,
        unit="N",
        a=float(np.abs(before).max()),
        b=float(np.abs(measured).max()),
        ratio=value,
        ci95=(value - half, value + half),
        p_value=chance,
        text=text,
    )
