"""Ours beside the published: coefficients with intervals, differences in newtons and codes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records.fits import Interval, PolynomialFit, SpeedInverse, StaticCharacteristic
from pipeline.report.curves import speed_index, static_thrust, table2_thrust, table4_code
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.bench_schema import PublishedTable2, PublishedTable4

#: Below this thrust the paper sends code 0 (eq. 7 and 8); comparisons start here. [N]
THRUST_FROM_N = 0.5


@dataclass(frozen=True)
class Coefficient:
    """One coefficient, its interval and what was printed for it."""

    name: str
    value: float
    interval: Interval
    published: float | None

    @property
    def inside(self) -> bool | None:
        """Whether the published value lies in our interval."""
        if self.published is None:
            return None
        return self.interval[0] <= self.published <= self.interval[1]

    @property
    def half_widths_away(self) -> float | None:
        """Distance of the published value from ours in half-widths of the interval."""
        half_width = (self.interval[1] - self.interval[0]) / 2
        if self.published is None or half_width <= 0:
            return None
        return abs(self.value - self.published) / half_width


def coefficients(
    names: Sequence[str],
    values: Sequence[float],
    intervals: Sequence[Interval],
    published: Sequence[float] | None,
) -> list[Coefficient]:
    """Pair coefficients with published ones; missing published coefficients are None."""
    printed = [*(published or ()), *[None] * len(values)]
    return [
        Coefficient(name, value, interval, other)
        for name, value, interval, other in zip(names, values, intervals, printed, strict=False)
    ]


def printed_row(
    table: PublishedTable2 | PublishedTable4 | None, speed_mps: float
) -> tuple[float, ...] | None:
    """Return K_F0 ... K_F2 or K_N0 ... K_N3 as printed for a speed; None where there are none."""
    index = None if table is None else speed_index(table.speed_mps, speed_mps)
    if table is None or index is None:
        return None
    if isinstance(table, PublishedTable2):
        return table.KF0[index], table.KF1[index], table.KF2[index]
    return table.KN0[index], table.KN1[index], table.KN2[index], table.KN3[index]


def largest(places: ArrayLike, difference: FloatArray | None) -> tuple[float, float] | None:
    """Return the size of a difference where it is largest, and the place; None where all is NaN.

    >>> largest([1.0, 2.0, 3.0], np.array([0.1, -0.4, np.nan]))
    (0.4, 2.0)
    """
    if difference is None or np.isnan(difference).all():
        return None
    worst = int(np.nanargmax(np.abs(difference)))
    return abs(float(difference[worst])), float(np.asarray(places)[worst])


def fit_difference(fit: PolynomialFit, published: Sequence[float], at: ArrayLike) -> FloatArray:
    """Return our polynomial less the published one."""
    return polynomial(at, np.asarray(fit.coefficients)) - polynomial(at, np.asarray(published))


def largest_relative_difference(
    fit: PolynomialFit, published: Sequence[float], upper: float
) -> float:
    """Largest difference of two polynomials over 0 ... upper, relative to the published at 0."""
    difference = fit_difference(fit, published, np.linspace(0.0, upper, 201))
    return float(np.max(np.abs(difference)) / abs(published[0]))


def table2_differences(
    static: StaticCharacteristic, published: PublishedTable2, codes: ArrayLike
) -> Iterator[tuple[str, float, FloatArray]]:
    """Yield what of ours it is, the speed, and thrust by ours less the published at positive codes.

    Speeds are those of both tables; NaN where the published thrust is next to nothing. [N]
    """
    for row in static.table2:
        printed = printed_row(published, row.speed_mps)
        index = speed_index(static.speed_mps, row.speed_mps)
        if printed is None or index is None:
            continue
        theirs = table2_thrust(printed, codes)
        quadratic = table2_thrust(np.asarray(row.fit.coefficients), codes)
        family = static_thrust(static, index, codes)
        for name, ours in (("the family", family), ("our quadratic Table 2", quadratic)):
            yield name, row.speed_mps, np.where(theirs > THRUST_FROM_N, ours - theirs, np.nan)


def table4_difference(
    row: SpeedInverse, published: PublishedTable4, thrust_n: ArrayLike
) -> FloatArray | None:
    """Return code by our Table 4 less the published; NaN in the dead zone or above a T_max."""
    index = speed_index(published.speed_mps, row.speed_mps)
    printed = printed_row(published, row.speed_mps)
    if index is None or printed is None:
        return None
    limit = min(row.thrust_max_n, published.T_max_n[index])
    thrust = np.asarray(thrust_n, float)
    difference = table4_code(row.coefficients, thrust) - table4_code(printed, thrust)
    return np.where((thrust > THRUST_FROM_N) & (thrust <= limit), difference, np.nan)
