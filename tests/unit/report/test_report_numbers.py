"""Numbers as text."""

import math

from hypothesis import given
from hypothesis import strategies as st

from pipeline.report.html import symbols
from pipeline.report.numbers import MINUS, as_printed, general, with_interval

NUMBERS = st.floats(min_value=-1e6, max_value=1e6).filter(lambda x: abs(x) > 1e-9)


def read(text: str) -> float:
    """Read a number back as it is written on the page."""
    superscript = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    mantissa, _, power = text.replace(MINUS, "-").partition("·10")
    return float(mantissa) * 10.0 ** int(power.translate(superscript) or 0)


@given(NUMBERS)
def test_three_figures_are_right_to_half_of_the_last(value: float) -> None:
    digit = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    assert abs(read(general(value)) - value) <= 0.5001 * digit


@given(NUMBERS, st.floats(min_value=1e-6, max_value=1e3))
def test_an_interval_keeps_two_figures_of_its_half_width(value: float, half: float) -> None:
    text, interval = with_interval(value, (value - half, value + half))
    low, high = (read(part) for part in interval.split(" to "))
    assert abs((high - low) / 2 - half) <= 0.15 * half
    assert abs(read(text) - value) <= 0.15 * half


@given(st.decimals(min_value=-100, max_value=100, places=5).map(float))
def test_a_printed_number_comes_back_whole(value: float) -> None:
    assert math.isclose(read(as_printed(value)), value, rel_tol=1e-9, abs_tol=1e-12)


def test_symbols_escapes_before_it_marks_up() -> None:
    assert symbols("<i>K_T0</i>") == "&lt;i&gt;K<sub>T0</sub>&lt;/i&gt;"
    assert symbols("42.5 N m") == "42.5\N{NO-BREAK SPACE}N\N{NO-BREAK SPACE}m"
    assert symbols("K_N00, T_max.") == "K<sub>N00</sub>, T<sub>max</sub>."


def test_names_of_files_and_sheets_stay_as_they_are() -> None:
    for name in ("load_test/run_1.csv", "K_T.csv", "T_200.xlsx", "raw/K_T/x.csv", "my_K_T"):
        assert symbols(name) == name
