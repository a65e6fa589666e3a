"""Files that are broken, disguised or built to hurt: one clear message each."""

import contextlib
import os
import struct
import zipfile
import zlib
from pathlib import Path

import pytest
from bench_workbooks import change_member, vehicle, write_workbook
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.errors import InputError
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.ingest.workbook import Limits, read_sheets

SHEET = "xl/worksheets/sheet1.xml"
ROWS = [["n, rpm", "M, N m"], [1324, 0.5], [1300, 0.6], [1200, 0.7]]


@pytest.fixture
def workbook(tmp_path: Path) -> Path:
    return write_workbook(tmp_path / "bench.xlsx", {"Code 90": ROWS})


def message(path: Path, limits: Limits | None = None) -> str:
    with pytest.raises(InputError) as caught:
        read_sheets(path, path.name, limits or Limits())
    text = str(caught.value)
    assert text.startswith(path.name)
    assert caught.value.problem.remedy
    assert len(text) < 600
    return text


def test_truncated(workbook: Path) -> None:
    whole = workbook.read_bytes()
    for share in (0.3, 0.7, 0.99):
        workbook.write_bytes(whole[: int(len(whole) * share)])
        assert "damaged or truncated" in message(workbook)


def test_empty_and_blank(tmp_path: Path) -> None:
    for name, content in (("a.xlsx", b""), ("a.csv", b" \r\n\n"), ("b.xlsx", b"\x00" * 2000)):
        (tmp_path / name).write_bytes(content)
        assert "empty" in message(tmp_path / name)


def test_encrypted(tmp_path: Path) -> None:
    path = tmp_path / "a.xlsx"
    head = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
    path.write_bytes(head + bytes(1000) + "EncryptedPackage".encode("utf-16-le") + bytes(500))
    assert "encrypted" in message(path)
    assert "password" in message(path)


def test_old_excel_renamed(tmp_path: Path) -> None:
    path = tmp_path / "a.xlsx"
    path.write_bytes(
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(1000) + "Workbook".encode("utf-16-le")
    )
    assert "old Excel file" in message(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"<!DOCTYPE html><html><body>Login</body></html>", "HTML page"),
        (b"<html><table><tr><td>1</td></tr></table></html>", "HTML page"),
        (b"%PDF-1.4 ...", "PDF"),
        (b"n;M\n1;2\n", "plain text"),
        ("код;упор\r\n1;2\r\n".encode("cp1251"), "plain text"),
        (b"\x06n\xb5-\xec\xeen\xf2\xd2~H\xac\xd4\xaaH\x8e", "another kind"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", "another kind"),
        (b"<?xml version='1.0'?><Workbook/>", "XML"),
    ],
)
def test_something_else_renamed(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "a.xlsx"
    path.write_bytes(content)
    assert said in message(path)
    assert "no workbook" in message(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"<!doctype html><p>1;2", "HTML page"),
        (b"\x89PNG\r\n\x1a\n\x00\x01\x02;", "not a text file"),
    ],
)
def test_something_else_named_csv(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    assert said in message(path)


def test_a_zip_file_without_a_workbook(tmp_path: Path) -> None:
    path = tmp_path / "a.xlsx"
    for members, said in (
        ({"readme.txt": b"hello"}, "holds no workbook"),
        ({"mimetype": b"x", "content.xml": b"<a/>"}, "OpenDocument"),
        ({"word/document.xml": b"<a/>"}, "Word"),
        ({"xl/workbook.bin": b"\x00"}, "binary workbook"),
    ):
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in members.items():
                archive.writestr(name, content)
        assert said in message(path)


def test_an_unknown_kind_of_file(tmp_path: Path) -> None:
    (tmp_path / "a.docx2").write_text("hello", encoding="utf-8")
    assert '".docx2" are not read' in message(tmp_path / "a.docx2")


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    assert "no such file" in message(tmp_path / "none.xlsx")
    (tmp_path / "a.xlsx").mkdir()
    assert "not a file" in message(tmp_path / "a.xlsx")


def test_not_readable(workbook: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Permissions do not hold back a superuser, who may well run the tests.
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be read: Permission denied" in message(workbook)


@pytest.mark.skipif(os.geteuid() == 0, reason="a superuser may read everything")
def test_permissions(workbook: Path) -> None:
    workbook.chmod(0)
    assert "Permission denied" in message(workbook)


def test_a_bomb_by_ratio(workbook: Path) -> None:
    change_member(workbook, SHEET, lambda xml: xml.replace(b"</worksheet>", b" " * 30_000_000))
    assert "zip bomb" in message(workbook)


def test_a_bomb_by_size(workbook: Path) -> None:
    change_member(workbook, SHEET, lambda xml: xml + b" " * 3_000_000)
    assert "zip bomb" in message(workbook, Limits(max_unpacked_bytes=2_000_000))


def _lie_about_size(path: Path, name: str, size: int) -> None:
    """State another unpacked size in the directory and in the local header."""
    data = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        entry = archive.getinfo(name)
        offset = entry.header_offset
    struct.pack_into("<I", data, offset + 22, size)
    directory = data.rindex(b"PK\x01\x02", 0, data.rindex(name.encode()))
    struct.pack_into("<I", data, directory + 24, size)
    path.write_bytes(data)


def test_a_bomb_that_lies_about_its_size(workbook: Path) -> None:
    change_member(workbook, SHEET, lambda xml: xml + b" " * 30_000_000)
    _lie_about_size(workbook, SHEET, 1000)
    with zipfile.ZipFile(workbook) as archive:
        assert archive.getinfo(SHEET).file_size == 1000  # the lie is in place
    assert "cannot be unpacked" in message(workbook)


def test_a_small_lie_is_damage(workbook: Path) -> None:
    _lie_about_size(workbook, SHEET, 17)
    assert "damaged" in message(workbook)


def test_members_that_share_their_bytes(tmp_path: Path) -> None:
    """Many directory entries may point at one packed member: each counts."""
    path = tmp_path / "a.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/workbook.xml", b"<workbook/>")
        for number in range(40):
            archive.writestr(f"xl/{number}.xml", os.urandom(1000) * 100)
    assert "zip bomb" in message(path, Limits(max_unpacked_bytes=2_000_000))


def test_a_broken_stream(workbook: Path) -> None:
    data = bytearray(workbook.read_bytes())
    with zipfile.ZipFile(workbook) as archive:
        entry = archive.getinfo(SHEET)
    start = entry.header_offset + 30 + len(SHEET)
    data[start : start + 20] = b"\xff" * 20
    workbook.write_bytes(data)
    assert "cannot be unpacked" in message(workbook)


def test_a_wrong_checksum(workbook: Path) -> None:
    content = zipfile.ZipFile(workbook).read(SHEET)
    data = workbook.read_bytes()
    wrong = struct.pack("<I", zlib.crc32(content) ^ 1)
    workbook.write_bytes(data.replace(struct.pack("<I", zlib.crc32(content)), wrong))
    assert "damaged" in message(workbook)


@pytest.mark.parametrize(
    "declaration",
    [
        b'<!DOCTYPE a [<!ENTITY b "c">]>',
        b'<!DOCTYPE a SYSTEM "file:///etc/passwd">',
        b"<!doctype a>",
        b'<!ENTITY b "c">',
    ],
)
@pytest.mark.parametrize("member", [SHEET, "xl/workbook.xml", "[Content_Types].xml"])
def test_declarations_are_refused(workbook: Path, declaration: bytes, member: str) -> None:
    change_member(workbook, member, lambda xml: declaration + xml)
    assert "document type or entities" in message(workbook)


@pytest.mark.parametrize(
    "cell", [b"XFD1048576", b"A1048576", b"XFD1", b"B99999999999", b"B4294967299", b"ZZZZZZZ5"]
)
def test_a_cell_at_the_far_end(workbook: Path, cell: bytes) -> None:
    """A dense table of that extent would not fit into memory."""
    change_member(workbook, SHEET, lambda xml: xml.replace(b'r="B4"', b'r="' + cell + b'"'))
    assert "reaches to row" in message(workbook)


def test_a_far_cell_behind_odd_quoting(workbook: Path) -> None:
    change_member(
        workbook, SHEET, lambda xml: xml.replace(b'<c r="B4"', b"<c s='>' r = 'XFD1048576'")
    )
    assert "reaches to row" in message(workbook)


def test_cells_that_never_close(workbook: Path) -> None:
    """Looking for the end from every one of them would take the square of the time."""
    opened = b"<row>" + b"<c><f>" * 300_000 + b"</row></sheetData>"
    change_member(workbook, SHEET, lambda xml: xml.replace(b"</sheetData>", opened))
    assert "reaches to row" in message(workbook)


def test_names_repeated_without_end(tmp_path: Path) -> None:
    path = tmp_path / "code_90.csv"
    path.write_text("n, rpm;M, N m\n1;2\n" * 2000, encoding="utf-8")
    record = read_load_tests([path], vehicle(), tmp_path)
    assert "repeated 2000 times" in record.problems[0].what
    assert not record.points


def test_a_merged_range_over_everything_is_harmless(workbook: Path) -> None:
    merged = b'</sheetData><mergeCells count="1"><mergeCell ref="A1:XFD1048576"/></mergeCells>'
    change_member(workbook, SHEET, lambda xml: xml.replace(b"</sheetData>", merged))
    (sheet,) = read_sheets(workbook, "a.xlsx")
    assert len(sheet.rows) == 4


def _merged(count: int, reference: str) -> bytes:
    cells = f'<mergeCell ref="{reference}"/>' * count
    return f'</sheetData><mergeCells count="{count}">{cells}</mergeCells>'.encode()


def test_very_many_merged_ranges_over_everything_are_refused(workbook: Path) -> None:
    """Each would be filled in again; ranges that a spreadsheet program makes never overlap."""
    many = _merged(2000, "A1:XFD1048576")
    change_member(workbook, SHEET, lambda xml: xml.replace(b"</sheetData>", many))
    said = message(workbook, Limits(max_cells=10_000))
    assert "merged ranges" in said
    (sheet,) = read_sheets(workbook, "a.xlsx", Limits(max_cells=16_000))
    assert len(sheet.filled) == 7


def test_merged_ranges_of_all_sheets_count_together(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"Code 90": ROWS, "Code 60": ROWS})
    many = _merged(1000, "A1:B4")
    for name in (SHEET, "xl/worksheets/sheet2.xml"):
        change_member(path, name, lambda xml: xml.replace(b"</sheetData>", many))
    assert "merged ranges" in message(path, Limits(max_cells=15_999))
    assert len(read_sheets(path, "a.xlsx", Limits(max_cells=16_000))) == 2


def test_one_long_text_in_very_many_cells(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"s": [[1]]})
    cells = "".join(f'<c r="A{row}" t="s"><v>0</v></c>' for row in range(2, 2002))
    change_member(
        path,
        SHEET,
        lambda xml: xml.replace(b"</sheetData>", f"<row>{cells}</row></sheetData>".encode()),
    )
    text = (
        b'<sst xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><si><t>%s</t></si>'
    )
    change_member(path, "xl/sharedStrings.xml", lambda _: text % (b"x" * 30_000) + b"</sst>")
    assert "would not fit into memory" in message(path, Limits(max_text_bytes=10_000_000))


def test_too_many_sheets(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {str(number): [[1]] for number in range(5)})
    assert "5 sheets" in message(path, Limits(max_sheets=4))


def test_too_large_a_file(workbook: Path) -> None:
    assert "larger than" in message(workbook, Limits(max_bytes=1000))


def test_formulas_without_values_are_named(tmp_path: Path) -> None:
    rows = [["n, rpm", "M, N m"], [1324, "=0.5*2"], [1300, "=B2"], [1200, 0.7]]
    path = write_workbook(tmp_path / "a.xlsx", {"Code 90": rows, "Code 60": ROWS})
    sheets = read_sheets(path, "a.xlsx")
    assert sheets[0].formulas == {(2, 1), (3, 1)}
    assert not sheets[1].formulas
    assert sheets[0].cell(2, 1) is None


def test_formulas_with_values_are_no_problem(workbook: Path) -> None:
    change_member(
        workbook,
        SHEET,
        lambda xml: xml.replace(b"<v>0.5</v>", b"<f>1/2</f><v>0.5</v>"),
    )
    (sheet,) = read_sheets(workbook, "a.xlsx")
    assert not sheet.problems
    assert sheet.cell(2, 1) == 0.5


def test_a_broken_sheet_leaves_the_others(tmp_path: Path) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"Code 90": ROWS, "Code 60": ROWS})
    change_member(path, SHEET, lambda xml: xml.replace(b"<v>0.6</v>", b"<v>abc</v>"))
    sheets = read_sheets(path, "a.xlsx")
    assert [len(sheet.rows) for sheet in sheets] == [0, 4]
    assert sheets[0].problems[0].severity == "error"


def test_bad_files_leave_the_others(tmp_path: Path) -> None:
    """Every bad file gets one message; the points of the good one are all there."""
    folder = tmp_path / "raw" / "trial" / "load_test"
    good = write_workbook(folder / "good.xlsx", {"Code 90": ROWS, "Code 60": ROWS})
    content = good.read_bytes()
    bad = {
        "cut.xlsx": content[:900],
        "old.xlsx": b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600),
        "empty.csv": b"",
        "page.xlsx": b"<html></html>",
    }
    for name, data in bad.items():
        (folder / name).write_bytes(data)
    record = read_load_tests(sorted(folder.iterdir()), vehicle(), tmp_path / "raw")
    assert len([point for point in record.points if point.source.file.endswith("good.xlsx")]) == 6
    errors = [problem for problem in record.problems if problem.severity == "error"]
    assert sorted(problem.place.file for problem in errors) == sorted(
        f"trial/load_test/{name}" for name in bad
    )


@pytest.mark.parametrize("kind", ["load_test", "mooring", "open_water"])
def test_a_file_that_breaks_a_library_leaves_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    def broken(*_: object) -> None:
        raise IndexError("list index out of range")

    monkeypatch.setattr("pipeline.ingest.workbook.unpack", broken)
    write_workbook(tmp_path / "bad.xlsx", {"Code 90": ROWS})
    header, *rows = {
        "load_test": ["code;speed, rpm;torque, N m", *(f"60;{900 - i};{0.1 * i}" for i in (1, 2))],
        "mooring": ["code;thrust, N", "-60;-9", "0;0", "60;9"],
        "open_water": ["J;KT;KM", "0.1;0.2;0.03", "0.2;0.1;0.02"],
    }[kind]
    (tmp_path / "good.csv").write_text("\n".join([header, *rows]), encoding="utf-8")
    reader = {
        "load_test": read_load_tests,
        "mooring": read_mooring_tables,
        "open_water": read_open_water,
    }[kind]
    record = reader([tmp_path / "bad.xlsx", tmp_path / "good.csv"], vehicle(), tmp_path)
    assert {point.source.file for point in record.points} == {"good.csv"}
    (problem,) = [one for one in record.problems if one.place.file == "bad.xlsx"]
    assert problem.severity == "error"
    assert "cannot be read (IndexError: list index out of range)" in problem.what


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(position=st.integers(0, 10_000), junk=st.binary(min_size=1, max_size=40))
def test_any_damage_is_read_or_refused(tmp_path: Path, position: int, junk: bytes) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"Code 90": ROWS})
    data = bytearray(path.read_bytes())
    start = position % len(data)
    data[start : start + len(junk)] = junk
    path.write_bytes(data)
    with contextlib.suppress(InputError):
        assert all(sheet.file == "a.xlsx" for sheet in read_sheets(path, "a.xlsx"))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(xml=st.text(alphabet="<>/crvft\"'=A1 0", max_size=200))
def test_any_sheet_xml_is_read_or_refused(tmp_path: Path, xml: str) -> None:
    path = write_workbook(tmp_path / "a.xlsx", {"Code 90": ROWS})
    change_member(
        path, SHEET, lambda old: old.replace(b"<sheetData>", b"<sheetData>" + xml.encode())
    )
    with contextlib.suppress(InputError):
        assert all(sheet.file == "a.xlsx" for sheet in read_sheets(path, "a.xlsx"))
