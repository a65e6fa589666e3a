"""The part of a page that a command writes, between marks; the rest is a person's."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.provenance import write_atomically


def write_block(page: Path, name: str, title: str, text: str) -> None:
    """Put a text between the marks of a page; a page that is not there is begun.

    Parameters
    ----------
    page : Path
        Markdown with ``<!-- name -->`` and ``<!-- end of name -->``.
    name : str
        Of the block.
    title : str
        Of a page that is begun.
    text : str
        What stands in it.

    Raises
    ------
    InputError
        When the page has no such marks, or cannot be read or written.
    """
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    try:
        there = page.read_text(encoding="utf-8")
    except FileNotFoundError:
        there = f"# {title}\n\n{begin}\n{end}\n"
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(
            Place(str(page)),
            f"the page cannot be read: {error}.",
            remedy="Give another page.",
        ) from None
    before, mark, rest = there.partition(begin)
    _, closing, after = rest.partition(end)
    if not (mark and closing):
        raise InputError.at(
            Place(str(page)),
            f"the page has no place for {name}.",
            expected=f"a line {begin} and, below it, a line {end}.",
            remedy="Put the two lines where the result is to stand, or give a page that is not "
            "there yet.",
        )
    write_atomically(page, f"{before}{begin}\n{text.strip()}\n{end}{after}")


def write_csv(path: Path, rows: Iterable[Sequence[str]]) -> None:
    """Write what is too long for a page beside it: comma-parted, whole or not at all."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    write_atomically(path, text.getvalue())
