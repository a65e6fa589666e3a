"""Still pictures as inline SVG: one calm style, and the same bytes for the same data.

Lengths are points. Pictures are 4.4 in wide, so that their text is still readable when a telephone
shrinks them to its width. They are written without a plotting library, which took ten times as
long as all else on a page. Colours are safe for the colour-blind: Okabe and Ito for kinds of data,
viridis for what has an order (speed, code).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from markupsafe import Markup, escape

from pipeline.language import ENGLISH, current, translate
from pipeline.report.numbers import fixed, general
from pipeline.types import FloatArray

WIDTH, SIZE = 316.8, 9.0
INK, SOFT, _GRID = "#1b1f24", "#6b737c", "#dfe3e8"
BLUE, ORANGE, GREEN, VERMILLION, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7"
Mark = Literal[".", "o", "x", "^", "v", "s", "D"]
#: Outlines about (0, 0); what is round is a line without length.
_MARKS: dict[Mark, str] = {
    "x": "m-2-2l4 4m0-4l-4 4",
    "^": "m0-2.2l2 4h-4z",
    "v": "m0 2.2l2-4h-4z",
    "s": "m-1.8-1.8h3.6v3.6h-3.6z",
    "D": "m0-2.3l2.3 2.3l-2.3 2.3l-2.3-2.3z",
}
_DASHES = {"dash": "4 2", "dot": "1 2"}
#: Viridis from dark to light.
_ORDER = ("440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725")
_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
#: What lies farther off the picture is drawn there.
_FAR = 5000.0


def ordered_colours(count: int) -> list[str]:
    """Colours for `count` values in order, dark to light, none too pale for paper."""
    return shades(np.linspace(0.0, 0.82, max(count, 1)))


def shades(shares: FloatArray) -> list[str]:
    """Colours of the scale from dark (0) to light (1), of shares shape (n,)."""
    anchors = np.array([[int(one[k : k + 2], 16) for k in (0, 2, 4)] for one in _ORDER], float)
    at = np.linspace(0.0, 1.0, len(anchors))
    mixed = np.column_stack([np.interp(shares, at, column) for column in anchors.T])
    return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in mixed.round().astype(int).tolist()]


@dataclass(frozen=True)
class Scale:
    """Values from `low` to `high` on the points from `start` to `end`."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def at(self, values: FloatArray | Sequence[float] | float) -> FloatArray:
        """Return the places of values [pt]."""
        own, low, high = np.asarray(values, float), self.low, self.high
        if self.log:
            own = np.log10(np.where(own > 0.0, own, np.nan))
            low, high = np.log10(low), np.log10(high)
        places = self.start + (own - low) / (high - low) * (self.end - self.start)
        return np.asarray(np.clip(places, -_FAR, _FAR))

    def ticks(self, most: int) -> list[tuple[float, str]]:
        """Return some three to `most` round values with their texts.

        >>> [text for _, text in Scale(0.0, 1.1, 0.0, 1.0).ticks(4)]
        ['0.0', '0.5', '1.0']
        """
        if self.log:
            decades = np.arange(np.floor(np.log10(self.low)), np.ceil(np.log10(self.high)) + 1)
            parts = (1.0, 2.0, 5.0) if len(decades) < 4 else (1.0,)
            every = [part * 10.0**decade for decade in decades for part in parts]
            return [(v, _number(f"{v:g}")) for v in every if self.low <= v <= self.high]
        bottom, top = sorted((self.low, self.high))
        raw = (top - bottom) / most
        power = 10.0 ** float(np.floor(np.log10(raw)))
        values: list[float] = []
        # the first round step that is large enough, or a finer one where that gives one tick only
        finest = next(k for k, part in enumerate(_STEPS) if part * power >= 0.999 * raw)
        for part in reversed(_STEPS[: finest + 1]):
            step = part * power
            first, last = np.ceil(bottom / step - 1e-9), np.floor(top / step + 1e-9)
            values = (step * np.arange(first, last + 1)).tolist()
            if len(values) > 1:
                break
        decimals = max(0, -int(np.floor(np.log10(values[1] - values[0]) + 1e-9)))
        long = decimals > 4 or max(map(abs, values)) >= 1e6
        return [(v, _number(general(v) if long else fixed(v, decimals))) for v in values]


def _number(text: str) -> str:
    return text if current() == ENGLISH else text.replace(".", ",")


def path(x: FloatArray, y: FloatArray, *, steps: bool = False) -> str:
    """Write a line through points [pt]; values not a number break it.

    >>> path(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0, np.nan, 3.0]))
    'M0 0L1 1M3 3'
    """
    if steps:
        x, y = np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
    there, parts, pen = (np.isfinite(x) & np.isfinite(y)).tolist(), [], "M"
    for a, b, shown in zip(np.round(x, 1).tolist(), np.round(y, 1).tolist(), there, strict=True):
        if shown:
            parts.append(f"{pen}{a:g} {b:g}")
        pen = "L" if shown else "M"
    return "".join(parts)


@dataclass
class Canvas:
    """A picture that is being drawn, `height` points high."""

    height: float
    parts: list[str] = field(default_factory=list)

    def text(  # noqa: PLR0917 - where, what and how
        self, x: float, y: float, text: str, anchor: str = "start", size: float = SIZE,
        turned: float = 0.0,
    ) -> None:  # fmt: skip
        """Write a text in the reader's language; `turned` degrees about its place."""
        turn = f' transform="rotate({turned:g} {x:.1f} {y:.1f})"' if turned else ""
        own = "" if size == SIZE else f' font-size="{size:g}"'
        side = "" if anchor == "start" else f' text-anchor="{anchor}"'
        words = escape(translate(text))
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}"{side}{own}{turn}>{words}</text>')

    def line(self, d: str, colour: str, width: float = 0.8, dash: str = "") -> None:
        """Draw a path."""
        own = f' stroke-dasharray="{_DASHES[dash]}"' if dash else ""
        self.parts.append(
            f'<path d="{d}" fill="none" stroke="{colour}" stroke-width="{width:g}"{own}/>'
        )

    def area(self, d: str, colour: str, opacity: float = 1.0) -> None:
        """Fill a path."""
        own = f' fill-opacity="{opacity:g}"' if opacity < 1.0 else ""
        self.parts.append(f'<path d="{d}z" fill="{colour}"{own}/>')

    def marks(
        self, x: FloatArray, y: FloatArray, colour: str, mark: Mark = "o", hollow: bool = False
    ) -> None:
        """Mark points; those on one spot are drawn once."""
        there = np.isfinite(x) & np.isfinite(y)
        at = np.unique(np.round(np.column_stack([x, y])[there], 1), axis=0).tolist()
        if mark in _MARKS:
            d = "".join(f"M{a:g} {b:g}{_MARKS[mark]}" for a, b in at)
            fill = "none" if mark == "x" else "#fff" if hollow else colour
            self.parts.append(f'<path d="{d}" fill="{fill}" stroke="{colour}"/>')
            return
        d, size = "".join(f"M{a:g} {b:g}h0" for a, b in at), 2.2 if mark == "." else 4.0
        for own, width in ((colour, size), ("#fff", size - 1.4))[: 1 + hollow]:
            self.parts.append(
                f'<path d="{d}" stroke="{own}" stroke-width="{width:g}" stroke-linecap="round"/>'
            )

    def finish(self, alt: str) -> Markup:
        """Return the picture; `alt` says what it shows to those who do not see it."""
        head = (
            f'<svg class="plot" role="img" aria-label="{escape(translate(alt))}" '
            f'viewBox="0 0 {WIDTH:g} {self.height:.0f}" xmlns="http://www.w3.org/2000/svg" '
            f'font-family="\'DejaVu Sans\', Verdana, sans-serif" font-size="{SIZE:g}" '
            f'fill="{INK}">'
        )
        return Markup("\n".join([head, *self.parts, "</svg>"]))  # noqa: S704 - our own drawing


@dataclass
class Frame:
    """A rectangle of a canvas with two scales; what is drawn `inside` is cut at its edges."""

    canvas: Canvas
    x: Scale
    y: Scale
    inside: Canvas = field(default_factory=lambda: Canvas(0.0))

    def across(self, low: float, high: float, colour: str, opacity: float) -> None:
        """Shade between two values of y, from side to side."""
        sides = [self.x.start, self.x.end, self.x.end, self.x.start]
        levels = self.y.at([low, low, high, high])
        self.inside.area(path(np.array(sides), levels), colour, opacity)

    def down(self, low: float, high: float, colour: str, opacity: float) -> None:
        """Shade between two values of x, from bottom to top."""
        levels = [self.y.start, self.y.start, self.y.end, self.y.end]
        self.inside.area(path(self.x.at([low, high, high, low]), np.array(levels)), colour, opacity)

    def close(
        self, x_label: str | None = None, y_label: str = "", *,
        x_ticks: Sequence[tuple[float, str]] | None = None, grid: bool = True, most: int = 6,
    ) -> None:  # fmt: skip
        """Put the frame on its canvas, with grid, ticks and labels; without `x_label` none of x."""
        canvas, x, y = self.canvas, self.x, self.y
        left, right, top, low = x.start, x.end, y.end, y.start
        slanted = x_ticks is not None and any(len(text) > 7 for _, text in x_ticks)
        x_ticks = x.ticks(most) if x_ticks is None else x_ticks
        y_ticks = y.ticks(4) if grid else []
        across = "".join(f"M{left:g} {at:.1f}H{right:g}" for at in y.at([v for v, _ in y_ticks]))
        places = x.at([v for v, _ in x_ticks])
        canvas.line(across + "".join(f"M{at:.1f} {low:g}V{top:g}" for at in places), _GRID, 0.6)
        for (_, text), at in zip(y_ticks, y.at([v for v, _ in y_ticks]), strict=True):
            canvas.text(left - 4, float(at) + 3, text, "end")
        box = f'x="{left:g}" y="{top:g}" width="{right - left:g}" height="{low - top:g}"'
        view = f"{left:g} {top:g} {right - left:g} {low - top:g}"
        canvas.parts += [f'<svg {box} viewBox="{view}">', *self.inside.parts, "</svg>"]
        canvas.line(f"M{left:g} {top:g}V{low:g}H{right:g}", SOFT)
        lines = translate(y_label).split("\n") if y_label else []
        for number, text in enumerate(reversed(lines)):
            canvas.text(left - 34 - 10.5 * number, (top + low) / 2, text, "middle", turned=-90.0)
        if x_label is None:
            return
        for (_, text), at in zip(x_ticks, places, strict=True):
            side, turn = ("end", -30.0) if slanted else ("middle", 0.0)
            canvas.text(float(at), low + 11, text, side, turned=turn)
        canvas.text((left + right) / 2, canvas.height - 4, x_label, "middle")
