"""One calm style for every still picture, and SVG that is the same bytes for the same data.

Pictures are 4.4 in wide, so that their text is still readable when a telephone shrinks them to its
width. Every axes has a fixed place: finding room for all labels would take longer than all else on
a page. Colours are safe for the colour-blind: Okabe and Ito for kinds of data, viridis for what has
an order (speed, code).
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup, escape

from pipeline.language import ENGLISH, current, translate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Width of every picture. [pt]
WIDTH = 316.8
INK, SOFT, GRID = "#1b1f24", "#6b737c", "#dfe3e8"
BLUE, ORANGE, GREEN, VERMILLION, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7"
#: From the axes to the nearest line of the label of y. [pt]
_TO_LABEL = 37.0
#: Label of axes that serve again.
_PLAIN = "plain"
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none", "text.parse_math": False, "font.family": "DejaVu Sans", "font.size": 9,
    "axes.labelsize": 9, "xtick.labelsize": 9, "ytick.labelsize": 9, "legend.fontsize": 8.5,
    "legend.frameon": False, "legend.handlelength": 1.6, "legend.columnspacing": 1.2,
    "legend.labelspacing": 0.2, "legend.borderpad": 0.0, "legend.borderaxespad": 0.2,
    "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": SOFT,
    "axes.linewidth": 0.8, "axes.labelcolor": INK, "axes.labelpad": 2, "axes.grid": True,
    "axes.axisbelow": True, "axes.formatter.useoffset": False, "axes.formatter.limits": (-4, 6),
    "grid.color": GRID, "grid.linewidth": 0.6, "xtick.major.size": 0, "ytick.major.size": 0,
    "xtick.major.pad": 4, "ytick.major.pad": 4, "xtick.color": INK, "ytick.color": INK,
    "text.color": INK, "figure.facecolor": "none", "axes.facecolor": "none",
    "savefig.facecolor": "none", "savefig.dpi": 200,
}  # fmt: skip


def draw(name: str, alt: str, height: float, paint: Callable[[Figure], None]) -> Markup:
    """Run `paint` on an empty figure and return it as inline SVG.

    `name` is unique on the page: no id inside is that of another picture. `alt` says what it shows,
    for those who do not see it. The width is the same for all, `height` in points.
    """
    import matplotlib as mpl

    said = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    with mpl.rc_context({**_STYLE, "svg.hashsalt": name}):
        figure, free = _drawing()
        figure.set_size_inches(WIDTH / 72.0, height / 72.0)
        try:
            paint(figure)
            buffer = io.StringIO()
            figure.savefig(buffer, format="svg", metadata=said)
        finally:
            for axes in figure.axes:
                figure.delaxes(axes)
                if axes.get_label() == _PLAIN:
                    for artist in (*axes.lines, *axes.collections, *axes.patches, *axes.texts):
                        artist.remove()
                    free.append(axes)
            for beside in (*figure.legends, *figure.texts):
                beside.remove()
    return _inline(buffer.getvalue(), translate(alt))


@cache
def _drawing() -> tuple[Figure, list[Axes]]:
    """Return the figure of every picture, and the plain axes that are free.

    New axes with their ticks take longer than all that is drawn on them.
    """
    from matplotlib.figure import Figure

    return Figure(), []


def axes_at(  # noqa: PLR0917 - the four edges
    figure: Figure, left: float, top: float, right: float, low: float,
    x_label: str | None = None, y_label: str = "", *, ticks: tuple[int, int] = (6, 4),
    plain: bool = False,
) -> Axes:  # fmt: skip
    """Add axes whose edges are where they are told, from the upper left corner. [pt].

    Without `x_label` the horizontal axis is not drawn. `ticks` are round values at most, of x and
    of y. `plain` ones serve for pictures to come as well: their scales, tick labels and spines are
    left as they are.
    """
    from matplotlib.ticker import MaxNLocator

    height = 72.0 * figure.get_figheight()
    place = (left / WIDTH, 1.0 - low / height, (right - left) / WIDTH, (low - top) / height)
    free = _drawing()[1]
    if plain and free:
        axes = figure.add_axes(free.pop())
        axes.set_position(place)
        axes.relim()
        axes.set_xlim(0.0, 1.0, auto=True)
        axes.set_ylim(0.0, 1.0, auto=True)
    else:
        axes = figure.add_axes(place, label=_PLAIN if plain else "")
    for axis, most in zip((axes.xaxis, axes.yaxis), ticks, strict=True):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 5, 10], min_n_ticks=2))
    axes.set_ylabel(translate(y_label) if y_label else "")
    axes.yaxis.set_label_coords(-_TO_LABEL / (right - left), 0.5)
    axes.set_xlabel(translate(x_label) if x_label else "")
    axes.xaxis.set_visible(x_label is not None)
    return axes


def ordered_colours(count: int) -> list[str]:
    """Colours for `count` values in order, dark to light, none too pale for paper."""
    import matplotlib as mpl
    from matplotlib.colors import to_hex

    shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.82, max(count, 1)))
    return [to_hex(shade) for shade in shades]


def log_ticks(axes: Axes) -> None:
    """Write plain numbers along a logarithmic y axis whose limits are set."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = axes.get_ylim()
    subs = (1.0, 2.0, 5.0) if np.log10(high / low) < 2.5 else (1.0,)
    axes.yaxis.set_major_locator(LogLocator(subs=subs))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _inline(svg: str, alt: str) -> Markup:
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<(metadata|style)\b.*?</\1>|<!--.*?-->\n?", "", svg, flags=re.DOTALL)
    referenced = set(re.findall(r'(?:href="|url\()#([^")]+)', svg))
    svg = re.sub(r' id="([^"]*)"', lambda own: own[0] if own[1] in referenced else "", svg)
    # a hundredth of a point is enough
    svg = re.sub(r"<(?:path|use)[^>]*>", lambda tag: re.sub(r"(\.\d\d)\d+", r"\1", tag[0]), svg)
    svg = re.sub(
        r" ?\n\s*", "\n", svg.replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")
    )
    if current() != ENGLISH:  # the numbers at the axes
        svg = re.sub(r">([\u2212-]?\d+)\.(\d+)<", r">\1,\2<", svg)
    width, height = re.findall(r'(?:width|height)="([\d.]+)pt"', svg)[:2]
    head = (
        f'<svg class="plot" role="img" aria-label="{escape(alt)}" '
        f'viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg" '
        'xmlns:xlink="http://www.w3.org/1999/xlink" stroke-linejoin="round">'
    )
    return Markup(re.sub(r"^<svg[^>]*>", lambda _: head, svg))  # noqa: S704 - our own drawing
