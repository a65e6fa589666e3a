"""What several chapters share: coefficients, the choice of order, a fit's line, provenance."""

from collections.abc import Mapping, Sequence

from pipeline.records.fits import FitQuality
from pipeline.report.blocks import Block, Bullets, Details, Table
from pipeline.report.comparison import Coefficient
from pipeline.report.numbers import as_printed, fixed, general, plural, with_interval

#: More remarks than this are folded away.
EXPLANATIONS_SHOWN = 8


def coefficient_table(
    caption: str, coefficients: Sequence[Coefficient], note: str = "", *, points: str = ""
) -> Table:
    """Coefficients with intervals, beside the published ones where there are any.

    `points` names the figure of what they were fitted to; each value leads there.
    """
    published = any(coefficient.published is not None for coefficient in coefficients)
    header: tuple[str, ...] = ("Coefficient", "Value", "95 % interval")
    if published:
        header += ("Published", "Difference", "Published inside")
    rows = []
    for coefficient in coefficients:
        value, interval = with_interval(coefficient.value, coefficient.interval)
        row = [coefficient.name, value, interval]
        if published:
            row += _published_cells(coefficient)
        rows.append(tuple(row))
    links = {(row, 1): f"#{points}" for row in range(len(rows))} if points else {}
    return Table(caption, header, tuple(rows), note=note, links=links)


def _published_cells(coefficient: Coefficient) -> list[str]:
    if coefficient.published is None or coefficient.difference is None:
        return ["–", "–", "–"]
    sign = "+" if coefficient.difference > 0 else ""
    away = coefficient.half_widths_away
    verdict = "yes" if coefficient.inside else "no"
    if away is not None and not coefficient.inside:
        # just outside, two figures would read as 1.0: inside
        verdict += f", {general(away, 3 if away < 1.05 else 2)} half-widths away"
    return [
        as_printed(coefficient.published),
        sign + general(coefficient.difference, 2),
        verdict,
    ]


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


def explained(texts: Sequence[str]) -> list[Block]:
    """List what a stage assumed or could not do, folded away where it is long."""
    if len(texts) <= EXPLANATIONS_SHOWN:
        return [Bullets(tuple(texts))] if texts else []
    return [Details(f"{len(texts)} remarks on this result", (Bullets(tuple(texts)),))]


def share_inside(coefficients: Sequence[Coefficient], why: str = "") -> str:
    """Count the published coefficients that lie inside our intervals.

    Parameters
    ----------
    coefficients : sequence of Coefficient
        Those of one table.
    why : str
        What explains the others; said only where there are any.
    """
    known = [coefficient for coefficient in coefficients if coefficient.inside is not None]
    inside = sum(bool(coefficient.inside) for coefficient in known)
    text = f"{inside} of the {len(known)} published coefficients lie inside our 95 % intervals."
    return f"{text} {why}" if why and inside < len(known) else text


def _short(value: float) -> str:
    return fixed(value, 0) if float(value).is_integer() else general(value, 3)


def provenance_table(lines: Mapping[str, str]) -> Table:
    """Show digests and versions, line by line."""
    return Table(
        "Inputs, code and versions",
        ("What", "Digest or version"),
        tuple(lines.items()),
    )
