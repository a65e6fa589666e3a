"""Find the tables on a sheet from their column names, in header rows of any depth."""

import functools
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block, headings
from pipeline.ingest.cells import Sheet, are_spoilt, is_number, is_text, shorten
from pipeline.ingest.column_choice import ColumnChoice, told_apart
from pipeline.ingest.column_units import HeadRows, read_columns
from pipeline.ingest.header_rows import Match, Wanted, header_rows, letter_of
from pipeline.ingest.stated_columns import columns_by_letter, missing_columns, rows_wanted
from pipeline.ingest.vocabulary import plain

_HEADING_ROWS = 12
"""Rows above the names in which headings are looked for."""
_MOST_TABLES = 500
"""Tables below each other on one sheet."""
_GRID = 4
"""Columns of one required quantity from which a table is a grid."""
_WORD = re.compile(r"[^\W\d_]+")
_LATIN = re.compile(r"[A-Za-z]")
_CYRILLIC = re.compile(r"[\u0400-\u04ff]")
#: Encodings of old Russian programs whose bytes were read as Windows-1251.
_OLD_ENCODINGS = ("koi8_r", "cp866")


@dataclass(frozen=True)
class BlockSearch:
    """Tables of one sheet and what was wrong with those that were refused."""

    blocks: tuple[Block, ...]
    problems: tuple[Problem, ...]


def find_blocks(sheet: Sheet, wanted: Wanted) -> BlockSearch:
    """Find every table on a sheet that has the required columns, top to bottom and left to right.

    Problems are a required unit that is not stated, a stated column that is not there, a header
    without data.
    """
    by_letter = {name: column for name, column in wanted.mapping.items() if letter_of(column)}
    if by_letter and wanted.is_complete(set(by_letter)):
        headers = columns_by_letter(sheet, wanted, by_letter)
    else:
        headers = header_rows(sheet, wanted)
        if not headers:
            return BlockSearch((), tuple(dict.fromkeys(missing_columns(sheet, wanted))))
    if len(headers) > _MOST_TABLES:
        problem = sheet.place(headers[0][0]).error(
            f"the column names are repeated {len(headers)} times; the sheet was left out.",
            f"at most {_MOST_TABLES} tables on a sheet.",
            "Export the record again, with the names once.",
        )
        return BlockSearch((), (problem,))
    blocks: list[Block] = []
    problems: list[Problem] = []
    free_from = sheet.first_row
    ends = [*(row for row, _ in headers[1:]), sheet.last_row + 1]
    for (row, matches), following in zip(headers, ends, strict=True):
        bounds = (free_from, following)
        free_from = 1 + _blocks_of_header(sheet, wanted, row, matches, bounds, blocks, problems)
    return BlockSearch(tuple(blocks), tuple(dict.fromkeys(problems)))


def names_seen(sheet: Sheet, most: int = 12) -> str:
    """Return the texts of the first row with several texts, and what is odd about them."""
    for _, cells in sheet.numbered():
        texts = [shorten(cell, 30) for cell in cells if isinstance(cell, str) and is_text(cell)]
        if len(texts) >= 2:
            texts = list(dict.fromkeys(texts))
            more = f" and {len(texts) - most} more" if len(texts) > most else ""
            odd = odd_letters(texts)
            return ", ".join(f'"{text}"' for text in texts[:most]) + more + (odd and f". {odd}")
    return ""


def _blocks_of_header(  # noqa: PLR0917  one caller
    sheet: Sheet,
    wanted: Wanted,
    row: int,
    matches: Sequence[Match],
    bounds: tuple[int, int],
    blocks: list[Block],
    problems: list[Problem],
) -> int:
    """Add the tables under a row of names, and problems; return the last row of all of them."""
    free_from, following = bounds
    choice = ColumnChoice(sheet, wanted, row, following, matches)
    problems += choice.problems
    if not wanted.is_complete({match.quantity for match in choice.matches}):
        return row
    groups = _side_by_side(sheet, wanted, row, choice.matches, problems)
    for match in choice.matches if groups else ():
        read = groups[0].get(match.quantity, match)
        if all(match not in group.values() for group in groups):
            why = f'{match.quantity.replace("_", " ")} is read from "{shorten(read.text)}"'
            choice.not_used.setdefault(match.index, why)
    thrusters = told_apart([match for match in choice.matches if match.quantity == "thrust"])
    starts = [min(match.index for match in group.values()) for group in groups]
    starts = [0, *starts[1:], sheet.width]
    last_of_all = row
    for number, group in enumerate(groups):
        required = [name for part in wanted.required for name in part if name in group]
        span = _rows_of_data(sheet, row, following, [group[name].index for name in required])
        if span is None:
            problems.append(
                sheet.place(row).warning(
                    "there are column names but no numbers under them.",
                    "numbers under the names.",
                    "Fill the table or delete it.",
                )
            )
            continue
        first, last = span
        low, after = starts[number : number + 2]
        high = after - 1
        rows = HeadRows(free_from, row, first, last)
        columns = read_columns(sheet, wanted, rows, group, problems)
        last_of_all = max(last_of_all, last)
        if not wanted.is_complete(set(columns)):
            continue
        only = rows_wanted(sheet, wanted, row, problems)
        if len(only) < len(wanted.only):
            continue
        above = headings(sheet, max(free_from, row - _HEADING_ROWS), row, low, high)
        above += headings(sheet, row + 1, first, low, high)
        blocks.append(
            Block(
                sheet=sheet,
                columns=columns,
                header_row=row,
                first_row=first,
                last_row=last,
                above=above,
                not_used=choice.not_used,
                thruster=thrusters.get(columns["thrust"].index) if thrusters else None,
                only=only,
                span=(low, high),
            )
        )
    return last_of_all


def _side_by_side(
    sheet: Sheet, wanted: Wanted, row: int, matches: Sequence[Match], problems: list[Problem]
) -> list[dict[str, Match]]:
    """Part the columns into tables where names repeat, and choose a column for each quantity."""
    parts: list[list[Match]] = [[]]
    seen: set[tuple[str, str]] = set()
    for match in sorted(matches, key=lambda match: match.index):
        key = (match.quantity, _without(match.header.name, wanted.split_words))
        if key in seen:
            parts.append([])
            seen = set()
        seen.add(key)
        parts[-1].append(match)
    shared = [match for match in parts[0] if match.quantity in wanted.shared]
    groups = [_best(part) for part in parts]
    for group in groups[1:]:
        for match in shared:
            group.setdefault(match.quantity, match)
    complete = [group for group in groups if wanted.is_complete(set(group))]
    needed = {name for part in wanted.required for name in part}
    repeats = sum(bool(needed & set(group)) for group in groups)
    if repeats >= _GRID and len(complete) <= 1:
        problems.append(
            sheet.place(row).warning(
                f'"{shorten(parts[-1][0].text)}" names {repeats} columns: this looks like a grid '
                "(a map or a fit), not a list of points; it was not read.",
                "one column a quantity, or whole tables side by side.",
                "If it is measured, write it as a list of points; if not, leave it as it is.",
            )
        )
        return []
    return complete or [_best(matches)]


@functools.lru_cache(maxsize=4096)
def _without(name: str, split_words: tuple[str, ...]) -> str:
    text = plain(name)
    for word in split_words:
        text = re.sub(rf"(?<!\w){re.escape(plain(word))}\w*", "", text)
    return " ".join(re.sub(r"[\s_]*\d+$|\s\d{1,2}(?=\s)", "", text.strip()).split())


def _best(matches: Sequence[Match]) -> dict[str, Match]:
    best: dict[str, Match] = {}
    for match in matches:
        if match.quantity not in best or match.score > best[match.quantity].score:
            best[match.quantity] = match
    return best


def _rows_of_data(
    sheet: Sheet, row: int, following: int, needed: Sequence[int]
) -> tuple[int, int] | None:
    """Return the first and last row under the names with numbers in the columns that are needed."""

    def count(at: int) -> int:
        return sum(is_number(sheet.cell(at, one)) for one in needed)

    first = next((at for at in range(row + 1, following) if count(at)), None)
    if first is None:
        return None
    last = following - 1
    if following <= sheet.last_row:  # what stands over the next table belongs to that one
        own = range(last, first, -1)
        last = next((at for at in own if count(at) > len(needed) // 2), first)
    # those right before it whose cells are numbers with something added are readings, too
    while first - 1 > row and are_spoilt([sheet.cell(first - 1, one) for one in needed]):
        first -= 1
    return first, last


def odd_letters(texts: Iterable[str]) -> str:
    """Say in one sentence what is odd about the letters of headings; empty where nothing is.

    >>> odd_letters(["\u0441ode", "thrust (N)"])
    'In "\u0441ode" Cyrillic letters (\u0441) stand among Latin ones'
    >>> odd_letters(["код", "тяга, Н", "thrust (N)"])
    ''
    """
    texts = list(texts)
    for text in texts:
        for word in _WORD.findall(text):
            latin, cyrillic = _LATIN.findall(word), _CYRILLIC.findall(word)
            if cyrillic and len(latin) >= len(cyrillic):
                few = "".join(dict.fromkeys(cyrillic))
                return f'In "{word}" Cyrillic letters ({few}) stand among Latin ones'
            if latin and cyrillic:
                few = "".join(dict.fromkeys(latin))
                return f'In "{word}" Latin letters ({few}) stand among Cyrillic ones'
    for encoding in _OLD_ENCODINGS:
        read = [_read_as(text, encoding) for text in texts]
        if sum(map(_lower_cyrillic, read)) > sum(map(_lower_cyrillic, texts)):
            shown = ", ".join(f'"{text}"' for text in read[:4])
            name = encoding.replace("_", "-").upper()
            return f"In the encoding {name} they would be {shown}: save the file as UTF-8"
    return ""


def _read_as(text: str, encoding: str) -> str:
    with suppress(UnicodeError):
        return text.encode("cp1251").decode(encoding)
    return text


def _lower_cyrillic(text: str) -> int:
    """Count the small Cyrillic letters of words; of those read in a wrong encoding few are."""
    words = (word for word in _WORD.findall(text) if len(word) > 1)
    return sum("а" <= letter <= "я" for word in words for letter in word)
