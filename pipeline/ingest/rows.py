"""Words of messages about rows; tables and files that are left out, each with one error for it."""

from collections.abc import Sequence
from dataclasses import replace

from pipeline.errors import Place, Problem
from pipeline.records.measurements import IN_A_FLOW

COPY = "duplicate"


def counted(number: int, noun: str) -> str:
    """Write a number of things.

    >>> counted(1, "point"), counted(0, "row"), counted(12, "code")
    ('1 point', '0 rows', '12 codes')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def listed(rows: Sequence[int], most: int = 8) -> str:
    """Write row numbers, runs joined, cut when there are many.

    >>> listed([4]), listed([4, 5, 6, 9])
    ('row 4', 'rows 4-6, 9')
    >>> listed(range(1, 40, 2), most=3)
    'rows 1, 3, 5 and 17 more'
    """
    runs: list[tuple[int, int]] = []
    for row in rows:
        if runs and row == runs[-1][1] + 1:
            runs[-1] = (runs[-1][0], row)
        else:
            runs.append((row, row))
    shown = [str(low) if low == high else f"{low}-{high}" for low, high in runs[:most]]
    hidden = sum(high - low + 1 for low, high in runs[most:])
    text = ", ".join(shown) + (f" and {hidden} more" if hidden else "")
    return f"{'row' if len(rows) == 1 else 'rows'} {text}"


def with_cause(
    problems: list[Problem], file: Place, marks: Sequence[tuple[str, ...]], kind: str
) -> list[Problem]:
    """Return the problems of one file, with an error among them if no point of it can be fitted.

    The first warning is taken for the cause and becomes the one error; without a warning the marks
    of the points that were read are the cause. A file that repeats another one is no error, nor one
    whose thrust was all measured in a flow. `kind` is that of the points, e.g. "load_test".
    """
    serve = (not own or own == (IN_A_FLOW,) or own[0] == COPY for own in marks)
    if any(serve) or any(problem.severity == "error" for problem in problems):
        return problems
    rest = [problem for problem in problems if problem.severity != "warning"]
    for cause in problems:
        if cause.severity == "warning":
            said = f"{cause.what} No point of the file is left."
            return [replace(cause, severity="error", what=said), *rest]
    what = kind.replace("_", "-")
    reasons = ", ".join(dict.fromkeys(mark for own in marks for mark in own))
    error = file.error(
        f"no usable {what} point is left: {counted(len(marks), 'point')} read ({reasons})."
        if marks
        else f"no {what} point was read.",
        "rows that can be fitted.",
        "Correct the file, or move it out of the folder.",
    )
    return [error, *rest]
