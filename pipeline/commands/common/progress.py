"""What a long command is doing: one line on a terminal that goes away, plain lines otherwise.

All of it goes to standard error, so what a machine reads on standard output stays as it is.
"""

import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
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
