"""A long command tells what it does: plain lines in a pipe, a line that goes away on a terminal."""

import io
import re
import sys
import time

import pytest

from pipeline.commands.common import say
from pipeline.commands.common.say import telling


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_pipe_gets_plain_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with telling() as tell:
        tell("reading a.mcap")
        tell("reading b.mcap")
    assert stream.getvalue() == "reading a.mcap\nreading b.mcap\n"


def test_a_terminal_gets_one_line_that_goes_away(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(say, "_TICK_S", 0.01)

    def work() -> None:
        with telling() as tell:
            tell("reading a.mcap")
            while not re.search(r"reading a\.mcap \.\.\. \d+ s", stream.getvalue()):
                time.sleep(0.01)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work()
    said = stream.getvalue()
    assert "\n" not in said
    assert said.startswith("\r\x1b[2Kreading a.mcap ...")
    assert said.endswith("\r\x1b[2K")


@pytest.mark.parametrize("columns", [80, 40, 3])
def test_a_line_never_wraps(monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    """Clock included: a line that wraps stays, and the next second adds another."""
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(say, "_TICK_S", 0.01)
    monkeypatch.setenv("COLUMNS", str(columns))
    with telling() as tell:
        tell(f"simulating {'zig_zag_' * 20}.mcap with the effect")
        while " s" not in stream.getvalue().rpartition("\r")[2]:
            time.sleep(0.01)
    lines = stream.getvalue().split("\r\x1b[2K")
    assert max(map(len, lines)) <= max(columns - 1, len(" ... 0 s"))
    if columns > 10:
        assert max(map(len, lines)) == columns - 1
