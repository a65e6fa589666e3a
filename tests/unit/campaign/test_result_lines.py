"""Lines of a campaign that was stopped anywhere are read, and none is lost after."""

from pathlib import Path

import pytest

from pipeline.campaign.campaign import appending, read_lines
from pipeline.errors import InputError


def test_a_line_that_was_cut_off_takes_no_other_with_it(tmp_path: Path) -> None:
    file = tmp_path / "new" / "cases.jsonl"
    with appending(file) as append:
        append({"number": 0})
    file.write_text(file.read_text() + '{"number": 1, "sco', encoding="utf-8")
    assert read_lines(file) == [{"number": 0}]
    with appending(file) as append:
        append({"number": 2})
        # what was appended is there before the next one begins
        assert read_lines(file) == [{"number": 0}, {"number": 2}]
    assert read_lines(file) == [{"number": 0}, {"number": 2}]


def test_what_is_no_case_is_left_out(tmp_path: Path) -> None:
    file = tmp_path / "cases.jsonl"
    file.write_text('[1]\n"text"\n{"number": 3}\n', encoding="utf-8")
    assert read_lines(file) == [{"number": 3}]


def test_a_place_that_cannot_be_is_one_message(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(InputError, match="cannot be written"),
        appending(tmp_path / "file/lines.jsonl"),
    ):
        pass
