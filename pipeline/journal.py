"""What the stages tell the run that started them, one JSON line an event."""

import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

#: Environment variable with the journal's path; without it nothing is written.
VARIABLE = "RIG2SEA_JOURNAL"


@dataclass(frozen=True)
class Event:
    """A stage has started, is done (perhaps without a result: `text` says why), or has failed."""

    what: Literal["started", "done", "failed"]
    vehicle: str
    stage: str
    text: str = ""
    seconds: float = 0.0
    item: str = ""
    """Run or day, of a stage that has more than one."""


def note(event: Event) -> None:
    """Append an event; one write, so that stages at work side by side do not mix their lines."""
    path = os.environ.get(VARIABLE)
    if path is None:
        return
    line = (json.dumps(asdict(event), ensure_ascii=False) + "\n").encode()
    descriptor = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    try:
        os.write(descriptor, line)
    finally:
        os.close(descriptor)


class Reader:
    """Gives the events that were appended since it was last asked."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0

    def new_events(self) -> Iterator[Event]:
        """Yield every whole line that has appeared."""
        if not self._path.exists():
            return
        with self._path.open("rb") as file:
            file.seek(self._at)
            for line in file:
                if not line.endswith(b"\n"):
                    return
                self._at += len(line)
                try:
                    event = Event(**json.loads(line))
                except (ValueError, TypeError):
                    continue  # machines of a cluster may write over each other's lines
                yield event
