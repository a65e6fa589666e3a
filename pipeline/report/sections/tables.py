"""What several chapters share: ours beside the published, a fit's line, provenance."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records.fit_values import speed_index, static_thrust, table2_thrust, table4_code
from pipeline.records.fits import (
    FitQuality,
    Interval,
    PolynomialFit,
    SpeedInverse,
    StaticCharacteristic,
)
from pipeline.report.blocks import Block, Blocks, Bullets, Details, Table, Text, chapter
from pipeline.report.numbers import as_printed, fixed, general, plural, speed, with_interval
from pipeline.report.results import DayResults, RunResults, VehicleResults
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


#: More remarks than this are folded away.
EXPLANATIONS_SHOWN = 8


@dataclass(frozen=True)
class Column:
    """What was fitted at one speed, and what was printed for its coefficients."""

    speed_mps: float
    own: PolynomialFit | SpeedInverse
    table: PublishedTable2 | PublishedTable4 | None

    @property
    def printed(self) -> Sequence[float] | None:
        """As in the published table, None where it has not this speed."""
        return printed_row(self.table, self.speed_mps)

    def coefficients(self, names: Sequence[str]) -> list[Coefficient]:
        """Return each with its interval, named with the speed."""
        named = [f"{name} at {speed(self.speed_mps)} m/s" for name in names]
        return coefficients(named, self.own.coefficients, self.own.ci95, self.printed)


#: Name, our cells, and the printed ones.
PaperRow = tuple[str, Sequence[str], Sequence[str]]


def paper_rows(names: Sequence[str], columns: Sequence[Column]) -> list[PaperRow]:
    """Return a row for each coefficient, a cell for each speed."""
    return [
        (
            name,
            [with_interval(one.own.coefficients[k], one.own.ci95[k])[0] for one in columns],
            ["–" if one.printed is None else as_printed(one.printed[k]) for one in columns],
        )
        for k, name in enumerate(names)
    ]


def paper_table(
    caption: str, columns: Sequence[Column], rows: Sequence[PaperRow], note: str, points: str = ""
) -> Table:
    """Set coefficients over speed as the paper does, what was printed below ours.

    `points` names the figure of what they were fitted to; each name leads there.
    """
    published = any(one.printed is not None for one in columns)
    body: list[tuple[str, ...]] = []
    for name, ours, printed in rows:
        body += [(name, *ours), *([("published", *printed)] if published else [])]
    ours_at = [place for place, row in enumerate(body) if row[0] != "published"]
    return Table(
        caption,
        ("Coefficient", *(f"{speed(one.speed_mps)} m/s" for one in columns)),
        tuple(body),
        row_classes=tuple("" if at in ours_at else "published" for at in range(len(body))),
        links={(at, 0): f"#{points}" for at in ours_at} if points else {},
        note=note,
    )


def coefficient_table(
    caption: str, rows: Sequence[Coefficient], note: str = "", *, points: str = ""
) -> Table:
    """Coefficients with intervals, beside the published ones where there are any.

    `points` names the figure of what they were fitted to; each value leads there.
    """
    published = any(one.published is not None for one in rows)
    links = {(row, 1): f"#{points}" for row in range(len(rows))} if points else {}

    def cells(one: Coefficient) -> dict[str, str]:
        value, interval = with_interval(one.value, one.interval)
        own = {"Coefficient": one.name, "Value": value, "95 % interval": interval}
        return own | (_published_cells(one) if published else {})

    return Table.of(caption, rows, cells, note=note, links=links)


def _published_cells(one: Coefficient) -> dict[str, str]:
    if one.published is None:
        return dict.fromkeys(("Published", "Difference", "Published inside"), "–")
    difference, away = one.value - one.published, one.half_widths_away
    verdict = "yes" if one.inside else "no"
    if away is not None and not one.inside:
        # just outside, two figures would read as 1.0: inside
        verdict += f", {general(away, 3 if away < 1.05 else 2)} half-widths away"
    return {
        "Published": as_printed(one.published),
        "Difference": ("+" if difference > 0 else "") + general(difference, 2),
        "Published inside": verdict,
    }


def quality_line(name: str, quality: FitQuality, variable: str) -> str:
    """One sentence: points, spread, R2, validity range."""
    unit = "" if quality.unit == "1" else f" {quality.unit}"
    low, high = (
        fixed(end, 0) if float(end).is_integer() else general(end, 3) for end in quality.valid_range
    )
    outliers = len(quality.outliers)
    left = f", {plural(outliers, 'outlier')} named and not fitted" if outliers else ""
    return (
        f"{name}: {quality.points} points fitted{left}; residual standard deviation "
        f"{general(quality.residual_std, 3)}{unit}; R² {quality.r_squared:.5f}; valid for "
        f"{variable} from {low} to {high}."
    )


def explained(texts: Sequence[str]) -> Block | None:
    """List what a stage assumed or could not do, folded away where it is long."""
    listed = Bullets(tuple(texts)) if texts else None
    if listed is None or len(texts) <= EXPLANATIONS_SHOWN:
        return listed
    return Details(f"{len(texts)} remarks on this result", (listed,))


def share_inside(rows: Sequence[Coefficient]) -> str:
    """Count the published coefficients inside our intervals; nothing where none is known."""
    known = [bool(one.inside) for one in rows if one.inside is not None]
    if not known:
        return ""
    text = f"{sum(known)} of the {len(known)} published coefficients lie inside our 95 % intervals."
    if all(known):
        return text
    return (
        f"{text} Coefficients of one curve lean on each other and their intervals carry the "
        "bench's noise alone: the difference of the curves is what to read."
    )


@chapter("provenance", "Provenance")
def data_section(results: RunResults | DayResults | VehicleResults) -> Blocks:
    """Say what a page was made from."""
    header, lines = ("What", "Digest or version"), tuple(results.provenance.items())
    none = Text("No provenance was recorded.")
    yield Table("Inputs, code and versions", header, lines) if lines else none
