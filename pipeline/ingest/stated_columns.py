"""What vehicle.yaml states about the columns, rows and sheets of raw files."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from pipeline.errors import Problem
from pipeline.ingest.cells import Sheet, column_index, is_number, is_text, shorten
from pipeline.ingest.header_rows import Match, Wanted, is_mapped, letter_of
from pipeline.ingest.vocabulary import HeaderText, is_other, plain, words_of
from pipeline.vehicle.bench_schema import Column

_CALCULATED = words_of("groups", "not_readings")


def columns_by_letter(
    sheet: Sheet, wanted: Wanted, by_letter: Mapping[str, Column]
) -> list[tuple[int, list[Match]]]:
    """Return the row above the first numbers of the columns that vehicle.yaml states by letter.

    A table needs no names then. Empty where no row has a number in each that is needed.
    """
    matches = [
        Match(quantity, column_index(letter), 0, HeaderText(one.header), one.header)
        for quantity, one in by_letter.items()
        if (letter := letter_of(one)) is not None
    ]
    needed = {name for part in wanted.required for name in part}
    columns = [match.index for match in matches if match.quantity in needed]
    rows = (row for row, _ in sheet.numbered())
    first = next((row for row in rows if all(is_number(sheet.cell(row, i)) for i in columns)), None)
    return [] if first is None else [(first - 1, matches)]


def missing_columns(sheet: Sheet, wanted: Wanted) -> Iterator[Problem]:
    """Say which stated columns are not on a sheet that has names."""
    texts = {
        " ".join(cell.split()): None
        for cells in sheet.rows[:60]
        for cell in cells
        if isinstance(cell, str) and is_text(cell)
    }
    missing = [
        (quantity, column)
        for quantity, column in wanted.mapping.items()
        if letter_of(column) is None and not any(is_mapped(column, text) for text in texts)
    ]
    if not missing or len(texts) < 2:
        return
    names = {plain(text): text for text in texts}

    for quantity, column in missing:
        close = difflib.get_close_matches(plain(column.header), list(names), n=1, cutoff=0.6)
        hint = f' The nearest is "{shorten(names[close[0]])}".' if close else ""
        yield sheet.place().warning(
            f'there is no column "{column.header}", stated in vehicle.yaml as columns: '
            f"{wanted.kind}: {quantity}.{hint}",
            "the header as it stands on the sheet.",
            "Correct the header in vehicle.yaml, or restrict the sheets with "
            f"columns: {wanted.kind}: sheets: [...].",
        )


def rows_wanted(
    sheet: Sheet, wanted: Wanted, row: int, problems: list[Problem]
) -> tuple[tuple[int, str], ...]:
    """Return the columns that choose rows (``only``), as (column index, text)."""
    found: list[tuple[int, str]] = []
    for header, text in wanted.only.items():
        fits = [
            (index, text)
            for index, cell in enumerate(sheet.cells(row))
            if isinstance(cell, str) and is_mapped(Column(header=header), cell)
        ]
        found += fits[:1]
        if not fits:
            problems.append(
                sheet.place(row).error(
                    f'there is no column "{header}", stated in vehicle.yaml as columns: '
                    f"{wanted.kind}: only.",
                    "the header as it stands on the sheet.",
                    "Correct the header in vehicle.yaml.",
                )
            )
    return tuple(found)


def choose_sheets(
    sheets: Sequence[Sheet], names: tuple[str, ...] | None, kind: str
) -> tuple[tuple[Sheet, ...], tuple[Problem, ...]]:
    """Keep the sheets that vehicle.yaml names; a text file has one table without a name.

    `names` is ``columns: <kind>: sheets``; None keeps all that are measured by name. A warning
    where a workbook has none of them.
    """
    if any(sheet.name is None for sheet in sheets):
        return tuple(sheets), ()
    if names is None:
        # of a load test every sheet says what it holds instead
        return (tuple(sheets), ()) if kind == "load_test" else _measured(sheets, kind)
    wanted = {plain(name) for name in names}
    kept = tuple(sheet for sheet in sheets if plain(sheet.name or "") in wanted)
    if kept or not sheets:
        skipped = ", ".join(f'"{sheet.name}"' for sheet in sheets if sheet not in kept)
        what = f"not read, because vehicle.yaml restricts the sheets: {skipped}."
        place = replace(sheets[0].place(), sheet=None) if sheets else None
        return kept, (place.note(what),) if skipped and place else ()
    problem = replace(sheets[0].place(), sheet=None).warning(
        f"none of the sheets stated in vehicle.yaml is here ({', '.join(names)}).",
        f"one of them; the workbook has {', '.join(str(sheet.name) for sheet in sheets)}.",
        f"Correct columns: {kind}: sheets in vehicle.yaml, or move the file.",
    )
    return (), (problem,)


def _measured(sheets: Sequence[Sheet], kind: str) -> tuple[tuple[Sheet, ...], tuple[Problem, ...]]:
    """Leave out sheets that are a fit or a calculation by their names, where others are not."""
    kept = [sheet for sheet in sheets if not is_other(HeaderText(sheet.name or ""), _CALCULATED)]
    if not kept:
        return tuple(sheets), ()
    problems = tuple(
        sheet.place().warning(
            "by its name the sheet is calculated, not measured; it was left out.",
            "measured readings.",
            f"If it is measured, name the sheets in vehicle.yaml under columns: {kind}: sheets.",
        )
        for sheet in sheets
        if sheet not in kept and any(sheet.rows)
    )
    return tuple(kept), problems
