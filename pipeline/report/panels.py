"""What a figure of curves over a common axis shows, however it is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records.fit_values import polynomial_band
from pipeline.records.fits import PolynomialFit
from pipeline.report import plotting
from pipeline.types import FloatArray

#: A figure is drawn some 320 points wide; twice that shows all that can be seen.
BUCKETS = 400
#: Stretches of the axis whose lowest and highest value the interactive figure keeps.
ZOOM_BUCKETS = 1000
#: Points of all curves of a page, in either drawing: what keeps it below 3 MB.
STILL_POINTS, ZOOM_POINTS = 32_000, 90_000

Style = Literal["line", "steps", "points", "both"]
Dash = Literal["", "dash", "dot"]


@dataclass(frozen=True)
class Trace:
    """One curve: `x` and `values` (k,); values not a number break the line.

    `bars` (2, k) are the ends of an interval around each value, `band` (2, k) the edges of what
    is shaded about the curve, and `end` is written at its right end. Style "both" is a line with
    its points marked by `mark`, one of ``.ox^vsD``, `hollow` where they are not filled. Without a
    name it is not in the legend.
    """

    name: str
    x: FloatArray
    values: FloatArray
    colour: str
    style: Style = "line"
    width: float = 1.2
    bars: FloatArray | None = None
    band: FloatArray | None = None
    dash: Dash = ""
    mark: str = "."
    hollow: bool = False
    end: str = ""


@dataclass(frozen=True)
class Span:
    """A stretch of the horizontal axis that is shaded."""

    start: float
    end: float
    colour: str


@dataclass(frozen=True)
class Panel:
    """Curves with one vertical axis.

    A grey band of +-`band` around `middle` is drawn where it is given; `limits` are dotted lines
    across, `spans` shaded from bottom to top. The axis is logarithmic where `log`, and begins at
    zero where `from_zero`.
    """

    label: str
    traces: Sequence[Trace]
    height: float = 1.0
    band: float | None = None
    middle: float = 0.0
    y_range: tuple[float, float] | None = None
    limits: tuple[float, ...] = ()
    spans: tuple[Span, ...] = ()
    log: bool = False
    from_zero: bool = False


@dataclass(frozen=True)
class Axis:
    """The horizontal axis: its ends, and names of 0, 1, 2 ... where it counts things."""

    ends: tuple[float, float] | None = None
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Resolution:
    """Stretches of the axis that keep their lowest and highest value, in either drawing."""

    still: int = BUCKETS
    zoom: int = ZOOM_BUCKETS

    @classmethod
    def shared(cls, curves: int) -> "Resolution":
        """Share the points of a page among its curves.

        >>> Resolution.shared(10), Resolution.shared(240)
        (Resolution(still=400, zoom=1000), Resolution(still=66, zoom=187))
        """
        points = 2 * max(curves, 1)  # every stretch keeps two
        return cls(
            still=int(np.clip(STILL_POINTS // points, 40, BUCKETS)),
            zoom=int(np.clip(ZOOM_POINTS // points, 120, ZOOM_BUCKETS)),
        )


def thinned(x: FloatArray, values: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Keep the lowest and the highest value of each stretch, and the breaks between a few pieces.

    x rises; values not a number break the line, of many pieces where a stretch has no other. Series
    of up to twice as many points as there are stretches are kept as they are.

    >>> x = np.arange(10_000) / 100
    >>> values = np.sin(x); values[5_000], values[7_000] = 9.0, np.nan
    >>> shown_x, shown = thinned(x, values, 50)
    >>> len(shown) <= 150, float(np.nanmax(shown)), float(shown_x[np.nanargmax(shown)])
    (True, 9.0, 50.0)
    >>> int(np.isnan(shown).sum())
    1
    """
    finite = np.isfinite(values)
    starts = np.flatnonzero(finite & ~np.concatenate([[False], finite[:-1]]))
    if finite.sum() <= 2 * buckets or len(starts) > buckets // 4:
        return _peaks(x, values, buckets)
    ends = np.flatnonzero(finite & ~np.concatenate([finite[1:], [False]])) + 1
    pieces: list[tuple[FloatArray, FloatArray]] = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        if pieces:
            pieces.append((x[start : start + 1], np.array([np.nan])))
        share = max(round(buckets * (end - start) / finite.sum()), 2)
        pieces.append(_peaks(x[start:end], values[start:end], share))
    return np.concatenate([one for one, _ in pieces]), np.concatenate([one for _, one in pieces])


def _peaks(x: FloatArray, values: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Keep the lowest and the highest value of each stretch, in their order."""
    finite = np.isfinite(values)
    if finite.sum() <= 2 * buckets:
        kept = finite | np.concatenate([[False], finite[:-1]])
        return x[kept], values[kept]
    span = float(x[-1] - x[0]) or 1.0
    bucket = np.minimum(((x - x[0]) / span * buckets).astype(int), buckets - 1)
    kept_rows: list[int] = []
    edges = np.searchsorted(bucket, np.arange(buckets + 1))
    for begin, end in pairwise(edges.tolist()):
        rows = np.arange(begin, end)[finite[begin:end]]
        if rows.size:
            own = values[rows]
            kept_rows += sorted({int(rows[own.argmin()]), int(rows[own.argmax()])})
        elif end > begin:
            kept_rows.append(begin)  # an empty stretch breaks the line
    return x[kept_rows], values[kept_rows]


def fit_panels(
    fit: PolynomialFit, name: str, colour: str, printed: Sequence[float] | None, scale: float = 1.0
) -> tuple[list[Trace], Trace]:
    """Return a fit as curves (points, outliers, line with band, published line) and what it leaves.

    `printed` are published coefficients; all is multiplied by `scale`.
    """
    x = np.linspace(*fit.quality.valid_range, 200)
    value, half = polynomial_band(fit, x)
    band = scale * np.array([value - half, value + half])
    found = [Trace(name, x, scale * value, colour, band=band)]
    kept = [p for p in fit.points if not p.outlier]
    for what, mark in (("measured", "o"), ("outlier", "x")):
        points = kept if what == "measured" else [p for p in fit.points if p.outlier]
        if points:
            at, measured = np.array([(p.x, p.measured) for p in points]).T
            found.append(Trace(what, at, scale * measured, colour, "points", mark=mark))
    if printed is not None:
        own = scale * polynomial(x, np.asarray(printed))
        found.append(Trace("published", x, own, plotting.INK, dash="dash"))
    left = np.array([(p.x, scale * (p.measured - p.fitted)) for p in kept]).reshape(-1, 2).T
    return found, Trace("", left[0], left[1], colour, "points", mark="o")
