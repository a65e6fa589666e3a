"""Load tests of a drive: speed and torque for each control code, from workbooks and text files."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import mapped_columns, search_sheet, sheets_of, source_name
from pipeline.ingest.blank_form import is_blank_form, no_data_yet
from pipeline.ingest.cells import is_number
from pipeline.ingest.columns_stated import told_of_columns
from pipeline.ingest.formulas import with_one_cause
from pipeline.ingest.headers import Wanted, choose_sheets, names_seen
from pipeline.ingest.load_test_codes import codes_of_blocks
from pipeline.ingest.load_test_repeats import LoadTestSheet, SheetReading, mark_repeats
from pipeline.ingest.load_test_table import read_table, summary
from pipeline.ingest.load_test_words import BRANCH_WORDS, REQUIRED, VOCABULARY
from pipeline.ingest.rows import counted
from pipeline.ingest.sheet import Sheet
from pipeline.ingest.usable import with_cause
from pipeline.records.base import Source
from pipeline.records.measurements import LoadTestPoint, LoadTestRecord, SheetRead
from pipeline.vehicle.bench_schema import LoadTestColumns
from pipeline.vehicle.schema import Vehicle

_T = TypeVar("_T")
_KIND = "load_test"


def read_load_tests(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> LoadTestRecord:
    """Read all load-test files of a vehicle.

    A file or sheet that cannot be read becomes a problem of the record; the others are read.

    Parameters
    ----------
    paths : sequence of Path
        The files, xlsx or text.
    vehicle : Vehicle
        Mapping of columns, range of codes, propeller.
    raw_root : Path
        Folder of all vehicles' raw files; sources are named relative to it.

    Returns
    -------
    LoadTestRecord
        Points in rpm, N m, A, V, W with marks, what was read on each sheet, and all problems.
    """
    sheets: list[LoadTestSheet] = []
    problems: list[Problem] = []
    blank: set[str] = set()
    for path in sorted(paths):
        name = source_name(path, raw_root)
        found = sheets_of(path, name)
        if isinstance(found, Problem):
            problems.append(found)
            continue
        if is_blank_form(found):
            problems.append(no_data_yet(name))
            blank.add(name)
            continue
        read, wrong = _read_file(found, path, vehicle)
        sheets += read
        problems += wrong
    sheets, wrong = mark_repeats(sheets)
    problems += wrong
    files = [source_name(path, raw_root) for path in sorted(paths)]
    problems = _with_causes([file for file in files if file not in blank], sheets, problems)
    problems += [*_without_code(sheets), *_warm_up_notes(sheets)]
    if paths:
        folder = Place(source_name(min(paths).parent, raw_root))
        problems += _one_code_only(sheets, folder, vehicle)
    points = tuple(_point(sheet, one) for sheet in sheets for one in sheet.readings)
    return LoadTestRecord(
        points=points,
        sheets=tuple(_sheet_read(sheet) for sheet in sheets),
        problems=tuple(dict.fromkeys(problems)),
    )


def _read_file(
    sheets: Sequence[Sheet], path: Path, vehicle: Vehicle
) -> tuple[list[LoadTestSheet], list[Problem]]:
    mapping = vehicle.columns.load_test
    chosen, problems_found = choose_sheets(sheets, mapping.sheets, _KIND)
    problems = list(problems_found)
    skipped = [sheet for sheet in sheets if sheet not in chosen]
    if skipped and chosen:
        what = f"not read, because vehicle.yaml restricts the sheets: {_names(skipped)}."
        problems.append(Problem("note", Place(sheets[0].file), what))
    read = [_read_sheet(sheet, path, vehicle, mapping) for sheet in chosen]
    used = sum(1 for sheet in read if sheet.readings)
    for sheet in read:
        others = used - (1 if sheet.readings else 0)
        problems += [_beside(problem, others) for problem in sheet.problems]
    problems += _not_understood(chosen, read)
    return read, problems


def _names(sheets: Sequence[Sheet] | Sequence[LoadTestSheet]) -> str:
    return ", ".join(f'"{sheet.name}"' for sheet in sheets)


def _beside(problem: Problem, others: int) -> Problem:
    """Say of a sheet that was left out that the others were read."""
    if problem.severity != "error" or not others:
        return problem
    rest = "The other sheet was read." if others == 1 else f"The other {others} sheets were read."
    return replace(problem, remedy=f"{problem.remedy} {rest}".strip())


def _not_understood(sheets: Sequence[Sheet], read: Sequence[LoadTestSheet]) -> list[Problem]:
    """Say once for a file which sheets hold no load test, and what they hold instead."""
    nothing = [
        (sheet, result)
        for sheet, result in zip(sheets, read, strict=True)
        if not result.readings and not any(p.severity != "note" for p in result.problems)
    ]
    if not nothing:
        return []
    any_read = any(result.readings for result in read)
    reasons = [
        f"{result.summary}" if sheet.name is None else f'"{sheet.name}": {result.summary}'
        for sheet, result in nothing
    ]
    named = any(names_seen(sheet) for sheet in sheets)
    if any_read:
        remedy = "If one of them is a load test, state its headers in vehicle.yaml under columns: "
        remedy += "load_test; if not, nothing needs to be done."
    elif named:
        remedy = (
            "If it is one, state the headers in vehicle.yaml under columns: load_test, or move "
        )
        remedy += "the file out of the folder."
    else:
        remedy = (
            "Put a row of names and units above the numbers, or state the columns in vehicle.yaml:"
            '\n  columns:\n    load_test:\n      shaft_speed: {header: "column A", unit: rpm}\n'
            '      torque: {header: "column B", unit: N m}'
        )
    return [
        Problem(
            "note" if any_read else "error",
            Place(sheets[0].file),
            f"no load test found: {'; '.join(reasons)}.",
            "columns of shaft speed and torque with units.",
            remedy,
        )
    ]


def _wanted(mapping: LoadTestColumns) -> Wanted:
    return Wanted(
        vocabulary=VOCABULARY,
        required=REQUIRED,
        kind=_KIND,
        mapping=mapped_columns(mapping),
        only=mapping.only,
        shared=frozenset({"code"}),
        split_words=BRANCH_WORDS,
    )


def _read_sheet(
    sheet: Sheet, path: Path, vehicle: Vehicle, mapping: LoadTestColumns
) -> LoadTestSheet:
    if not any(cell is not None for cells in sheet.rows for cell in cells):
        return LoadTestSheet(sheet.file, sheet.name, (), (), "empty", sheet.problems)
    sheet, search = search_sheet(sheet, _wanted(mapping))
    problems = [*sheet.problems, *search.problems]
    if not search.blocks:
        return LoadTestSheet(sheet.file, sheet.name, (), (), _instead(sheet), tuple(problems))
    readings: list[SheetReading] = []
    summaries: list[str] = []
    codes = codes_of_blocks(search.blocks, path, vehicle.drive.code_max, problems)
    for block, code in zip(search.blocks, codes, strict=True):
        found, wrong = read_table(block, code, vehicle, mapping)
        problems += wrong
        readings += [SheetReading(reading, code.found_in) for reading in found]
        if found:
            summaries.append(summary(found, code))
    columns = {
        (column.quantity, column.index): column.as_record()
        for block in search.blocks
        for column in block.columns.values()
    }
    told = [told_of_columns(block, mapping) for block in search.blocks]
    return LoadTestSheet(
        sheet.file,
        sheet.name,
        tuple(readings),
        tuple(columns.values()),
        "; ".join(summaries) or "no point",
        tuple(with_one_cause(problems)),
        _once(one.not_used for one in told),
        _once(one.stated_as for one in told),
    )


def _once(parts: Iterable[tuple[_T, ...]]) -> tuple[_T, ...]:
    return tuple(dict.fromkeys(one for part in parts for one in part))


def _instead(sheet: Sheet) -> str:
    """Say what a sheet without a load test holds."""
    names = names_seen(sheet)
    if names:
        return f"no columns of speed and torque among {names}"
    numbers = sum(is_number(cell) for cells in sheet.rows for cell in cells)
    return f"no column names over its {numbers} numbers" if numbers else "text only"


def _with_causes(
    files: Sequence[str], sheets: Sequence[LoadTestSheet], problems: Sequence[Problem]
) -> list[Problem]:
    """Return the problems, with an error among those of every file that gives no point to fit."""
    causes: list[Problem] = []
    for file in files:
        own = [problem for problem in problems if problem.place.file == file]
        readings = [one.reading for sheet in sheets if sheet.file == file for one in sheet.readings]
        causes += with_cause(own, file, [reading.marks for reading in readings], "load-test")
    return [*(problem for problem in problems if problem.place.file not in files), *causes]


def _one_code_only(
    sheets: Sequence[LoadTestSheet], folder: Place, vehicle: Vehicle
) -> list[Problem]:
    """Say that a family over codes does not follow from one of them."""
    codes = {
        one.reading.code
        for sheet in sheets
        for one in sheet.readings
        if one.reading.code is not None and not one.reading.marks
    }
    if len({abs(code) for code in codes}) != 1:
        return []
    return [
        Problem(
            "error",
            folder,
            f"there is one control code only ({', '.join(f'{code:g}' for code in sorted(codes))}): "
            "the family M(n, N) over codes cannot be fitted.",
            f"several codes between 0 and {vehicle.drive.code_max}.",
            "Add the records of other codes.",
        )
    ]


def _without_code(sheets: Sequence[LoadTestSheet]) -> list[Problem]:
    by_file: dict[str, list[LoadTestSheet]] = {}
    for sheet in sheets:
        if any(one.reading.code is None for one in sheet.readings):
            by_file.setdefault(sheet.file, []).append(sheet)
    return [
        Problem(
            "warning",
            Place(file),
            f"there is no control code{_on(codeless)}: neither a code column, nor a code in a "
            "heading, the sheet's name or the file's name. Speed and torque were read, but the "
            "drive's family M(n, N) cannot be fitted from them.",
            'a column "code", or "Code 90" as heading or sheet name.',
            "Name it in the file, or state the column in vehicle.yaml under columns: load_test: "
            "code.",
        )
        for file, codeless in by_file.items()
    ]


def _warm_up_notes(sheets: Sequence[LoadTestSheet]) -> list[Problem]:
    """Say once for a file how many rows are warm-up."""
    counts: dict[str, list[int]] = {}
    for sheet in sheets:
        rows = sum("warm-up" in one.reading.marks for one in sheet.readings)
        if rows:
            counts.setdefault(sheet.file, []).append(rows)
    return [
        Problem(
            "note",
            Place(file),
            f"warm-up: {counted(sum(rows), 'row')} on {counted(len(rows), 'sheet')}; kept but not "
            "fitted.",
        )
        for file, rows in counts.items()
    ]


def _on(sheets: Sequence[LoadTestSheet]) -> str:
    if sheets[0].name is None:
        return ""
    return f" on sheet{'s' if len(sheets) > 1 else ''} {_names(sheets)}"


def _point(sheet: LoadTestSheet, one: SheetReading) -> LoadTestPoint:
    reading = one.reading
    return LoadTestPoint(
        source=Source(file=sheet.file, sheet=sheet.name, row=reading.row),
        code=reading.code,
        shaft_speed_rpm=reading.shaft_speed_rpm,
        torque_nm=reading.torque_nm,
        current_a=reading.values.get("current"),
        voltage_v=reading.values.get("voltage"),
        input_power_w=reading.values.get("input_power"),
        output_power_w=reading.values.get("output_power"),
        branch=reading.branch or "loading",
        marks=reading.marks,
    )


def _sheet_read(sheet: LoadTestSheet) -> SheetRead:
    return SheetRead(
        file=sheet.file,
        sheet=sheet.name,
        rows=len(sheet.readings),
        columns=sheet.columns,
        summary=sheet.summary,
        not_used=sheet.not_used,
        stated_as=sheet.stated_as,
    )
