"""The curves of a fit, its points and what it leaves, as they are drawn."""

from collections.abc import Sequence

import numpy as np

from pipeline.physics.propeller import polynomial
from pipeline.records.fit_values import polynomial_band
from pipeline.records.fits import PolynomialFit
from pipeline.report import plotting
from pipeline.report.panels import Trace


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
