"""Hidden sheets and rows of a workbook: they are read, which a person should know."""

from pipeline.errors import Place, Problem
from pipeline.ingest.archive import SheetScan
from pipeline.ingest.rows import listed


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
