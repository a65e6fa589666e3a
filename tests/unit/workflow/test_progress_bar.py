"""The bar at the bottom of a terminal is one line, however many stages run."""

import io

import pytest

from pipeline.journal import Event
from pipeline.workflow.progress import Progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_the_bar_never_wraps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    stream = Terminal()
    progress = Progress(stream, total=40)
    for number in range(20):
        progress.take(Event("started", "boat", "run_trial", item=f"dive{number}"))
    bars = stream.getvalue().split("\r\x1b[2K")
    assert max(map(len, bars)) == 59
