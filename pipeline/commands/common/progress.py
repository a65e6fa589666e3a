"""What a long command is doing: one line on a terminal that goes away, plain lines otherwise.

All of it goes to standard error, so what a machine reads on standard output stays as it is.
"""

import shutil
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TextIO

from pipeline.language import translate

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


class Telling:
    """Tells what is done now; a sentence without a full stop, "reading dive-3.mcap"."""

    def __init__(self, line: _Line | None) -> None:
        self._line = line

    def __call__(self, text: str) -> None:
        """Tell it."""
        said = translate(text)
        if self._line is None:
            sys.stderr.write(f"{said}\n")
            sys.stderr.flush()
        else:
            self._line.show(said)


@contextmanager
def telling() -> Iterator[Telling]:
    """Give what a command tells with; on a terminal a clock runs beside the last text."""
    if not sys.stderr.isatty():
        yield Telling(None)
        return
    line, over = _Line(sys.stderr), threading.Event()

    def tick() -> None:
        while not over.wait(_TICK_S):
            line.draw()

    clock = threading.Thread(target=tick, daemon=True)
    clock.start()
    try:
        yield Telling(line)
    finally:
        over.set()
        clock.join()
        line.clear()
