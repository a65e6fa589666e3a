"""Numbers and units in Russian texts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.language.numerals import in_russian


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("0.5", "0,5"),
        ("−1.25 N m", "−1,25 Н·м"),
        ("3 rpm, 12.5 rpm", "3 об/мин, 12,5 об/мин"),
        ("8.82·10⁻⁴", "8,82·10⁻⁴"),
        ("1.5e-3", "1,5e-3"),
        ("12.5. Next", "12,5. Next"),
        ("(0.5, 1, 2.25)", "(0,5; 1; 2,25)"),
        ("1, 2, 3", "1, 2, 3"),
        ("22.5 deg and 3 deg/s", "22,5° and 3°/с"),
        ("residual of M  [mN m]", "residual of M  [мН·м]"),
        ("thrust, N", "thrust, Н"),
        ("2.0 % of 3 V", "2,0 % of 3 В"),
    ],
)
def test_known_values(text: str, said: str) -> None:
    assert in_russian(text) == said


@pytest.mark.parametrize(
    "text",
    [
        "run-1.5.mcap",
        "raw/a/v2.5/drive.xlsx",
        "rig2sea 0.1.0",
        "Python 3.11",
        'sheet "V 1.5"',
        "`step_s: 0.5`",
        "--effect tether:drag_area_m2=0.175,pull_n=10.3",
        "--step 0.3",
        "192.168.0.1",
        "K_F1 N + K_F2",
        "code N",
        "docs/decisions/0001.5.md",
        "module_1@0.5",
    ],
)
def test_names_and_what_is_typed_stay(text: str) -> None:
    assert in_russian(text) == text


@given(st.text(alphabet="0123456789., -−NmsV[]()rpdegk/;=\"'"))
def test_said_twice_is_said_once(text: str) -> None:
    once = in_russian(text)
    assert in_russian(once) == once
