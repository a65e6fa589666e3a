"""What a figure of curves over a common axis shows, however it is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipeline.report.decimate import BUCKETS
from pipeline.types import FloatArray

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
    traces: tuple[Trace, ...]
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

        Examples
        --------
        >>> Resolution.shared(10), Resolution.shared(240)
        (Resolution(still=400, zoom=1000), Resolution(still=66, zoom=187))
        """
        points = 2 * max(curves, 1)  # every stretch keeps two
        return cls(
            still=int(np.clip(STILL_POINTS // points, 40, BUCKETS)),
            zoom=int(np.clip(ZOOM_POINTS // points, 120, ZOOM_BUCKETS)),
        )


def label_lines(panels: Sequence[Panel]) -> int:
    """Lines of the longest label."""
    return max(1 + panel.label.count("\n") for panel in panels)
