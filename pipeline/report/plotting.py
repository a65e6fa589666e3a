"""One calm style for every figure, and SVG that is the same bytes for the same data.

Figures are drawn 4.4 in wide, so that their text is still readable when a telephone shrinks them
to its width. Colours are safe for the colour-blind: Okabe and Ito for kinds of data, viridis for
what has an order (speed, code).
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup, escape

from pipeline.language import ENGLISH, current, translate
from pipeline.types import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH_IN = 4.4
INK = "#1b1f24"
SOFT = "#6b737c"
BLUE, ORANGE, GREEN, VERMILLION, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7"
#: Above this many points a scatter is embedded as a picture: the page stays small.
VECTOR_POINTS_MAX = 500

_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "rig2sea",
    "svg.fonttype": "none",
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "legend.labelspacing": 0.3,
    "legend.borderpad": 0.1,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.8,
    "axes.labelcolor": INK,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#dfe3e8",
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "lines.linewidth": 1.5,
    "lines.markersize": 3.5,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "savefig.facecolor": "none",
    "figure.constrained_layout.w_pad": 0.05,
    "figure.constrained_layout.h_pad": 0.05,
    "savefig.dpi": 200,
}


def draw(name: str, alt: str, paint: Callable[[Figure], None], *, height_in: float = 3.4) -> Markup:
    """Run `paint` on an empty figure and return it as inline SVG.

    Parameters
    ----------
    name : str
        Unique on the page; prefixes every id inside the SVG.
    alt : str
        What the picture shows, for those who do not see it.
    paint : callable
        Receives the figure.
    height_in : float
        Height; the width is the same for all figures. [in]

    Returns
    -------
    Markup
        ``<svg role="img" aria-label=...>``.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
        paint(figure)
        if current() != ENGLISH:
            _translate(figure)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return _inline(buffer.getvalue(), name, translate(alt))


def ordered_colours(count: int) -> list[str]:
    """Colours for `count` values in order, dark to light, none too pale for paper."""
    import matplotlib as mpl
    from matplotlib.colors import to_hex

    shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.82, max(count, 1)))
    return [to_hex(shade) for shade in shades]


def plain_log_axis(axes: Axes) -> None:
    """Make the y axis logarithmic with ticks written as plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_yscale("log")
    low, high = axes.get_ylim()
    decades = np.log10(high / low)
    subs = (1.0, 2.0, 5.0) if decades < 2.5 else (1.0,)
    axes.yaxis.set_major_locator(LogLocator(base=10.0, subs=subs))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def line_end_label(axes: Axes, x: FloatArray, y: FloatArray, text: str) -> None:
    """Write a line's name at its right end."""
    at = (float(x[-1]), float(y[-1]))
    axes.annotate(text, at, xytext=(3, 0), textcoords="offset points", va="center", fontsize=8)


def _translate(figure: Figure) -> None:
    """Translate what is written on a figure, before the room for it is found."""
    from matplotlib.text import Text
    from matplotlib.ticker import FixedFormatter

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            names = axis.get_major_formatter()
            if isinstance(names, FixedFormatter):
                names.seq = [translate(name) for name in names.seq]
    for text in figure.findobj(Text):
        if isinstance(text, Text) and text.get_text():
            text.set_text(translate(text.get_text()))


def _inline(svg: str, name: str, alt: str) -> Markup:
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    referenced = set(re.findall(r'(?:href="|url\()#([^")]+)', svg))

    def rename(match: re.Match[str]) -> str:
        return f' id="{name}-{match[1]}"' if match[1] in referenced else ""

    svg = re.sub(r' id="([^"]*)"', rename, svg)
    svg = re.sub(r'(href="|url\()#', rf"\1#{name}-", svg)
    svg = svg.replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")
    svg = re.sub(r"\n\s*", "\n", svg)
    if current() != ENGLISH:  # the numbers at the axes
        svg = re.sub(r">([\u2212-]?\d+)\.(\d+)<", r">\1,\2<", svg)
    width, height = re.findall(r'(?:width|height)="([\d.]+)pt"', svg)[:2]
    head = (
        f'<svg class="plot" role="img" aria-label="{escape(alt)}" '
        f'viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg" '
        'xmlns:xlink="http://www.w3.org/1999/xlink">'
    )
    return Markup(re.sub(r"^<svg[^>]*>", lambda _: head, svg))  # noqa: S704 - our own drawing
