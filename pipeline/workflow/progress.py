"""One line a stage; on a terminal also a bar that stays at the bottom."""

import shutil
import sys
from dataclasses import dataclass, field
from typing import TextIO

from pipeline.journal import Event
from pipeline.language import as_it_is, translate
from pipeline.plan import TITLES

_BAR_CELLS = 24
_CLEAR_LINE = "\r\x1b[2K"


@dataclass
class Progress:
    """Turns the events of a run into lines, and counts what ended how."""

    stream: TextIO = field(default_factory=lambda: sys.stdout)
    quiet: bool = False
    total: int | None = None
    done: int = 0
    failed: list[Event] = field(default_factory=list)
    running: dict[tuple[str, str, str], Event] = field(default_factory=dict)
    stopped: str = ""
    """What to tell of an engine that ended by itself, with no stage to blame."""

    def take(self, event: Event) -> None:
        """Tell one event."""
        key = _key(event)
        if event.what == "started":
            # a job that a cluster starts again: what its first try said does not count any more
            again = [one for one in self.failed if _key(one) != key]
            if len(again) < len(self.failed):
                self.done -= 1
                self.failed = again
            self.running[key] = event
        else:
            self.running.pop(key, None)
            self.done += 1
            if event.what == "failed":
                self.failed.append(event)
            self.say(_line(event))
        self._draw_bar()

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        if self.quiet:
            return
        clear = _CLEAR_LINE if self.stream.isatty() else ""
        self.stream.write(f"{clear}{translate(text)}\n")
        self.stream.flush()

    def _draw_bar(self) -> None:
        if self.quiet or not self.stream.isatty() or not self.total:
            return
        filled = min(_BAR_CELLS, _BAR_CELLS * self.done // self.total)
        now = ", ".join(translate(TITLES.get(stage, stage)) for _, stage, _ in self.running)
        bar = f"[{'#' * filled}{'.' * (_BAR_CELLS - filled)}] {self.done}/{self.total} {now}"
        # a line that wraps could not be cleared
        self.stream.write(f"{_CLEAR_LINE}{bar[: shutil.get_terminal_size().columns - 1]}")
        self.stream.flush()

    def close(self) -> None:
        """Take the bar away."""
        if self.stream.isatty() and not self.quiet:
            self.stream.write(_CLEAR_LINE)
            self.stream.flush()


def _key(event: Event) -> tuple[str, str, str]:
    return event.vehicle, event.stage, event.item


def _line(event: Event) -> str:
    title = TITLES.get(event.stage, event.stage)
    whose = "".join(f"{as_it_is(name)}: " for name in (event.vehicle, event.item) if name)
    if event.what == "failed":
        return f"{whose}{title}: failed. {event.text}"
    result = event.text or "done"
    first, dot, reason = result.partition("left out. ")
    told = translate(result) if first or not dot else f"{translate(dot)}{translate(reason)}"
    return f"{whose}{translate(title)}: {told} ({event.seconds:.1f} s)"
