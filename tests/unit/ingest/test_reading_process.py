"""A reader that dies takes no other file with it."""

import os
import signal

import pytest

from pipeline.errors import InputError, Place
from pipeline.ingest.reading_process import in_reading_process, opening


def test_what_was_done_comes_back() -> None:
    assert in_reading_process(lambda: {"rows": [1.0, 2.0]}) == {"rows": [1.0, 2.0]}
    with pytest.raises(InputError, match=r"a\.xlsx: odd"):
        in_reading_process(lambda: _raise(InputError.at(Place("a.xlsx"), "odd")))


def _raise(error: Exception) -> None:
    raise error


@pytest.mark.parametrize("how", [signal.SIGABRT, signal.SIGKILL])
def test_a_file_that_ends_the_reader_is_refused_by_name(how: signal.Signals) -> None:
    def read() -> list[str]:
        found = []
        for file in ("a.xlsx", "bad.xlsx", "c.xlsx"):
            try:
                opening(file)
            except InputError as error:
                found.append(str(error).split(":")[0])
                continue
            if file == "bad.xlsx":
                os.kill(os.getpid(), how)
            found.append(file.upper())
        return found

    assert in_reading_process(read) == ["A.XLSX", "bad.xlsx", "C.XLSX"]


def test_a_process_that_dies_without_a_file_is_a_fault() -> None:
    with pytest.raises(RuntimeError, match="ended by signal"):
        in_reading_process(lambda: os.kill(os.getpid(), signal.SIGABRT))
