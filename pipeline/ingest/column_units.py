"""The unit of a column: in its name, in a row under it, stated in vehicle.yaml, or assumed."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath

from pipeline.errors import Place, Problem
from pipeline.ingest.blocks import BlockColumn, UnitFrom
from pipeline.ingest.cells import Sheet, column_letter, shorten, unit_behind
from pipeline.ingest.column_data import is_unclear, meaning_of_signs, without_thousands
from pipeline.ingest.header_rows import Match, Wanted, is_mapped, letter_of
from pipeline.ingest.unit_text import UnitTextError, factor, known_units, quantities_of
from pipeline.ingest.vocabulary import (
    Words,
    factor_in_name,
    read_unit_cell,
    unit_fits,
    unit_in_text,
    unit_told_by_name,
)
from pipeline.vehicle.bench_schema import Column, Columns


@dataclass(frozen=True)
class HeadRows:
    """Where a table is: first row free for its head, row of the names, first and last of data."""

    free_from: int
    names: int
    data: int
    last: int


@dataclass(frozen=True)
class _Written:
    """A unit as somebody wrote it, for a column or for all of a table."""

    unit: str
    unit_from: UnitFrom
    row: int | None
    by: str
    """What states it, in words."""
    is_format: bool = False
    """Whether the cells are shown with it: then none but a unit of the quantity will do."""


class _RefusedError(Exception):
    """Why a column cannot be read, what was expected, what to do, and the row if it is another."""

    def __init__(self, why: str, expected: str, remedy: str, row: int | None = None) -> None:
        super().__init__(why)
        self.expected, self.remedy, self.row = expected, remedy, row


def read_columns(
    sheet: Sheet,
    wanted: Wanted,
    rows: HeadRows,
    group: Mapping[str, Match],
    problems: list[Problem],
) -> dict[str, BlockColumn]:
    """Find the units of a table's columns; a problem is told for each that was left out.

    `group` has the column of each quantity.
    """
    columns: dict[str, BlockColumn] = {}
    for quantity, match in group.items():
        words, stated = wanted.vocabulary[quantity], wanted.mapping.get(quantity)
        column = BlockColumn(
            quantity,
            match.index,
            header=" ".join(match.text.split()),
            sign=1 if stated is None else stated.sign,
            plus=() if stated is None else _indices(sheet, rows.names, stated.plus),
            group=" ".join(
                dict.fromkeys(
                    cell
                    for at in range(max(rows.free_from, rows.names - 3), rows.names)
                    if isinstance(cell := sheet.cell(at, match.index), str)
                )
            ),
        )
        try:
            _check_factor(column, words, stated)
            written = _units_written(sheet, words, match, rows, stated)
            read = _with_signs(sheet, _with_unit(column, words, match, written), rows, problems)
            named = unit_told_by_name(match.header, words)
            by_name = [_Written(named, "assumed", None, "its name")] if named else []
            elsewhere = _units_in_titles(sheet, words, rows)
            _check_contradiction(read, words, [*written, *by_name, *elsewhere])
            scale = 1.0 if stated is None else stated.scale / (stated.pole_pairs or 1)
            columns[quantity] = replace(read, factor=read.factor * scale)
        except (_RefusedError, UnitTextError) as error:
            units = known_units(words.unit_kind)[:1] if words.unit_kind else ()
            shown = "".join(f", e.g. [{one}]" for one in units)
            expected = f"the unit in the header{shown}, or in the row under it."
            of_unit = _RefusedError(str(error), expected, "Write it there")
            refused = error if isinstance(error, _RefusedError) else of_unit
            row = rows.names if refused.row is None else refused.row
            others = group.keys() - {quantity}
            needed = any(quantity in one and others.isdisjoint(one) for one in wanted.required)
            place = sheet.place(row, column.letter)
            problems.append(_problem(column, place, refused, wanted.kind, needed=needed))
    return columns


def _with_signs(
    sheet: Sheet, column: BlockColumn, rows: HeadRows, problems: list[Problem]
) -> BlockColumn:
    """Tell whether the signs in the numbers part thousands, and say so."""
    span = (rows.data, rows.last)
    meaning = meaning_of_signs(sheet, column.index, span, column.quantity, column.factor)
    if meaning == "thousands":
        cells = sheet.column(column.index, span)
        at, cell = next((at, one) for at, one in enumerate(cells) if is_unclear(one))
        what = (
            f'{column.quantity.replace("_", " ")}: "{cell}" is read as {without_thousands(cell)}; '
            "the other numbers say that the sign parts thousands."
        )
        problems.append(sheet.place(rows.data + at, column.letter).note(what))
    return replace(column, signs_mean=meaning)


def _indices(sheet: Sheet, row: int, headers: Sequence[str]) -> tuple[int, ...]:
    """Return the columns whose names, or letters, are these."""
    stated = [Column(header=one) for one in headers]
    letters = {letter_of(one) for one in stated}
    return tuple(
        index
        for index in range(sheet.width if stated else 0)
        for cell in [sheet.cell(row, index)]
        if column_letter(index) in letters
        or (isinstance(cell, str) and any(is_mapped(one, cell) for one in stated))
    )


def _check_contradiction(column: BlockColumn, words: Words, written: Iterable[_Written]) -> None:
    """Refuse a column for which something else states another unit than the one that is read."""
    kind = words.unit_kind
    if kind is None or column.unit_from == "mapping":
        return
    for one in written:
        fits = unit_fits(one.unit, words)
        if (fits and factor(one.unit, kind) != column.factor) or (one.is_format and not fits):
            why = f"it states {column.unit}, {one.by} {one.unit}"
            raise _RefusedError(why, "one unit.", "Correct what is wrong of both", one.row)


def _check_factor(column: BlockColumn, words: Words, stated: Column | None) -> None:
    """Refuse a column whose name holds a factor, unless it is known what it means."""
    quantity = column.quantity
    told = stated is not None and (stated.unit is not None or quantity == "torque_coefficient")
    if told or quantity == "torque_coefficient_x10" or words.unit_kind == "ratio":
        return
    if times := factor_in_name(column.header, quantity):
        raise _RefusedError(
            f'"{times}" in the name may multiply the numbers or divide them',
            "numbers in the unit that the name states.",
            "Write the numbers without a factor",
        )


def _with_unit(
    column: BlockColumn, words: Words, match: Match, written: Sequence[_Written]
) -> BlockColumn:
    """Return the column with its unit; raises `UnitTextError` where it is missing or wrong."""
    kind, found = words.unit_kind, written[0] if written else None
    if found is not None and (kind is not None or "ratio" in quantities_of(found.unit)):
        # A code in per cent stays a number of per cent: the reader knows the full scale.
        is_code = kind is None and column.quantity == "code"
        worth = 1.0 if is_code else factor(found.unit, kind or "ratio")
        return replace(
            column, unit=found.unit, unit_from=found.unit_from, unit_row=found.row, factor=worth
        )
    if kind is None:
        return column
    odd = match.header.odd_unit
    if odd is not None and words.default_unit is None:
        factor(odd, kind)  # says why it is none
    told = unit_told_by_name(match.header, words) or words.default_unit
    if told is not None:
        return replace(column, unit=told, unit_from="assumed", factor=factor(told, kind))
    raise UnitTextError(f"no unit is stated; known: {', '.join(known_units(kind))}")


def _units_written(
    sheet: Sheet, words: Words, match: Match, rows: HeadRows, stated: Column | None
) -> list[_Written]:
    """Return every unit that is written for a column, what goes before the others first.

    That of vehicle.yaml stands alone. What stands at a column and is no unit of the quantity comes
    last: a second row of names may have letters that are other units.
    """
    if stated is not None and stated.unit is not None:
        return [_Written(stated.unit, "mapping", None, "vehicle.yaml")]
    found: list[_Written] = []
    if match.header.unit is not None:
        found.append(_Written(match.header.unit, "header", None, "it"))
    wrong: list[_Written] = []
    for at in [*range(rows.names + 1, rows.data), rows.names - 1]:
        cell = sheet.cell(at, match.index)
        unit = read_unit_cell(cell) if isinstance(cell, str) else None
        by = "the row under it" if at > rows.names else "the row above it"
        if unit is not None and unit_fits(unit, words):
            found.append(_Written(unit, "unit row", at, by))
        elif isinstance(cell, str) and at > rows.names and (unit or _is_unit_row(sheet, at)):
            wrong.append(_Written(unit or cell.strip(), "unit row", at, by))
    shown = sheet.units_shown(match.index, (rows.data, rows.last)).items()
    by = "the number format of its cells"
    found += [_Written(unit, "unit row", at, by, is_format=True) for unit, at in shown]
    if not found and not wrong:
        cells = [sheet.cell(at, match.index) for at in range(rows.data, rows.last + 1)]
        behind = dict.fromkeys(unit_behind(cell) for cell in cells if cell is not None)
        units = [unit for unit in behind if unit and (unit == "%" or unit_fits(unit, words))]
        if None not in behind and len(units) == len(behind):
            found += [_Written(one, "unit row", rows.data, "its cells") for one in units]
    return found + wrong


def _units_in_titles(sheet: Sheet, words: Words, rows: HeadRows) -> Iterator[_Written]:
    """Yield the units that a title, a remark over the table or the name of the sheet states."""
    for at in range(rows.free_from, rows.names):
        texts = {cell for cell in sheet.cells(at) if cell is not None}
        text = texts.pop() if len(texts) == 1 else None
        if isinstance(text, str) and (unit := unit_in_text(text, words)):
            yield _Written(unit, "unit row", at, f'"{shorten(text)}"')
    stem = PurePath(sheet.file).stem.replace("_", " ")
    for text, by in ((sheet.name or "", "the name of the sheet"), (stem, "the name of the file")):
        if unit := unit_in_text(text, words):
            yield _Written(unit, "unit row", None, by)


def _is_unit_row(sheet: Sheet, row: int) -> bool:
    texts = [cell for cell in sheet.cells(row) if isinstance(cell, str)]
    units = sum(read_unit_cell(text) is not None for text in texts)
    return units >= max(1, len(texts) // 2)


def _problem(
    column: BlockColumn, place: Place, refused: _RefusedError, kind: str, *, needed: bool
) -> Problem:
    name, header, remedy = column.quantity.replace("_", " "), shorten(column.header), refused.remedy
    left_out = "the table was left out" if needed else "the column was left out"
    if column.quantity in type(getattr(Columns(), kind)).model_fields:
        remedy = (
            f"{remedy}, or state it in vehicle.yaml:\n  columns:\n    {kind}:\n"
            f'      {column.quantity}: {{header: "{header}", unit: ...}}'
        )
    else:
        remedy = f"{remedy}."
    what = f'{name} "{header}": {refused}. So {left_out}.'
    return Problem("error" if needed else "warning", place, what, refused.expected, remedy)
