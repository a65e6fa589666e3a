"""One run at a time in a folder, and a message where the lock cannot be had."""

import errno
import os
from pathlib import Path

import pytest

from pipeline.errors import InputError
from pipeline.workflow.start import only_run


def test_second_run_is_told_who_is_at_work(tmp_path: Path) -> None:
    lock = tmp_path / "processed/.rig2sea/lock"
    with only_run(lock):
        with pytest.raises(InputError, match="another rig2sea is at work here") as told:
            only_run(lock).__enter__()
        assert f"(process {os.getpid()})" in str(told.value)
        assert str(told.value).startswith(f"{tmp_path}/processed: ")
    with only_run(lock):
        pass


def test_full_disk_is_told_as_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "pwrite", full)
    lock = tmp_path / "lock"
    with (
        pytest.raises(InputError, match="The disk is full: free some space") as told,
        only_run(lock),
    ):
        pass
    assert str(told.value).startswith(f"{lock}: cannot be written: No space left on device.")
    monkeypatch.undo()
    with only_run(lock):  # the failed one holds it no longer
        pass
