"""Pictures of a blind check: which truth got which answer, and rates with their bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.report.plotting import BLUE, INK, ORANGE, SOFT, WIDTH, axes_at, draw

if TYPE_CHECKING:
    import matplotlib.figure


def confusion_picture(
    truths: Sequence[str], answers: Sequence[str], counts: Sequence[Sequence[int]]
) -> str:
    """Draw the confusion matrix; each row is shaded by its own shares.

    Parameters
    ----------
    truths, answers : sequence of str
        Names of rows and columns.
    counts : sequence of sequence of int
        Cases, by row.

    Returns
    -------
    str
        SVG.
    """
    table = np.array(counts, float).reshape(len(truths), len(answers))
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0)
    left, top, cell = 12.0 + 3.2 * max(map(len, truths)), 8.0, 9.4
    low = top + cell * len(truths)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = axes_at(figure, left, top, WIDTH - 4.0, low, "answer", "truth")
        axes.pcolormesh(shares, cmap="Blues", vmin=0.0, vmax=1.0)
        for i, j in zip(*np.nonzero(table), strict=True):
            axes.text(
                j + 0.5, i + 0.5, f"{table[i, j]:.0f}", ha="center", va="center", fontsize=5,
                color="white" if shares[i, j] > 0.6 else INK,
            )  # fmt: skip
        axes.set_xticks(np.arange(len(answers)) + 0.5, answers, rotation=90, fontsize=5.5)
        axes.set_yticks(np.arange(len(truths)) + 0.5, truths, fontsize=5.5)
        axes.yaxis.set_label_coords((12.0 - left) / (WIDTH - left), 0.5)
        axes.set_ylim(len(truths), 0)
        axes.grid(visible=False)

    height = low + 20.0 + 3.2 * max(map(len, answers))
    return draw("confusion", "Which answer each truth got.", height, paint)


def rates_picture(rows: Sequence[tuple[str, float, float, float, bool]]) -> str:
    """Draw rates with their bounds, one below the other; those that miss their goal are orange.

    Parameters
    ----------
    rows : sequence of (str, float, float, float, bool)
        What it is, the rate, its lower and upper bound, and whether its goal is met.

    Returns
    -------
    str
        SVG.
    """
    names, share, low, high, met = zip(*rows, strict=True) if rows else ((),) * 5
    levels, whole = 10.0 * np.arange(len(rows)) + 6.0, 4.0 + 10.0 * max(len(rows), 1)
    left = min(12.0 + 3.0 * max(map(len, names), default=0), 0.6 * WIDTH)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = axes_at(figure, left, 4.0, WIDTH - 8.0, whole + 4.0, "rate with 95 % bounds")
        axes.hlines(levels, low, high, color=SOFT, lw=1.2)
        axes.scatter(share, levels, 16, [BLUE if one else ORANGE for one in met], zorder=3, lw=0)
        axes.set_yticks(levels, names, fontsize=5)
        axes.set(xlim=(-0.02, 1.02), ylim=(whole, 0.0))
        axes.grid(visible=False, axis="y")

    return draw("rates", "Rates with their bounds.", whole + 34.0, paint)
