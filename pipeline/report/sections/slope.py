"""Acceleration against thrust on straight stretches: figure 4 of Potapov and Galyaev."""

import numpy as np
from markupsafe import Markup

from pipeline.records.identification import StraightLineIdentification
from pipeline.report import plotting
from pipeline.report.zoomable import Panel, Trace, zoomable_figure


def slope_figure(found: StraightLineIdentification) -> Markup:
    """Draw the points, the fitted slopes that stand, and that of the dry mass alone."""
    thrust, acceleration = np.array(found.points).reshape(-1, 2).T
    ends = np.array([thrust.min(), thrust.max()])
    lines = [("dry mass", found.dry_mass_kg, plotting.ORANGE)]
    lines += [
        (one.estimator, one.total_mass_kg, colour)
        for one, colour in (
            (found.plain[0], plotting.VERMILLION), (found.with_terms, plotting.BLUE),
        )
        if one is not None and not one.refused
    ]  # fmt: skip
    traces = [Trace("measured", thrust, acceleration, plotting.SOFT, "points")]
    for label, mass, colour in lines:
        level = acceleration.mean() + (ends - thrust.mean()) / mass
        traces.append(Trace(label, ends, level, colour))
    said = f"acceleration against thrust, {found.axis}, {len(found.segments)} straight stretches"
    panel = Panel("acceleration  [m/s²]", traces, height=2.0)
    return zoomable_figure("slope", "", said, [panel], x_label="thrust along the axis  [N]").svg
