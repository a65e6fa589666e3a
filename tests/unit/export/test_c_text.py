"""Nothing from a file that a person wrote gets into the source unescaped."""

import re

import numpy as np
import pytest
from firmware_cases import unhurried
from hypothesis import example, given
from hypothesis import strategies as st

from pipeline.errors import CannotComputeError
from pipeline.export import c_text


@pytest.mark.parametrize(
    "name", ["", "3rov", "a b", "a/b", "../a", "a;", 'a"', "аппарат", "a" * 49, "a\n", "a²"]
)
def test_names_that_are_no_names_are_refused(name: str) -> None:
    with pytest.raises(CannotComputeError, match=r"vehicle\.yaml"):
        c_text.c_identifier(name)


def test_names_become_identifiers() -> None:
    assert c_text.c_identifier("mmt300") == "mmt300"
    assert c_text.c_identifier("T200-16V") == "T200_16V"


@given(st.text())
@example("*\\")
@example("\\*\\*/*/")
@example("????/")
@unhurried
def test_a_comment_stays_one_line_inside_its_comment(text: str) -> None:
    safe = c_text.c_comment(text)
    assert re.fullmatch(r"[\x20-\x7e]*", safe)
    assert "*/" not in safe
    assert "/*" not in safe
    assert "\\" not in safe
    assert "??" not in safe


@given(st.text())
@unhurried
def test_a_string_literal_reads_back(text: str) -> None:
    literal = c_text.c_string(text)
    body = literal[1:-1]
    assert re.fullmatch(r'(?:[^"\\?\x00-\x1f\x7f-\xff]|\\["\\?]|\\[0-7]{3})*', body)
    read = re.sub(
        r'\\([0-7]{3}|["\\?])',
        lambda m: chr(int(m[1], 8)) if m[1].isdigit() else m[1],
        body,
    )
    assert read.encode("latin-1").decode("utf-8") == text
    assert c_text.c_string_size(text) == len(text.encode()) + 1


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
@unhurried
def test_a_float_literal_reads_back(value: float) -> None:
    literal = c_text.float_literal(value)
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?f", literal)
    assert "." in literal or "e" in literal
    assert np.float32(literal.removesuffix("f")) == np.float32(value)


def test_arrays_are_wrapped_and_counted() -> None:
    text = c_text.c_array(
        "float", "x", [("first", ["1.0f"] * 30), ("", ["2.0f"])], comment="Some. [N]"
    )
    assert text.startswith(
        "/* Some. [N] */\nstatic const float x[31] = {\n    /* first */\n    1.0f,"
    )
    assert text.endswith("    2.0f,\n};")
    assert max(map(len, text.splitlines())) <= c_text.WIDTH
