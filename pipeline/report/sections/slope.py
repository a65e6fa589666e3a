"""Acceleration against thrust on straight stretches: figure 4 of Potapov and Galyaev."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from pipeline.records.identification import StraightLineIdentification
from pipeline.report import plotting

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def slope_figure(found: StraightLineIdentification) -> Markup:
    """Draw the points, the fitted slopes that stand, and that of the dry mass alone."""
    thrust, acceleration = np.array(found.points).reshape(-1, 2).T
    ends = np.array([thrust.min(), thrust.max()])

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.plot(thrust, acceleration, ".", color=plotting.SOFT, markersize=3, label="measured")
        lines = [("dry mass", found.dry_mass_kg, plotting.ORANGE)]
        lines += [
            (one.estimator, one.total_mass_kg, colour)
            for one, colour in (
                (found.plain[0], plotting.VERMILLION), (found.with_terms, plotting.BLUE),
            )
            if one is not None and not one.refused
        ]  # fmt: skip
        for label, mass, colour in lines:
            level = acceleration.mean() + (ends - thrust.mean()) / mass
            axes.plot(ends, level, color=colour, label=label)
        axes.set_xlabel("thrust along the axis [N]")
        axes.set_ylabel("acceleration [m/s²]")
        axes.legend(loc="best")

    alt = f"acceleration against thrust, {found.axis}, {len(found.segments)} straight stretches"
    return plotting.draw(f"slope-{found.axis}", alt, paint, height_in=3.0)
