"""Tables that are left out, and a file that gives no point to fit: one error that says why."""

from collections.abc import Sequence
from dataclasses import replace

from pipeline.errors import Place, Problem
from pipeline.ingest.rows import counted

#: How the marks of points begin that only repeat what is read elsewhere.
_COPIES = ("duplicate", "also on sheet")


def is_refused(problems: Sequence[Problem]) -> bool:
    """Tell whether one of the problems of a table or file leaves it out."""
    return any(problem.severity == "error" for problem in problems)


def with_cause(
    problems: Sequence[Problem], file: str, marks: Sequence[tuple[str, ...]], what: str
) -> list[Problem]:
    """Return the problems of one file, with an error among them if no point of it can be fitted.

    The first warning is taken for the cause and becomes the one error; without a warning the marks
    of the points that were read are the cause. A file that repeats another one is no error. `what`
    is what the points are of, e.g. "load-test".
    """
    if any(not own or own[0].startswith(_COPIES) for own in marks):
        return list(problems)
    if is_refused(problems):
        return list(problems)
    rest = [problem for problem in problems if problem.severity != "warning"]
    warnings = [problem for problem in problems if problem.severity == "warning"]
    if warnings:
        said = f"{warnings[0].what} No point of the file is left."
        return [replace(warnings[0], severity="error", what=said), *rest]
    reasons = ", ".join(dict.fromkeys(mark for own in marks for mark in own))
    error = Problem(
        "error",
        Place(file),
        f"no usable {what} point is left: {counted(len(marks), 'point')} read ({reasons})."
        if marks
        else f"no {what} point was read.",
        "rows that can be fitted.",
        "Correct the file, or move it out of the folder.",
    )
    return [error, *rest]
