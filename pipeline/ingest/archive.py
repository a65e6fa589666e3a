"""What is inside an xlsx file, looked at with bounded effort before any reader unpacks it.

The sizes that a zip directory states may be false, so every member is unpacked here once, in
pieces, against the limits; a reader that trusts the directory comes after.
"""

import re
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from itertools import pairwise
from types import MappingProxyType

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.cells import Limits, column_index
from pipeline.ingest.rows import listed
from pipeline.ingest.vocabulary import read_unit_cell

_DECLARATION = re.compile(rb"<!\s*(?:DOCTYPE|ENTITY)", re.IGNORECASE)
_HIDDEN_XML = re.compile(rb"<(?:[\w.-]+:)?(?:sheetData|sst|si|row|c)[\s>/]")
_CELL = re.compile(rb"<(?:\w+:)?c(?=[\s>/])")
_ATTRIBUTES = re.compile(rb"[^<>]*")
_REFERENCE = re.compile(rb"(?<![\w:])r\s*=\s*[\"']([A-Za-z]{1,3})([0-9]{1,10})[\"']")
_ANY_REFERENCE = re.compile(rb"(?<![\w:])r\s*=\s*[\"']?\s*([A-Za-z]*)([0-9]*)")
_FAR = 10**9
_ROW = re.compile(rb"<(?:\w+:)?row(?=[\s>/])(?:[^<>]*?\sr\s*=\s*[\"']([0-9]{1,7})[\"'])?")
_HIDDEN = re.compile(rb"\shidden\s*=\s*[\"'](?:1|true)[\"']")
_FORMULA = re.compile(rb"<(?:\w+:)?f(?=[\s>/])")
_VALUE = re.compile(rb"<(?:\w+:)?(?:v|is)(?:\s[^<>]*)?>\s*[^<\s]|<(?:\w+:)?t(?:\s[^<>]*)?>[^<]")
_TEXT_CELL = re.compile(rb"\st\s*=\s*[\"']s[\"']")
_STYLE = re.compile(rb"\ss\s*=\s*[\"']([0-9]{1,6})[\"']")
#: Of a number format: texts in quotes, signs behind a backslash; what stands in brackets is none.
_LITERAL = re.compile(r'"([^"]*)"|\\(.)|\[[^\]]*\]|([_*].)')
_ERROR_CELL = re.compile(rb"\st\s*=\s*[\"']e[\"']")
_ERROR_TEXT = re.compile(rb">\s*(#[A-Za-z0-9/!?]{1,20})\s*<")
_SAVE_AGAIN = "Open it in a spreadsheet program, save it as .xlsx and copy it here again."


@dataclass
class SheetScan:
    """What a worksheet's XML says before it is read: extent and formulas without values."""

    rows: int = 0
    columns: int = 0
    cells: int = 0
    text_cells: int = 0
    formulas_without_value: list[tuple[int, int]] = field(default_factory=list)
    """(row number, column index) of each."""
    errors: list[tuple[int, int, str]] = field(default_factory=list)
    """(row number, column index, text such as #DIV/0!) of cells that hold an error."""
    hidden_rows: list[int] = field(default_factory=list)
    """Numbers of rows with cells that the workbook does not show."""
    units: dict[tuple[int, int], str] = field(default_factory=dict)
    """(row number, column index) -> unit that the number format of the cell shows."""


@dataclass(frozen=True)
class Archive:
    """A zip file whose members were unpacked within the limits."""

    names: frozenset[str]
    members: dict[str, bytes]
    """The XML members, by lower-case name; others were measured and dropped."""


def unpack(data: bytes, place: Place, limits: Limits) -> Archive:
    """Unpack the XML members of a zip file within the limits.

    Raises `InputError` for one that is truncated, damaged, encrypted, or larger than the limits.
    """
    try:
        packed = zipfile.ZipFile(BytesIO(data))
    except (zipfile.BadZipFile, ValueError, OSError, struct.error, NotImplementedError) as error:
        raise InputError.at(
            place,
            "the workbook is damaged or truncated: its table of contents cannot be read.",
            expected="a complete .xlsx file.",
            remedy="Copy it from the bench again, or save it again in a spreadsheet program.",
        ) from error
    members: dict[str, bytes] = {}
    with packed:
        entries = packed.infolist()
        _check_directory(entries, place, limits)
        for entry in entries:
            content = _unpack_member(packed, entry, place, limits)
            part = entry.filename[:80]
            if content.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"<":
                members[entry.filename.lower()] = content
                if _DECLARATION.search(content) is not None:
                    raise _refused(
                        place,
                        f'its part "{part}" declares a document type or entities, which no '
                        "spreadsheet program writes; it was not read.",
                    )
            elif _HIDDEN_XML.search(content) is not None:
                # the reader passes over what stands before the first tag, the limits must not
                raise _refused(
                    place,
                    f'its part "{part}" holds cells and does not begin as XML does, which no '
                    "spreadsheet program writes; it was not read.",
                )
    return Archive(frozenset(entry.filename.lower() for entry in entries), members)


def _refused(place: Place, what: str) -> InputError:
    expected = "a workbook as a spreadsheet program saves it."
    return InputError.at(place, what, expected=expected, remedy=_SAVE_AGAIN)


def _check_directory(entries: list[zipfile.ZipInfo], place: Place, limits: Limits) -> None:
    names = [entry.filename.lower() for entry in entries]
    if any(entry.flag_bits & 0x1 for entry in entries):
        raise InputError.at(
            place,
            "the zip file is encrypted.",
            expected="a workbook without a password.",
            remedy="Save it without a password and copy it here again.",
        )
    if len(set(names)) != len(names) or len(names) > 20 * limits.max_sheets:
        what = "the workbook's table of contents names a part twice or far too many parts."
        raise _refused(place, what)
    total = sum(entry.file_size for entry in entries)
    if total > limits.max_unpacked_bytes:
        raise _too_large(place, f"unpacks to {total / 1e6:.0f} MB", limits)


def _too_large(place: Place, what: str, limits: Limits) -> InputError:
    return InputError.at(
        place,
        f"the workbook {what}: this looks like a zip bomb and was not read.",
        expected=f"at most {limits.max_unpacked_bytes / 1e6:.0f} MB unpacked and a ratio of at "
        f"most {limits.max_ratio:g}.",
        remedy="If it is a real record, export it again in parts or as CSV.",
    )


def _unpack_member(
    packed: zipfile.ZipFile, entry: zipfile.ZipInfo, place: Place, limits: Limits
) -> bytes:
    """Unpack one member: no more of it than the directory states, and that with its checksum."""
    # Small members (styles of a template, empty sheets) may pack well without any harm.
    if entry.file_size > max(4_000_000, limits.max_ratio * entry.compress_size):
        raise _too_large(place, f"unpacks to over {limits.max_ratio:g} times its size", limits)
    try:
        if entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            with packed.open(entry) as stream:
                content = stream.read(entry.file_size + 1)
            if len(content) == entry.file_size:
                return content
    except (zipfile.BadZipFile, zlib.error, OSError, EOFError, ValueError, NotImplementedError):
        pass
    raise InputError.at(
        place,
        f'the workbook is damaged: its part "{entry.filename[:80]}" cannot be unpacked.',
        expected="a complete .xlsx file.",
        remedy="Copy it from the bench again, or save it again in a spreadsheet program.",
    )


def units_of_styles(styles: bytes) -> dict[bytes, str]:
    """Return the unit that each style of cells shows behind its numbers, such as ``0.0 "kg"``."""
    from xml.etree import ElementTree as ET

    try:  # declarations of entities were refused by `unpack`
        root = ET.fromstring(styles or b"<r/>")  # noqa: S314
    except ET.ParseError:
        return {}  # the reader will say what is wrong with it
    units: dict[str, str] = {}
    found: dict[bytes, str] = {}
    for element in root.iter():
        tag = element.tag.rsplit("}", 1)[-1]
        if tag == "numFmt" and (unit := _unit_of_format(element.get("formatCode", ""))):
            units[element.get("numFmtId", "")] = unit
        elif tag == "cellXfs":
            own = (units.get(one.get("numFmtId", "")) for one in element)
            found = {str(at).encode(): unit for at, unit in enumerate(own) if unit}
    return found


def _unit_of_format(code: str) -> str | None:
    r"""Return the unit in a number format.

    >>> _unit_of_format('0.0 "kg"'), _unit_of_format(r"0.00\ \N"), _unit_of_format('0.0;"-"0.0')
    ('kg', 'N', None)
    """
    texts = {"".join(a or b for a, b, _ in _LITERAL.findall(one)) for one in code.split(";")}
    units = {unit for text in texts if (unit := read_unit_cell(text)) and unit != "-"}
    return units.pop() if len(units) == 1 else None


def scan_sheet(xml: bytes, units: Mapping[bytes, str] = MappingProxyType({})) -> SheetScan:
    """Find a worksheet's extent from cell A1, its cells, and its formulas without values.

    `units` are those that the number formats of styles show.
    """
    scan = SheetScan()
    # The extent is taken from every reference in the text, so that no odd quoting can hide a cell
    # at the far end: a reader that lays the sheet out as a dense table would not survive it.
    references = _ANY_REFERENCE.findall(xml)
    for number in {number for _, number in references}:
        # A number of too many digits would be cut to its last ones, or worse, by other readers.
        scan.rows = max(scan.rows, int(number or 0) if len(number) <= 7 else _FAR)
    for letters in {letters for letters, _ in references}:
        far = len(letters) > 3
        scan.columns = max(scan.columns, _FAR if far else column_index(letters.decode()) + 1)
    rows = [(found.start(), found[1]) for found in _ROW.finditer(xml)]
    row = 0
    for position, (start, number) in enumerate(rows):
        row = int(number) if number else row + 1
        scan.rows = max(scan.rows, row)
        end = rows[position + 1][0] if position + 1 < len(rows) else len(xml)
        before = scan.cells
        _scan_row(xml, (start, end), row, scan, units)
        head = _ATTRIBUTES.match(xml, start + 1)
        if scan.cells > before and head is not None and _HIDDEN.search(head[0]):
            scan.hidden_rows.append(row)
    return scan


def _scan_row(
    xml: bytes, span: tuple[int, int], row: int, scan: SheetScan, units: Mapping[bytes, str]
) -> None:
    # From cell to cell, not to each closing tag: where those are missing, looking for them from
    # every cell would take the square of the time.
    starts = [found.end() for found in _CELL.finditer(xml, *span)]
    column = -1
    for start, end in pairwise([*starts, span[1]]):
        cell = xml[start:end]
        attributes = _ATTRIBUTES.match(cell)
        head = attributes[0] if attributes else b""
        reference = _REFERENCE.search(head)
        column = column_index(reference[1].decode()) if reference else column + 1
        at_row = int(reference[2]) if reference else row
        scan.columns = max(scan.columns, column + 1)
        scan.cells += 1
        scan.text_cells += _TEXT_CELL.search(head) is not None
        if units and (style := _STYLE.search(head)) and style[1] in units:
            scan.units[at_row, column] = units[style[1]]
        if _ERROR_CELL.search(head):
            text = _ERROR_TEXT.search(cell)
            scan.errors.append((at_row, column, text[1].decode() if text else "#ERROR"))
        if b"f" in cell and _FORMULA.search(cell) and not _VALUE.search(cell):
            scan.formulas_without_value.append((at_row, column))


def longest_shared_text(xml: bytes) -> int:
    """Return the size of the longest entry of ``xl/sharedStrings.xml`` [bytes]."""
    entries = re.split(rb"</(?:\w+:)?si>", xml)
    return max((len(entry) for entry in entries), default=0)


def hidden_problems(scan: SheetScan | None, where: Place, *, is_hidden: bool) -> Iterator[Problem]:
    """Say that a sheet (`is_hidden`), or rows of it, are hidden and were read all the same."""
    if scan is None or not scan.cells:
        return

    if is_hidden:
        remedy = "Delete the sheet if it is not meant, or name the right ones in vehicle.yaml."
        yield where.note("the sheet is hidden and was read.", remedy=remedy)
    if scan.hidden_rows:
        rows = scan.hidden_rows
        place = Place(where.file, where.sheet, rows[0])
        what = f"hidden in the workbook and read all the same: {listed(rows)}."
        yield place.note(what, remedy='Mark rows with "#" in column A to leave them out.')
