"""What several chapters share: coefficients, the layout of the paper, a fit's line, provenance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeline.records.fits import FitQuality, Interval
from pipeline.report.blocks import Block, Bullets, Details, Table
from pipeline.report.comparison import Coefficient, coefficients
from pipeline.report.numbers import as_printed, fixed, general, plural, speed, with_interval

#: More remarks than this are folded away.
EXPLANATIONS_SHOWN = 8


@dataclass(frozen=True)
class Column:
    """The coefficients of one speed, and what was printed for them."""

    speed_mps: float
    values: Sequence[float]
    intervals: Sequence[Interval]
    printed: Sequence[float] | None

    def coefficients(self, names: Sequence[str]) -> list[Coefficient]:
        """Return each with its interval, named with the speed."""
        named = [f"{name} at {speed(self.speed_mps)} m/s" for name in names]
        return coefficients(named, self.values, self.intervals, self.printed)


#: Name, our cells, and the printed ones.
PaperRow = tuple[str, Sequence[str], Sequence[str]]


def paper_rows(names: Sequence[str], columns: Sequence[Column]) -> list[PaperRow]:
    """Return a row for each coefficient, a cell for each speed."""
    return [
        (
            name,
            [with_interval(one.values[k], one.intervals[k])[0] for one in columns],
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
    cells = [_cells(one) | (_published_cells(one) if published else {}) for one in rows]
    return Table.of(caption, cells, note=note, links=links)


def _cells(one: Coefficient) -> dict[str, str]:
    value, interval = with_interval(one.value, one.interval)
    return {"Coefficient": one.name, "Value": value, "95 % interval": interval}


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
    low, high = (_short(end) for end in quality.valid_range)
    outliers = len(quality.outliers)
    left = f", {plural(outliers, 'outlier')} named and not fitted" if outliers else ""
    return (
        f"{name}: {quality.points} points fitted{left}; residual standard deviation "
        f"{general(quality.residual_std, 3)}{unit}; R² {quality.r_squared:.5f}; valid for "
        f"{variable} from {low} to {high}."
    )


def _short(value: float) -> str:
    return fixed(value, 0) if float(value).is_integer() else general(value, 3)


def explained(texts: Sequence[str]) -> list[Block]:
    """List what a stage assumed or could not do, folded away where it is long."""
    if len(texts) <= EXPLANATIONS_SHOWN:
        return [Bullets(tuple(texts))] if texts else []
    return [Details(f"{len(texts)} remarks on this result", (Bullets(tuple(texts)),))]


def share_inside(rows: Sequence[Coefficient]) -> str:
    """Count the published coefficients that lie inside our intervals; nothing where none is known.

    Parameters
    ----------
    rows : sequence of Coefficient
        Those of one table.
    """
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


def provenance_table(lines: Mapping[str, str]) -> Table:
    """Show digests and versions, line by line."""
    header = ("What", "Digest or version")
    return Table("Inputs, code and versions", header, tuple(lines.items()))
