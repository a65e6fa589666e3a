"""The folder of a campaign: which one it is, and a line of JSON for each case that is done.

``campaign.json`` says what makes its cases what they are, so that only that campaign goes on;
``cases.jsonl`` grows as cases end.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.errors import InputError, Place
from pipeline.provenance import unwritable, write_atomically

HEADER_FILE, CASES_FILE = "campaign.json", "cases.jsonl"


def claim_folder(lines_file: Path, header: Mapping[str, Any], *, resume: bool) -> None:
    """Write what a campaign is, or check that the folder holds this one.

    Raises `InputError` when the folder holds a campaign and `resume` is not set, or another
    campaign.
    """
    file = lines_file.with_name(HEADER_FILE)
    if lines_file.is_file() and not resume:
        raise InputError.at(
            Place(str(lines_file)),
            "there is a campaign in this folder already.",
            remedy="Give --resume to go on with it, or another folder with --to.",
        )
    if lines_file.is_file() and file.is_file():
        before = _read_header(file, header["schema"])
        differ = [key for key in header if before.get(key) != header[key]]
        if differ:
            raise InputError.at(
                Place(str(file)),
                f"the campaign in this folder has another {', '.join(differ)}.",
                expected="the same seed, vehicles and program: its cases would not be alike.",
                remedy="Begin a new campaign in another folder with --to.",
            )
    try:
        write_atomically(file, json.dumps(header, indent=1))
    except InputError as error:
        # the folder of a campaign has an option of its own
        remedy = error.problem.remedy.replace("--out", "--to")
        raise InputError(replace(error.problem, remedy=remedy)) from None


def _read_header(file: Path, schema: str) -> dict[str, Any]:
    """Read what a campaign is."""
    fault = "is not the header of a campaign."
    try:
        header = json.loads(file.read_text(encoding="utf-8"))
        if isinstance(header, dict):
            return header
    except OSError as error:
        fault = f"cannot be read: {error.strerror}."
    except (ValueError, RecursionError):
        pass
    raise InputError.at(
        Place(str(file)),
        fault,
        expected=f'a JSON object with "schema": "{schema}".',
        remedy="Put the file back that was there, or begin in another folder with --to.",
    )


def read_lines(file: Path) -> list[dict[str, Any]]:
    """Lines that a campaign has written; one that was cut off is left out.

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
