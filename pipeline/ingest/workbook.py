"""Read a raw file into plain sheets, whatever it is, or say in one message why not."""

import re
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.errors import InputError, Place, reason
from pipeline.ingest.archive import (
    Archive,
    SheetScan,
    hidden_problems,
    longest_shared_text,
    scan_sheet,
    units_of_styles,
    unpack,
)
from pipeline.ingest.cells import Cell, Limits, Row, Sheet, column_letter
from pipeline.ingest.log_files import is_log_anywhere, log_among_bench_files
from pipeline.ingest.reading_process import opening
from pipeline.ingest.text_table import read_text_table

if TYPE_CHECKING:
    from python_calamine import CalamineSheet, CalamineWorkbook

__all__ = ["Cell", "Limits", "Row", "Sheet", "read_sheets"]

WORKBOOK_SUFFIXES = frozenset({".xlsx", ".xlsm"})
TEXT_SUFFIXES = frozenset({".csv", ".tsv", ".txt", ".dat"})
_LIMITS = Limits()
_COMPOUND_FILE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
#: Control characters that no text has, of whatever encoding of one byte or UTF-8.
_NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
_SAVE_AS = "Open it in a spreadsheet program and save it as .xlsx."


def read_sheets(path: Path, shown_as: str, limits: Limits = _LIMITS) -> tuple[Sheet, ...]:
    """Read every sheet of a workbook, or the one table of a text file.

    Hidden sheets, rows and columns are read too. What the file is is told by its content, not by
    its name.

    `shown_as` is its name in messages and sources, `limits` what it may cost. Raises `InputError`
    where it cannot be read.
    """
    place = Place(shown_as)
    if is_log_anywhere(path.name):
        raise InputError(log_among_bench_files(shown_as))
    data = _load(path, place, limits)
    if data.startswith(_COMPOUND_FILE):
        raise _compound_file(data, place)
    if data.startswith((b"PK\x03\x04", b"PK\x05\x06", b"PK\x07\x08")):
        return _read_workbook(data, place, limits)
    suffix = path.suffix.lower()
    if suffix in TEXT_SUFFIXES:
        return (read_text_table(data, place, limits),)
    if suffix in WORKBOOK_SUFFIXES:
        raise InputError.at(
            place,
            f"this is no workbook although its name ends in {suffix}: {_guess(data)}.",
            expected="an .xlsx workbook.",
            remedy=f"{_SAVE_AS} A CSV file is read when its name ends in .csv.",
        )
    raise InputError.at(
        place,
        f'files ending in "{suffix}" are not read: {_guess(data)}.',
        expected=f"{', '.join(sorted(WORKBOOK_SUFFIXES | TEXT_SUFFIXES))}.",
        remedy="Save it in one of these formats.",
    )


def _load(path: Path, place: Place, limits: Limits) -> bytes:
    data, what = b"", ""
    expected, remedy = "a workbook or a table.", "Copy it from the bench again."
    try:
        if path.is_file():
            with path.open("rb") as stream:
                data = stream.read(limits.max_bytes + 1)
            if not data.strip(b"\x00 \t\r\n\xef\xbb\xbf"):
                what = "the file is empty."
        else:
            what = "this is not a file." if path.exists() else "there is no such file."
            expected, remedy = "", "Check the name."
    except OSError as error:
        what = f"the file cannot be read: {error.strerror or type(error).__name__}."
        expected = "a file that you may read."
        remedy = "Change its permissions, or close the program that holds it."
    if len(data) > limits.max_bytes:
        what = f"the file is larger than {limits.max_bytes / 1e6:.0f} MB."
        expected = "a bench record, which is far smaller."
        remedy = "Export the table alone, or in parts."
    if what:
        raise InputError.at(place, what, expected=expected, remedy=remedy)
    return data


def _compound_file(data: bytes, place: Place) -> InputError:
    what = "this is an old Excel file (.xls, or another old Office format), whatever its name says."
    expected, remedy = "an .xlsx workbook.", _SAVE_AS
    # Names in a compound file's directory are UTF-16; an encrypted xlsx is one with this stream.
    if "EncryptedPackage".encode("utf-16-le") in data:
        what = "the workbook is encrypted (it asks for a password)."
        expected = "a workbook without a password."
        remedy = "Save it without a password and copy it here again."
    return InputError.at(place, what, expected=expected, remedy=remedy)


def _guess(data: bytes) -> str:
    start = data[:200].lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if start.startswith((b"<!doctype html", b"<html", b"<table", b"<head", b"<body", b"<meta")):
        return "it is an HTML page"
    if start.startswith(b"<"):
        return "it is XML"
    if start.startswith(b"%pdf"):
        return "it is a PDF"
    if not _NO_TEXT.search(data[:4000]):
        return "it looks like plain text"
    return "its content is of another kind"


def _read_workbook(data: bytes, place: Place, limits: Limits) -> tuple[Sheet, ...]:
    from python_calamine import SheetTypeEnum, SheetVisibleEnum

    archive = unpack(data, place, limits)
    _require_workbook(archive, place)
    scans = _scan(archive, place, limits)
    workbook = _open(data, place)
    worksheet = SheetTypeEnum.WorkSheet
    shown = {meta.name: meta.visible for meta in workbook.sheets_metadata if meta.typ == worksheet}
    names = list(shown)
    if len(names) > limits.max_sheets:
        raise InputError.at(
            place,
            f"the workbook has {len(names)} sheets.",
            expected=f"at most {limits.max_sheets}.",
            remedy="Split it.",
        )
    parts = _parts_of_sheets(archive)
    merged = _Merged(limits.max_cells)
    sheets: list[Sheet] = []
    for name in names:
        scan = scans.get(parts.get(name, ""))
        sheet = _read_sheet(workbook, name, place, scan, merged)
        is_hidden = shown[name] != SheetVisibleEnum.Visible
        notes = hidden_problems(scan, sheet.place(), is_hidden=is_hidden)
        sheets.append(replace(sheet, problems=(*sheet.problems, *notes)))
    return tuple(sheets)


def _require_workbook(archive: Archive, place: Place) -> None:
    if "xl/workbook.xml" in archive.names:
        return
    kind = "a zip file that holds no workbook"
    if "xl/workbook.bin" in archive.names:
        kind = "a binary workbook (.xlsb)"
    elif "mimetype" in archive.names and "content.xml" in archive.names:
        kind = "an OpenDocument file (.ods)"
    elif any(name.startswith("word/") for name in archive.names):
        kind = "a Word document"
    raise InputError.at(place, f"this is {kind}.", expected="an .xlsx workbook.", remedy=_SAVE_AS)


def _scan(archive: Archive, place: Place, limits: Limits) -> dict[str, SheetScan]:
    """Scan every worksheet; refuse those whose dense table would not fit into memory."""
    scans: dict[str, SheetScan] = {}
    area = 0
    units = units_of_styles(archive.members.get("xl/styles.xml", b""))
    for name, xml in archive.members.items():
        if b"sheetData" not in xml:
            continue
        scan = scans[name] = scan_sheet(xml, units)
        area += scan.rows * scan.columns
        large = scan.rows > limits.max_rows or scan.columns > limits.max_columns
        if large or area > limits.max_cells:
            raise InputError.at(
                place,
                f'a sheet (part "{name}") reaches to row {scan.rows}, column '
                f"{column_letter(max(scan.columns - 1, 0))}.",
                expected=f"at most {limits.max_rows} rows, {limits.max_columns} columns and "
                f"{limits.max_cells} cells in all.",
                remedy="Delete stray cells far from the table; even a blank one with a format "
                "counts.",
            )
    text_cells = sum(scan.text_cells for scan in scans.values())
    longest = longest_shared_text(archive.members.get("xl/sharedstrings.xml", b""))
    if text_cells * longest > limits.max_text_bytes and longest > 2000:
        raise InputError.at(
            place,
            f"a text of {longest} characters and {text_cells} text cells: the text would not fit "
            "into memory.",
            expected="a table of numbers.",
            remedy="Export the table alone.",
        )
    return scans


def _parts_of_sheets(archive: Archive) -> dict[str, str]:
    """Return sheet name -> member name, from the workbook's relations."""
    from xml.etree import ElementTree as ET

    relations: dict[str, str] = {}
    try:  # declarations of entities were refused by `unpack`
        for relation in ET.fromstring(archive.members.get("xl/_rels/workbook.xml.rels", b"<r/>")):  # noqa: S314
            target = relation.get("Target", "")
            target = target.lstrip("/") if target.startswith("/") else f"xl/{target}"
            relations[relation.get("Id", "")] = target.lower()
        found: dict[str, str] = {}
        for element in ET.fromstring(archive.members["xl/workbook.xml"]).iter():  # noqa: S314
            if element.tag.rsplit("}", 1)[-1] != "sheet":
                continue
            for key, value in element.attrib.items():
                if key.endswith("}id"):
                    found[element.get("name", "")] = relations.get(value, "")
    except (ET.ParseError, KeyError):
        return {}  # the reader will say what is wrong with it
    return found


def _open(data: bytes, place: Place) -> "CalamineWorkbook":
    from python_calamine import CalamineWorkbook

    opening(place.file)
    try:
        return CalamineWorkbook.from_object(BytesIO(data))
    except BaseException as error:
        if not _is_reader_failure(error):
            raise
        raise InputError.at(
            place,
            f"the workbook is damaged and cannot be opened ({reason(error)}).",
            expected="a workbook as a spreadsheet program saves it.",
            remedy="Save it again in a spreadsheet program.",
        ) from error


def _is_reader_failure(error: BaseException) -> bool:
    # A panic of the compiled reader derives from BaseException alone.
    return isinstance(error, Exception) or type(error).__name__ == "PanicException"


@dataclass
class _Merged:
    """How many cells the merged ranges of a file may cover in all, and how many they do."""

    most: int
    cells: int = 0


def _read_sheet(
    workbook: "CalamineWorkbook", name: str, place: Place, scan: SheetScan | None, merged: _Merged
) -> Sheet:
    where = Place(place.file, name)
    try:
        sheet = workbook.get_sheet_by_name(name)
        table = sheet.to_python(skip_empty_area=False)
    except BaseException as error:
        if not _is_reader_failure(error):
            raise
        problem = where.error(
            f"the sheet is damaged and cannot be read ({reason(error)}).",
            "a sheet as a spreadsheet program saves it.",
            "Save the workbook again in a spreadsheet program. The other sheets were read.",
        )
        return Sheet(place.file, name, (), 1, (problem,))
    rows = [[_cell(value) for value in row] for row in table]
    # The reader leaves error values out; their text says what is wrong with the cell.
    for row, column, text in scan.errors if scan is not None else ():
        if row <= len(rows) and column < len(rows[row - 1]):
            rows[row - 1][column] = text
    filled = _fill_merged(rows, sheet, merged, where)
    cells, known = tuple(tuple(row) for row in rows), scan or SheetScan()
    formulas = frozenset(known.formulas_without_value)
    return Sheet(place.file, name, cells, 1, (), frozenset(filled), known.units, formulas)


def _cell(value: object) -> Cell:
    if isinstance(value, bool):
        return value
    if isinstance(value, (int, float)):
        return float(value)
    text = str(value).strip()  # also dates and times, in ISO form
    return text or None


def _fill_merged(
    rows: list[list[Cell]], sheet: "CalamineSheet", merged: _Merged, where: Place
) -> set[tuple[int, int]]:
    """Copy the value of merged cells into all of them, within the table."""
    filled: set[tuple[int, int]] = set()
    for (top, left), (bottom, right) in sheet.merged_cell_ranges or []:
        if top >= len(rows) or left >= len(rows[top]) or rows[top][left] is None:
            continue
        height, width = min(bottom + 1, len(rows)) - top, min(right + 1, len(rows[top])) - left
        merged.cells += max(height, 0) * max(width, 0)
        if merged.cells > merged.most:  # more than there are cells: some are covered many times
            raise InputError.at(
                where,
                f"merged ranges lie over each other: together they cover more than {merged.most} "
                "cells.",
                expected="merged ranges that do not overlap, as a spreadsheet program makes them.",
                remedy="Unmerge the cells in a spreadsheet program and save the workbook again.",
            )
        for row in range(top, top + height):
            for column in range(left, min(right + 1, len(rows[row]))):
                if (row, column) != (top, left):
                    rows[row][column] = rows[top][left]
                    filled.add((row + 1, column))
    return filled
