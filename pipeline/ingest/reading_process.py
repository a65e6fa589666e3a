"""Read files in a process of their own: one that ends its reader takes no other file with it.

Workbooks are read by compiled code, which ends the process where memory runs out or a limit was
missed. The process notes which file it opens; when it dies, it is started again, and that file is
refused by name.
"""

import mmap
import os
import pickle
import signal
import sys
from collections.abc import Callable
from tempfile import TemporaryFile
from typing import BinaryIO, TypeVar, cast

from pipeline.errors import InputError, Place

_Result = TypeVar("_Result")
_NOTE_BYTES = 4096
#: Ended by these, a process was stopped, and did not die of a file.
_STOPPED_BY = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


class _Notes:
    """What the processes tell each other: the file that is open, the files that ended a reader."""

    open_file: mmap.mmap | None = None
    deadly: frozenset[str] = frozenset()


def opening(file: str) -> None:
    """Note that compiled code is about to open a file.

    Raises `InputError` if that ended the process before.
    """
    if file in _Notes.deadly:
        raise InputError.at(
            Place(file),
            "the workbook ended the program that reads workbooks; it was not read.",
            expected="a workbook as a spreadsheet program saves it.",
            remedy="Open it in a spreadsheet program, save it as .xlsx and copy it here again.",
        )
    if _Notes.open_file is not None:
        name = file.encode(errors="surrogateescape")[: _NOTE_BYTES - 1]
        _Notes.open_file[:] = name.ljust(_NOTE_BYTES, b"\0")


def in_reading_process(work: Callable[[], _Result]) -> _Result:
    """Do work in a process of its own, as often as files end it.

    What it returns or raises comes back; nothing else that it changes in memory does. Raises
    `RuntimeError` if the process died although it had no (other) file open.
    """
    if not hasattr(os, "fork"):
        return work()
    deadly: frozenset[str] = frozenset()
    while True:
        note = mmap.mmap(-1, _NOTE_BYTES)
        with TemporaryFile() as answer:
            sys.stdout.flush()
            sys.stderr.flush()
            child = os.fork()
            if child == 0:
                _Notes.open_file, _Notes.deadly = note, deadly
                os._exit(_answer(work, answer))
            try:
                _, status = os.waitpid(child, 0)
            except KeyboardInterrupt:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                raise
            if os.WIFEXITED(status):
                return _result(answer)
        killed_by = os.WTERMSIG(status)
        if killed_by in _STOPPED_BY:
            raise KeyboardInterrupt
        file = bytes(note[:]).rstrip(b"\0").decode(errors="surrogateescape")
        if not file or file in deadly:
            raise RuntimeError(f"the process that reads files was ended by signal {killed_by}")
        deadly |= {file}


def _answer(work: Callable[[], _Result], answer: BinaryIO) -> int:
    found: tuple[str, object]
    try:
        found = ("result", work())
    except BaseException as error:  # noqa: BLE001 - whatever it is, it is raised again outside
        found = ("error", error)
    sys.stdout.flush()
    sys.stderr.flush()
    pickle.dump(found, answer, protocol=pickle.HIGHEST_PROTOCOL)
    answer.flush()
    return 0


def _result(answer: BinaryIO) -> _Result:  # type: ignore[type-var]  # what the work returned
    answer.seek(0)
    kind, found = pickle.load(answer)  # noqa: S301 - our own process wrote it
    if kind == "error":
        raise found
    return cast("_Result", found)
