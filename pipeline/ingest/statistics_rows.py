"""Rows that sum up a table, such as its mean and spread: no readings."""

from collections.abc import Sequence

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.sheet import Row
from pipeline.ingest.vocabulary import plain
from pipeline.ingest.word_lists import words_of

STATISTICS = "statistics row"
_WORDS = frozenset(map(plain, words_of("groups", "statistics")))


def is_statistics(block: Block, cells: Row) -> bool:
    """Tell whether the first filled cell of a row within the table is a word such as "mean"."""
    low, high = block.span
    first = next((cell for cell in cells[low : high + 1] if cell is not None), None)
    return isinstance(first, str) and plain(first) in _WORDS


def statistics_problems(block: Block, rows: Sequence[int]) -> list[Problem]:
    """Warn of the rows that were left out because they only sum up the others."""
    if not rows:
        return []
    what = (
        f"{counted(len(rows), 'row')} of means, spreads or sums ({listed(rows)}); kept but not "
        "fitted."
    )
    remedy = 'Delete them, or mark them with "#" in column A.'
    return [Problem("warning", block.place(rows[0]), what, "readings alone.", remedy)]
