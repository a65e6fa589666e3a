"""What a command says: in the reader's language, as JSON, what it is doing, and how it ends."""

import errno
import json
import shutil
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TextIO

import click

from pipeline.errors import Place, Problem, is_of_the_machine, writing_remedy
from pipeline.language import translate

if TYPE_CHECKING:
    from pipeline.records.base import Record


#: What a file, a folder or a path can be to blame for, whatever the program does.
_OF_THE_PLACE = frozenset({errno.EACCES, errno.EPERM, errno.ENAMETOOLONG, errno.ELOOP})


def why_it_ended(error: Exception) -> str:
    """Return what to tell the user of an error that no code has made a message of.

    A folder that may not be entered or a full disk is named, with what to do; all else is a fault
    of the program, whose traceback is written to a file.
    """
    if isinstance(error, OSError) and (error.errno in _OF_THE_PLACE or is_of_the_machine(error)):
        return f"error: {_of_the_place(error)}"
    return _own_fault(error)


def _of_the_place(error: OSError) -> Problem:
    remedy = writing_remedy(error, "Mend that, then run again.")
    if error.filename is None:  # a write into a file that is open names none
        what = f"cannot go on: {error.strerror}."
        return Place("rig2sea").error(what, remedy=remedy)
    return Place(str(error.filename)).error(f"cannot be used: {error.strerror}.", remedy=remedy)


def _own_fault(error: Exception) -> str:
    """Write the traceback to a file and return what to tell the user."""
    trace = "".join(traceback.format_exception(error))
    try:
        # a name of its own: the folder is everybody's
        with tempfile.NamedTemporaryFile(
            "w", prefix="rig2sea-error-", suffix=".log", delete=False, encoding="utf-8"
        ) as log:
            log.write(trace)
        details = f"The details are in {log.name}."
        wanted = (
            "Please report it with that file and the command that you typed; see CONTRIBUTING.md."
        )
    except OSError:
        details = "The details could not be written."
        wanted = "Please report it with the command that you typed; see CONTRIBUTING.md."
    first = (str(error).splitlines() or [""])[0]
    return (
        f"error: a fault of rig2sea itself ({type(error).__name__}: {first}). {details}\n{wanted}"
    )


def say(text: str, *, err: bool = False) -> None:
    """Print a text in the reader's language."""
    click.echo(translate(text), err=err)


def print_json(body: "Mapping[str, Any] | Record") -> None:
    """Print one JSON object, in no language."""
    plain = body if isinstance(body, Mapping) else body.model_dump(mode="json")
    click.echo(json.dumps(plain, indent=1))


def warn(warnings: Iterable[str]) -> None:
    """Tell warnings on standard error."""
    for text in warnings:
        say(f"warning: {text}", err=True)


def end_with(refused: Iterable[Problem]) -> None:
    """Tell what was refused and end with exit code 1; do nothing when nothing was."""
    errors = tuple(refused)
    for problem in errors:
        say(f"error: {problem}", err=True)
    if errors:
        raise click.exceptions.Exit(1)


_CLEAR_LINE = "\r\x1b[2K"
_TICK_S = 1.0


@dataclass
class _Line:
    """The line on the terminal: what is done now and for how many seconds."""

    stream: TextIO
    text: str = ""
    since_s: float = 0.0
    lock: threading.Lock = field(default_factory=threading.Lock)

    def show(self, text: str) -> None:
        with self.lock:
            self.text, self.since_s = text, time.monotonic()
        self.draw()

    def draw(self) -> None:
        with self.lock:
            if not self.text:
                return
            seconds = time.monotonic() - self.since_s
            end = f" ... {seconds:.0f} s" if seconds >= _TICK_S else " ..."
            # a line that wraps cannot be cleared, and each second would add another
            room = max(shutil.get_terminal_size().columns - 1 - len(end), 0)
            self.stream.write(f"{_CLEAR_LINE}{self.text[:room]}{end}")
            self.stream.flush()

    def clear(self) -> None:
        with self.lock:
            self.text = ""
            self.stream.write(_CLEAR_LINE)
            self.stream.flush()


@contextmanager
def telling() -> Iterator[Callable[[str], None]]:
    """Give what a command tells with what it does now: "reading dive-3.mcap", without a full stop.

    On a terminal a clock runs beside the last text.
    """
    if not sys.stderr.isatty():
        yield lambda text: print(translate(text), file=sys.stderr, flush=True)
        return
    line, over = _Line(sys.stderr), threading.Event()

    def tick() -> None:
        while not over.wait(_TICK_S):
            line.draw()

    clock = threading.Thread(target=tick, daemon=True)
    clock.start()
    try:
        yield lambda text: line.show(translate(text))
    finally:
        over.set()
        clock.join()
        line.clear()
