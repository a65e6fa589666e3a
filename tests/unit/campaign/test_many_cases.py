"""Cases side by side: all of them, and none that waits once it is stopped."""

import os
import time
from functools import partial
from pathlib import Path

import pytest

from pipeline.campaign.campaign import as_they_come


def leave_a_trace(number: int, folder: Path) -> tuple[int, int]:
    """Other processes take it from this module."""
    time.sleep(0.05)
    (folder / f"{number}.txt").touch()
    return number, os.getpid()


@pytest.mark.parametrize("processes", [1, 2])
def test_every_case_is_run_once(tmp_path: Path, processes: int) -> None:
    found = list(as_they_come(partial(leave_a_trace, folder=tmp_path), range(5), processes))
    assert sorted(number for number, _ in found) == list(range(5))
    assert len(list(tmp_path.iterdir())) == 5
    here = {pid == os.getpid() for _, pid in found}
    assert here == {processes == 1}


def test_what_waits_is_not_begun_once_it_is_stopped(tmp_path: Path) -> None:
    cases = as_they_come(partial(leave_a_trace, folder=tmp_path), range(200), 2)
    next(cases)
    cases.close()  # type: ignore[attr-defined]  # it is a generator
    done = len(list(tmp_path.iterdir()))
    time.sleep(0.5)
    assert len(list(tmp_path.iterdir())) == done < 200


def test_a_case_that_fails_stops_the_others(tmp_path: Path) -> None:
    run = partial(leave_a_trace, folder=tmp_path / "not there")
    with pytest.raises(FileNotFoundError):
        list(as_they_come(run, range(50), 2))
