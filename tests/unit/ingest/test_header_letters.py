"""A heading that looks right and is not known: the message says what is odd about its letters."""

from pathlib import Path

import pytest

import pipeline
from pipeline.ingest.headers import odd_letters
from pipeline.ingest.mooring import read_mooring_tables


def test_letters_of_two_alphabets_in_a_word() -> None:
    assert "(с)" in odd_letters(["сode", "thrust"])
    assert "Latin letters (o)" in odd_letters(["кoд", "тяга"])
    assert odd_letters(["код N", "тяга F, кгс", "thrust, Н"]) == ""


@pytest.mark.parametrize(("encoding", "name"), [("koi8_r", "KOI8-R"), ("cp866", "CP866")])
def test_an_old_encoding_is_named(tmp_path: Path, encoding: str, name: str) -> None:
    path = tmp_path / "old.csv"
    rows = "".join(f"{code};{code * 0.3:.1f}\n" for code in range(-120, 130, 10))
    path.write_bytes(f"код;упор, Н\n{rows}".encode(encoding))
    read = read_mooring_tables([path], pipeline.load_vehicle("mmt300"), tmp_path)
    assert not read.points
    assert any(f'In the encoding {name} they would be "код"' in str(one) for one in read.problems)


def test_a_cyrillic_letter_in_an_english_name_is_named(tmp_path: Path) -> None:
    path = tmp_path / "mixed.csv"
    rows = "".join(f"{code};{code * 0.3:.1f}\n" for code in range(-120, 130, 10))
    path.write_text(f"сode;thrust, N\n{rows}", encoding="utf-8")
    read = read_mooring_tables([path], pipeline.load_vehicle("mmt300"), tmp_path)
    assert any("Cyrillic letters (с)" in str(one) for one in read.problems)
