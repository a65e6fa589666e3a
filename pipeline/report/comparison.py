"""Ours beside the published: coefficients with intervals, differences in newtons and codes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records.fits import (
    Interval,
    PolynomialFit,
    SpeedInverse,
    StaticCharacteristic,
)
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
    def difference(self) -> float | None:
        """Ours less the published."""
        return None if self.published is None else self.value - self.published

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
        if self.difference is None or half_width <= 0:
            return None
        return abs(self.difference) / half_width


def coefficients(
    names: Sequence[str],
    values: Sequence[float],
    intervals: Sequence[Interval],
    published: Sequence[float] | None,
) -> tuple[Coefficient, ...]:
    """Pair coefficients with published ones; missing published coefficients are None."""
    printed: list[float | None] = list(published) if published is not None else []
    printed += [None] * (len(values) - len(printed))
    return tuple(
        Coefficient(name, value, interval, other)
        for name, value, interval, other in zip(names, values, intervals, printed, strict=False)
    )


def largest_relative_difference(
    fit: PolynomialFit, published: Sequence[float], upper: float
) -> float:
    """Largest difference of two polynomials over 0 ... upper, relative to the published at 0."""
    x = np.linspace(0.0, upper, 201)
    ours, theirs = polynomial(x, np.asarray(fit.coefficients)), polynomial(x, np.asarray(published))
    return float(np.max(np.abs(ours - theirs)) / abs(published[0]))


@dataclass(frozen=True)
class ThrustComparison:
    """Family and published Table 2 at the same codes, for one speed."""

    speed_mps: float
    code: FloatArray
    family_n: FloatArray
    polynomial_n: FloatArray
    published_n: FloatArray

    def largest_difference(self, ours: FloatArray) -> tuple[float, float] | None:
        """Ours less published where it is largest, and the code there. [N], [-]."""
        scored = self.published_n > THRUST_FROM_N
        difference = np.where(scored, ours - self.published_n, np.nan)
        if np.isnan(difference).all():
            return None
        worst = int(np.nanargmax(np.abs(difference)))
        return float(difference[worst]), float(self.code[worst])


def table2_row(published: PublishedTable2, index: int) -> tuple[float, float, float]:
    """Return the printed K_F0, K_F1, K_F2 of a row."""
    return published.KF0[index], published.KF1[index], published.KF2[index]


def compare_table2(
    static: StaticCharacteristic, published: PublishedTable2, codes: Sequence[float]
) -> tuple[ThrustComparison, ...]:
    """Compare thrust at the given positive codes for every speed that both tables have."""
    at = np.asarray(codes, float)
    compared = []
    for row, speed_mps in enumerate(published.speed_mps):
        index = speed_index(static.speed_mps, speed_mps)
        if index is None:
            continue
        printed = table2_row(published, row)
        own = next((r for r in static.table2 if abs(r.speed_mps - speed_mps) < 1e-6), None)
        compared.append(
            ThrustComparison(
                speed_mps,
                at,
                static_thrust(static, index, at),
                table2_thrust(np.asarray(own.fit.coefficients), at)
                if own is not None
                else np.full_like(at, np.nan),
                table2_thrust(np.asarray(printed), at),
            )
        )
    return tuple(compared)


def table3_difference(
    fit: PolynomialFit, published: Sequence[float], thrust_n: ArrayLike
) -> FloatArray:
    """Return code by our Table 3 less code by the published one at signed thrusts."""
    thrust = np.asarray(thrust_n, float)
    return polynomial(thrust, np.asarray(fit.coefficients)) - polynomial(
        thrust, np.asarray(published)
    )


def table4_row(published: PublishedTable4, speed_mps: float) -> tuple[float, ...] | None:
    """Return the printed K_N0 ... K_N3 at a speed, None if it is not tabulated."""
    index = speed_index(published.speed_mps, speed_mps)
    if index is None:
        return None
    columns = (published.KN0, published.KN1, published.KN2, published.KN3)
    return tuple(column[index] for column in columns)


def table4_difference(
    row: SpeedInverse, published: PublishedTable4, thrust_n: ArrayLike
) -> FloatArray | None:
    """Return code by our Table 4 less the published; NaN in the dead zone or above a T_max."""
    index = speed_index(published.speed_mps, row.speed_mps)
    printed = table4_row(published, row.speed_mps)
    if index is None or printed is None:
        return None
    limit = min(row.thrust_max_n, published.T_max_n[index])
    thrust = np.asarray(thrust_n, float)
    difference = table4_code(np.asarray(row.coefficients), thrust) - table4_code(
        np.asarray(printed), thrust
    )
    return np.where((thrust > THRUST_FROM_N) & (thrust <= limit), difference, np.nan)
