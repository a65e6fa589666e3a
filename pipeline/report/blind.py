"""Pictures of a blind check: which truth got which answer, and rates with their bounds."""

from collections.abc import Sequence

import numpy as np

from pipeline.report.plotting import BLUE, ORANGE, SOFT, WIDTH, Canvas, Frame, Scale


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
    wide = (WIDTH - left - 4.0) / max(len(answers), 1)
    bottom = top + cell * len(truths)
    canvas = Canvas(bottom + 16.0 + 3.2 * max(map(len, answers)))
    for i, name in enumerate(truths):
        level = top + cell * (i + 0.7)
        canvas.text(left - 3, level, name, "end", 5.5)
        for j in np.flatnonzero(table[i]).tolist():
            x, y = left + wide * j, top + cell * i
            canvas.area(
                f"M{x:.1f} {y:.1f}h{wide:.1f}v{cell}h{-wide:.1f}", BLUE, float(shares[i, j])
            )
            canvas.text(x + wide / 2, level, f"{table[i, j]:.0f}", "middle", 5.0)
    for j, name in enumerate(answers):
        canvas.text(left + wide * (j + 0.7), bottom + 4, name, "end", 5.5, -90.0)
    canvas.line(f"M{left:g} {top:g}V{bottom:g}H{WIDTH - 4:g}", SOFT)
    canvas.text((left + WIDTH) / 2, canvas.height - 4, "answer", "middle")
    canvas.text(9, (top + bottom) / 2, "truth", "middle", turned=-90.0)
    return canvas.finish("Which answer each truth got.")


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
    canvas = Canvas(38.0 + 10.0 * max(len(rows), 1))
    left = 12.0 + 3.0 * max((len(row[0]) for row in rows), default=0)
    scale = Scale(-0.02, 1.02, min(left, 0.6 * WIDTH), WIDTH - 8.0)
    frame = Frame(canvas, scale, Scale(0.0, 1.0, canvas.height - 30.0, 4.0))
    for k, (name, share, low, high, met) in enumerate(rows):
        level = 10.0 + 10.0 * k
        a, b = scale.at([low, high])
        frame.inside.line(f"M{a:.1f} {level:g}H{b:.1f}", SOFT, 1.2)
        frame.inside.marks(scale.at([share]), np.array([level]), BLUE if met else ORANGE)
        canvas.text(scale.start - 3, level + 2, name, "end", 5.0)
    frame.close("rate with 95 % bounds", grid=False)
    return canvas.finish("Rates with their bounds.")
