"""Files that are broken, disguised, built to hurt, or simply wrong; a module of the tests."""

import io
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import openpyxl

HEADER = ["Speed (rpm)", "Torque (N m)"]
LOADS = [*range(2, 11), *range(10, 1, -1)]


def sweep(code: int, sign: float = 1.0) -> list[list[object]]:
    """Rows of one code of the synthetic bench's drive, loading and unloading."""
    stall = 1.6 * code / 127
    rows: list[list[object]] = []
    for i, tenths in enumerate(LOADS):
        torque = stall * tenths / 12
        rpm = (stall - torque) / 0.03 * 60
        rows.append([round(rpm + 0.01 * i, 2), round(sign * torque, 5)])
    return rows


def workbook(path: Path, sheets: dict[str, list[list[object]]]) -> None:
    """Write sheets of rows; a text that begins with "=" becomes a formula without a value."""
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)


def _whole() -> bytes:
    stream = io.BytesIO()
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Code 90"
    for row in [HEADER, *sweep(90)]:
        sheet.append(row)
    book.save(stream)
    return stream.getvalue()


def truncated(path: Path) -> None:
    """A copy that stopped half-way."""
    whole = _whole()
    path.write_bytes(whole[: len(whole) // 2])


def compound_file(path: Path, streams: dict[str, bytes]) -> None:
    """Write an OLE compound file (MS-CFB, version 3): what Excel's old and encrypted files are."""
    sector, end, free = 512, 0xFFFFFFFE, 0xFFFFFFFF
    chunks: list[bytes] = []
    table: list[int] = []
    starts = []
    for content in streams.values():
        padded = content + bytes(-len(content) % sector)
        starts.append(len(table))
        count = len(padded) // sector
        table += [*range(len(table) + 1, len(table) + count), end]
        chunks.append(padded)

    def entry(name: str, kind: int, links: tuple[int, int, int], start: int, size: int) -> bytes:
        text = name.encode("utf-16-le")
        return struct.pack(
            "<64sHBBIII16x4x8x8xIQ", text, len(text) + 2, kind, 1, *links, start, size
        )

    names = list(streams)
    directory = entry("Root Entry", 5, (free, free, 1), end, 0)
    for i, name in enumerate(names):
        right = i + 2 if i + 1 < len(names) else free
        directory += entry(name, 2, (free, right, free), starts[i], len(streams[name]))
    directory += bytes(-len(directory) % sector)
    directory_start = len(table)
    table += [*range(len(table) + 1, len(table) + len(directory) // sector), end]
    fat_start = len(table)
    table.append(0xFFFFFFFD)
    table += [free] * (-len(table) % (sector // 4))
    header = struct.pack(
        "<8s16xHHHHH6xIIIIIIIIII",
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        *(0x3E, 3, 0xFFFE, 9, 6),
        *(0, 1, directory_start, 0, 4096, end, 0, end, 0, fat_start),
    )
    header += struct.pack("<I", free) * ((sector - len(header)) // 4)
    fat = struct.pack(f"<{len(table)}I", *table)
    path.write_bytes(header + b"".join(chunks) + directory + fat)


def encrypted(path: Path) -> None:
    """A workbook with a password, as Excel saves it (ECMA-376 agile encryption)."""
    info = struct.pack("<HHI", 4, 4, 0x40) + b'<?xml version="1.0"?><encryption/>'
    package = struct.pack("<Q", 6000) + bytes((i * 131 + 7) % 256 for i in range(6000))
    compound_file(path, {"EncryptionInfo": info.ljust(4096), "EncryptedPackage": package})


def old_excel(path: Path) -> None:
    """An .xls file (BIFF8) under the name of an .xlsx file."""
    bof = struct.pack("<HHHHHHII", 0x809, 16, 0x600, 5, 0x0DBB, 0x07CC, 0, 6)
    eof = struct.pack("<HH", 0x0A, 0)
    compound_file(path, {"Workbook": (bof + eof).ljust(4096, b"\0")})


def zip_bomb(path: Path) -> None:
    """A workbook that unpacks to a thousand times its size."""
    name = "xl/worksheets/sheet1.xml"
    with (
        zipfile.ZipFile(io.BytesIO(_whole())) as old,
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for member in old.infolist():
            content = old.read(member)
            if member.filename == name:
                content = content.replace(b"<sheetData>", b"<sheetData>" + b" " * 60_000_000)
            new.writestr(member.filename, content)


def formulas(path: Path) -> None:
    """Torque as formulas that no spreadsheet program has ever computed."""
    rows = [[rpm, f"=C{i}*2"] for i, (rpm, _) in enumerate(sweep(31), start=2)]
    workbook(path, {"Code 31": [HEADER, *rows]})


def text_in_a_column(path: Path) -> None:
    """One reading is a word."""
    rows = sweep(41)
    rows[5][1] = "1,2,3"
    workbook(path, {"Code 41": [HEADER, *rows]})


def wrong_unit(path: Path) -> None:
    """A torque in newtons."""
    workbook(path, {"Code 51": [["Speed (rpm)", "Torque (N)"], *sweep(51)]})


def no_unit(path: Path) -> None:
    """A torque without a unit."""
    workbook(path, {"Code 61": [["Speed (rpm)", "Torque"], *sweep(61)]})


def code_twice(path: Path) -> None:
    """Two sheets of one code."""
    first, second = sweep(71), sweep(71)
    second = [[rpm, round(float(str(torque)) * 1.3, 5)] for rpm, torque in second]
    workbook(path, {"Code 71": [HEADER, *first], "Code 71 (2)": [HEADER, *second]})


def negative_torque(path: Path) -> None:
    """The sensor counts the other way."""
    workbook(path, {"Code 81": [HEADER, *sweep(81, sign=-1.0)]})


def all_nan(path: Path) -> None:
    """The torque was not connected."""
    rows = [[rpm, "NaN"] for rpm, _ in sweep(91)]
    workbook(path, {"Code 91": [HEADER, *rows]})


def one_code(path: Path) -> None:
    """A load test of a single code."""
    workbook(path, {"Code 90": [HEADER, *sweep(90)]})


def torque_that_does_not_fall(path: Path) -> None:
    """A drive whose torque hardly depends on speed: a small propeller never meets it."""
    sheets: dict[str, list[list[object]]] = {}
    for code in (20, 40, 60, 80, 100, 127):
        rows: list[list[object]] = [list(HEADER)]
        for i, load in enumerate(LOADS):
            rpm = 300 + 10 * code * (12 - load) / 12
            rows.append([round(rpm + 0.01 * i, 2), round(0.0126 * code * (1 + 0.002 * load), 5)])
        sheets[f"Code {code}"] = rows
    workbook(path, sheets)


def mooring_rows() -> list[list[object]]:
    """Code and thrust of both signs."""
    return [[code, round(0.0022 * code * abs(code), 3)] for code in range(-120, 121, 10)]


def mooring(path: Path, header: str, change: Callable[[int, object], object] | None = None) -> None:
    """Write a mooring table with a header of its own and each thrust changed."""
    rows = mooring_rows()
    if change is not None:
        rows = [[code, change(i, thrust)] for i, (code, thrust) in enumerate(rows, start=2)]
    workbook(path, {"Bollard": [["Code", header], *rows]})


def _mooring_formulas(path: Path) -> None:
    mooring(path, "Thrust, N", lambda row, _: f"=C{row}*2")


def _mooring_text(path: Path) -> None:
    mooring(path, "Thrust, N", lambda row, thrust: "обрыв" if row == 20 else thrust)


def _mooring_nan(path: Path) -> None:
    mooring(path, "Thrust, N", lambda *_: "NaN")


MOORING: dict[str, Callable[[Path], None]] = {
    "truncated.xlsx": truncated,
    "encrypted.xlsx": encrypted,
    "formulas.xlsx": _mooring_formulas,
    "text.xlsx": _mooring_text,
    "all_nan.xlsx": _mooring_nan,
    "wrong_unit.xlsx": lambda path: mooring(path, "Thrust, N m"),
    "no_unit.xlsx": lambda path: mooring(path, "Thrust"),
}
OPEN_WATER: dict[str, Callable[[Path], None]] = {
    "not_text.csv": lambda path: _write(path, bytes(range(256)) * 20),
    "text.csv": lambda path: _write(path, b"J,KT,KM\n0,.139,.0171\n.1,abc,.0154\n.2,.105,.0136\n"),
    "all_nan.csv": lambda path: _write(path, b"J,KT\n0,NaN\n0.1,NaN\n0.2,NaN\n"),
    "no_unit.csv": lambda path: _write(path, b"V (m/s),n,KT,KM\n0,1000,.139,.0171\n"),
}


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)


LOAD_TEST: dict[str, Callable[[Path], None]] = {
    "truncated": truncated,
    "encrypted": encrypted,
    "old_excel": old_excel,
    "zip_bomb": zip_bomb,
    "formulas": formulas,
    "text": text_in_a_column,
    "wrong_unit": wrong_unit,
    "no_unit": no_unit,
    "code_twice": code_twice,
    "negative_torque": negative_torque,
    "all_nan": all_nan,
}
