"""Pictures of a blind check: which truth got which answer, and rates with their bounds."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.report.plotting import BLUE, INK, ORANGE, SOFT, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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

    def paint(figure: "Figure") -> None:
        axes = figure.subplots()
        axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
        axes.grid(visible=False)
        axes.set_xticks(range(len(answers)), answers, rotation=90, fontsize=5.5)
        axes.set_yticks(range(len(truths)), truths, fontsize=5.5)
        axes.set_xlabel("answer")
        axes.set_ylabel("truth")
        for i, j in zip(*np.nonzero(table), strict=True):
            colour = "white" if shares[i, j] > 0.6 else INK
            axes.text(
                j, i, f"{table[i, j]:.0f}", ha="center", va="center", fontsize=5, color=colour
            )

    height = 1.6 + 0.13 * len(truths)
    return _as_file(
        draw("blind-confusion", "Which answer each truth got.", paint, height_in=height)
    )


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

    def paint(figure: "Figure") -> None:
        axes = figure.subplots()
        for k, (_, share, low, high, met) in enumerate(rows):
            axes.plot([low, high], [k, k], color=SOFT, linewidth=1.2)
            axes.plot([share], [k], "o", color=BLUE if met else ORANGE)
        axes.set_yticks(range(len(rows)), [row[0] for row in rows], fontsize=5)
        axes.invert_yaxis()
        axes.set_xlim(-0.02, 1.02)
        axes.set_xlabel("rate with 95 % bounds")

    height = 1.0 + 0.14 * max(len(rows), 1)
    return _as_file(draw("blind-rates", "Rates with their bounds.", paint, height_in=height))


def _as_file(svg: str) -> str:
    """Give an inline picture the name space that a file of its own needs."""
    text = str(svg)
    if 'xmlns="' not in text[:1000]:
        text = text.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)
    if "xmlns:xlink=" not in text[:1000] and "xlink:" in text:
        text = text.replace("<svg", '<svg xmlns:xlink="http://www.w3.org/1999/xlink"', 1)
    return text
