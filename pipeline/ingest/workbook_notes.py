"""What a workbook does not show: formulas stored without results, hidden sheets and rows."""

import re
from collections.abc import Sequence
from dataclasses import replace

from pipeline.errors import Place, Problem
from pipeline.ingest.archive import SheetScan
from pipeline.ingest.cells import column_letter
from pipeline.ingest.rows import listed

_NO_VALUE = "hold no stored value"
_NO_NUMBER = "holds no number"
_MOST_NAMED = 8


def formula_problems(scan: SheetScan, where: Place) -> tuple[Problem, ...]:
    """Warn of a sheet's formula cells without a value; they count as empty."""
    cells = scan.formulas_without_value
    if not cells:
        return ()
    names = [f"{column_letter(column)}{row}" for row, column in cells]
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    problem = Problem(
        "warning",
        Place(where.file, where.sheet, cells[0][0]),
        f"{len(cells)} formula cell(s) {_NO_VALUE}: {', '.join(names[:_MOST_NAMED])}{more}. They "
        "count as empty.",
        "formulas with their results, as a spreadsheet program saves them.",
        "Open the workbook in a spreadsheet program, let it calculate, and save it.",
    )
    return (problem,)


def with_one_cause(problems: Sequence[Problem]) -> list[Problem]:
    """Say once that a table was left out where formulas are why its column is empty.

    Of the problems of one file the error about the column goes, the warning about its formulas
    becomes the error.
    """
    kept = list(problems)
    for error in problems:
        column = error.place.column
        if error.severity != "error" or column is None or _NO_NUMBER not in error.what:
            continue
        for index, warning in enumerate(kept):
            if (warning.place.file, warning.place.sheet) == (
                error.place.file,
                error.place.sheet,
            ) and re.search(rf"{_NO_VALUE}:.*\b{column}[0-9]+\b", warning.what):
                what = f"{warning.what} So the table was left out."
                kept[index] = replace(warning, severity="error", what=what)
                kept.remove(error)
                break
    return kept


def hidden_problems(scan: SheetScan | None, where: Place, *, is_hidden: bool) -> list[Problem]:
    """Say that a sheet (`is_hidden`), or rows of it, are hidden and were read all the same."""
    if scan is None or not scan.cells:
        return []
    notes: list[Problem] = []
    if is_hidden:
        remedy = "Delete the sheet if it is not meant, or name the right ones in vehicle.yaml."
        notes.append(Problem("note", where, "the sheet is hidden and was read.", "", remedy))
    if scan.hidden_rows:
        rows = scan.hidden_rows
        place = Place(where.file, where.sheet, rows[0])
        what = f"hidden in the workbook and read all the same: {listed(rows)}."
        remedy = 'Mark rows with "#" in column A to leave them out.'
        notes.append(Problem("note", place, what, "", remedy))
    return notes
