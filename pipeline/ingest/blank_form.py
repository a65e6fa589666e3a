"""A form of ``rig2sea new`` that nobody has filled in yet: nothing is wrong with it."""

from collections.abc import Iterable

from pipeline.errors import Place, Problem
from pipeline.ingest.cells import is_number
from pipeline.ingest.sheet import Sheet
from pipeline.vehicle.forms import FORM_MARK


def is_blank_form(sheets: Iterable[Sheet]) -> bool:
    """Tell whether a file is a form without a single number in it."""
    rows = [row for sheet in sheets for row in sheet.rows]
    # saved as text, the heading may have been parted at its blanks
    marked = any(
        FORM_MARK in " ".join(cell for cell in row if isinstance(cell, str)) for row in rows
    )
    return marked and not any(is_number(cell) for row in rows for cell in row)


def no_data_yet(file: str) -> Problem:
    """Return the note about a blank form."""
    return Problem(
        "note",
        Place(file),
        "no data yet: the form is still blank.",
        remedy="Fill in rows under the units, or delete the file if there is no such test.",
    )
