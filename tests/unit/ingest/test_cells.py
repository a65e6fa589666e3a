import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.ingest.cells import (
    NotANumberError,
    column_index,
    column_letter,
    is_number,
    is_text,
    parse_number,
    shorten,
)


@pytest.mark.parametrize(
    ("cell", "number"),
    [
        (1324, 1324.0),
        (0.378, 0.378),
        ("1324", 1324.0),
        (" 0.378 ", 0.378),
        ("0,378", 0.378),
        (",5", 0.5),
        ("5,", 5.0),
        ("-0,378", -0.378),
        ("\u22120,378", -0.378),
        ("\u20130.5", -0.5),
        ("+12", 12.0),
        ("1 324", 1324.0),
        ("1\u00a0324,5", 1324.5),
        ("1\u202f324.5", 1324.5),
        ("1,324.5", 1324.5),
        ("1.324,5", 1324.5),
        ("1,234,567", 1234567.0),
        ("1.234.567", 1234567.0),
        ("1,324", 1.324),  # one comma is a decimal comma
        ("1e-3", 0.001),
        ("1,5E+2", 150.0),
    ],
)
def test_numbers_as_people_write_them(cell: str | float, number: float) -> None:
    assert parse_number(cell) == number


@pytest.mark.parametrize(
    "cell",
    ["1,2,3", "1.2.3", "1 2", "12 34", "#DIV/0!", "#REF!", "abc", "5 kg", "0x10", "1e", "--5", "²",
     "1_000", "٣x", True, float("inf"), "1e999", "12,34.5", "+-1", "5-6"],
)  # fmt: skip
def test_what_is_no_number_is_refused(cell: str | float | bool) -> None:
    with pytest.raises(NotANumberError, match="number"):
        parse_number(cell)


@pytest.mark.parametrize("cell", [None, "", "  ", "-", "—", "NaN", "nan", "n/a", "#N/A", "нет"])
def test_missing_values_are_none(cell: str | None) -> None:
    assert parse_number(cell) is None
    assert not is_number(cell)
    assert not is_text(cell)


def test_nan_is_missing() -> None:
    assert parse_number(float("nan")) is None


@pytest.mark.parametrize(
    ("cell", "unit"),
    [("24,1 В", "V"), ("2.1 A", "А"), ("0,5 N·m", "Н·м"), ("1500 rpm", "об/мин"), ("50 %", "проц")],
)
def test_a_trailing_unit_may_be_another_name_of_it(cell: str, unit: str) -> None:
    assert parse_number(cell, unit) == parse_number(cell.partition(" ")[0])


def test_a_trailing_unit_must_be_the_unit_of_the_column() -> None:
    assert parse_number("5,2 кгс·см", "кгс см") == 5.2
    assert parse_number("5.2N.mm", "[N mm]") == 5.2
    with pytest.raises(NotANumberError):
        parse_number("5.2 N m", "N mm")
    with pytest.raises(NotANumberError):
        parse_number("5.2 N m")


@pytest.mark.parametrize("cell", [1.01e30, "-1e31", 1.7e308, "9" * 31])
def test_what_no_reading_can_be_is_refused(cell: float | str) -> None:
    """Powers and products of readings must stay finite."""
    with pytest.raises(NotANumberError, match="larger than any reading"):
        parse_number(cell)


@given(st.floats(min_value=-1e30, max_value=1e30))
def test_every_float_comes_back_from_its_text(number: float) -> None:
    assert parse_number(repr(number)) == number
    assert parse_number(repr(number).replace(".", ",")) == number


@given(
    st.decimals(
        allow_nan=False, allow_infinity=False, min_value=-(10**9), max_value=10**9, places=3
    )
)
def test_thousands_blanks_change_nothing(number: object) -> None:
    text = f"{number:,.3f}"
    assert parse_number(text.replace(",", "\u00a0")) == float(str(number))
    assert parse_number(text.replace(",", " ").replace(".", ",")) == float(str(number))


@given(st.one_of(st.none(), st.booleans(), st.floats(), st.text(max_size=40)))
def test_any_cell_is_a_number_or_missing_or_refused(cell: str | float | bool | None) -> None:
    with contextlib.suppress(NotANumberError):
        number = parse_number(cell)
        assert number is None or math.isfinite(number)


@given(st.integers(min_value=0, max_value=16383))
def test_column_letters_come_back(index: int) -> None:
    assert column_index(column_letter(index)) == index


def test_column_letters_are_those_of_spreadsheets() -> None:
    assert [column_letter(index) for index in (0, 25, 26, 701, 702, 16383)] == [
        "A", "Z", "AA", "ZZ", "AAA", "XFD",
    ]  # fmt: skip


@given(st.text())
def test_shortened_texts_are_one_printable_line(text: str) -> None:
    short = shorten(text, 20)
    assert len(short) <= 20
    assert "\n" not in short
    assert "\x1b" not in short
