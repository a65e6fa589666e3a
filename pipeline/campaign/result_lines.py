"""Result files of campaigns: one line of JSON a case, appended as cases end."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pipeline.provenance import unwritable


def read_lines(file: Path) -> list[dict[str, Any]]:
    """Lines that a campaign has written; one that was cut off is left out.

    Examples
    --------
    >>> read_lines(Path("no such file"))
    []
    """
    if not file.is_file():
        return []
    found = []
    for text in file.read_text(encoding="utf-8").splitlines():
        try:
            line = json.loads(text)
        except json.JSONDecodeError:
            continue
        if isinstance(line, dict):
            found.append(line)
    return found


@contextmanager
def appending(file: Path) -> Iterator[Callable[[dict[str, Any]], None]]:
    """Give a function that appends a line, each written to the end before it returns.

    A last line that was cut off is ended first: the next one would be lost with it.

    Raises
    ------
    InputError
        When the place cannot be written.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        there = file.read_bytes() if file.is_file() else b""
        stream = file.open("a", encoding="utf-8")
    except OSError as error:
        raise unwritable(file, error) from error
    with stream:

        def append(line: dict[str, Any]) -> None:
            stream.write(json.dumps(line) + "\n")
            stream.flush()

        if there and not there.endswith(b"\n"):
            stream.write("\n")
        yield append
