"""Find the tables on a sheet from their column names, in header rows of any depth."""

import functools
import re
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block, BlockColumn, HeadingCell, UnitFrom, is_commented
from pipeline.ingest.cells import column_index, column_letter, is_number, is_text, shorten
from pipeline.ingest.sheet import Sheet
from pipeline.ingest.unit_text import UnitTextError, factor, known_units, quantities_of
from pipeline.ingest.vocabulary import (
    HeaderText,
    Vocabulary,
    Words,
    name_score,
    plain,
    read_unit_cell,
    split_header,
    unit_fits,
    unit_told_by_name,
)
from pipeline.vehicle.schema import Column

_DEPTH = 8
"""Rows between the names and the first number at most."""
_HEADING_ROWS = 12
"""Rows above the names in which headings are looked for."""
_GRID = 4
"""Columns of one required quantity from which a table is a grid."""
_BY_LETTER = re.compile(r"column ([A-Z]{1,3})", re.IGNORECASE)


@dataclass(frozen=True)
class BlockSearch:
    """Tables of one sheet and what was wrong with those that were refused."""

    blocks: tuple[Block, ...]
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class Wanted:
    """What to look for.

    `required`: of each group at least one quantity must be there. `shared`: quantities whose
    column to the left of several tables side by side belongs to all of them. `mapping`: columns as
    vehicle.yaml states them. `kind` names the section of vehicle.yaml, for messages.
    `split_words` tell columns of tables side by side apart ("n loading", "n unloading").
    """

    vocabulary: Vocabulary
    required: tuple[tuple[str, ...], ...]
    kind: str
    mapping: Mapping[str, Column] = field(default_factory=dict)
    only: Mapping[str, str] = field(default_factory=dict)
    shared: frozenset[str] = frozenset()
    split_words: tuple[str, ...] = ()

    def is_complete(self, quantities: "set[str] | frozenset[str]") -> bool:
        """Tell whether every required group is there."""
        return all(any(name in quantities for name in group) for group in self.required)


@dataclass(frozen=True)
class _Match:
    """One column that may hold one quantity."""

    quantity: str
    index: int
    score: int
    header: HeaderText
    text: str
    last_row: int
    """Lowest row that the name takes."""


def find_blocks(sheet: Sheet, wanted: Wanted) -> BlockSearch:
    """Find every table on a sheet that has the required columns.

    Parameters
    ----------
    sheet : Sheet
        The sheet.
    wanted : Wanted
        Quantities, their names and what vehicle.yaml states about them.

    Returns
    -------
    BlockSearch
        The tables, top to bottom and left to right, and problems: a required unit that is not
        stated, a stated column that is not there, a header without data.
    """
    by_letter = {name: column for name, column in wanted.mapping.items() if _letter(column)}
    if by_letter and wanted.is_complete(set(by_letter)):
        return _blocks_by_letter(sheet, wanted, by_letter)
    blocks: list[Block] = []
    problems: list[Problem] = []
    row = sheet.first_row
    free_from = sheet.first_row
    headers = _header_rows(sheet, wanted)
    for position, (row, matches) in enumerate(headers):
        following = headers[position + 1][0] if position + 1 < len(headers) else sheet.last_row + 1
        found, wrong, last = _blocks_of_header(sheet, wanted, row, matches, (free_from, following))
        blocks += found
        problems += wrong
        free_from = last + 1
    if not headers:
        problems += _missing_mapped(sheet, wanted) or _misfits(sheet, wanted)
    return BlockSearch(tuple(blocks), tuple(dict.fromkeys(problems)))


def names_seen(sheet: Sheet, most: int = 12) -> str:
    """Return the texts of the first row with several texts, for a message."""
    for _, cells in sheet.numbered():
        texts = [shorten(cell, 30) for cell in cells if isinstance(cell, str) and is_text(cell)]
        if len(texts) >= 2:
            texts = list(dict.fromkeys(texts))
            more = f" and {len(texts) - most} more" if len(texts) > most else ""
            return ", ".join(f'"{text}"' for text in texts[:most]) + more
    return ""


# --- rows with names -----------------------------------------------------------------------------


def _header_rows(sheet: Sheet, wanted: Wanted) -> list[tuple[int, list[_Match]]]:
    """Return (row, matches) of every row of names, best of each group of neighbours."""
    candidates: list[tuple[int, int, list[_Match]]] = []
    for row, cells in sheet.numbered():
        if sum(isinstance(cell, str) for cell in cells) == 0:
            continue
        own = _matches_in_row(sheet, wanted, row)
        if not own:
            continue
        all_matches = own + _stacked_matches(sheet, wanted, row, own)
        if wanted.is_complete({match.quantity for match in all_matches}):
            weight = 100 * len({match.quantity for match in own}) + len(own)
            candidates.append((row, weight, all_matches))
    chosen: list[tuple[int, int, list[_Match]]] = []
    for candidate in candidates:
        near = chosen and not _numbers_between(sheet, wanted, chosen[-1], candidate[0])
        if near and candidate[1] > chosen[-1][1]:
            chosen[-1] = candidate
        elif not near:
            chosen.append(candidate)
    return [(row, matches) for row, _, matches in chosen]


def _matches_in_row(sheet: Sheet, wanted: Wanted, row: int) -> list[_Match]:
    matches: list[_Match] = []
    texts = [cell for cell in sheet.cells(row) if isinstance(cell, str)]
    if len(set(texts)) == 1 and len(texts) > 1 and len(wanted.required) > 1:
        return []  # a title merged over the table
    for index, cell in enumerate(sheet.cells(row)):
        if isinstance(cell, str) and is_text(cell):
            matches += _match(wanted, cell, index, row)
    return matches


def _stacked_matches(sheet: Sheet, wanted: Wanted, row: int, own: Sequence[_Match]) -> list[_Match]:
    """Match columns whose name goes over two or three rows, or stands a row lower."""
    matched = {match.index for match in own}
    found: list[_Match] = []
    width = max(
        (len(sheet.cells(at)) for at in range(row, min(row + 3, sheet.last_row + 1))), default=0
    )
    for index in range(width):
        if index in matched:
            continue
        texts = [sheet.cell(at, index) for at in range(row - 1, row + 3)]
        above, here, below, lowest = (
            text if isinstance(text, str) and is_text(text) else "" for text in texts
        )
        if here and sheet.cell(row - 1, index) == sheet.cell(row, index):
            above = ""  # one merged cell
        tries = [(f"{here} {below}", 1), (f"{above} {here}", 0), (f"{here} {below} {lowest}", 2)]
        if not here:
            tries = [(below, 1)]
        for text, depth in tries:
            matches = _match(wanted, text.strip(), index, row + depth) if text.strip() else []
            if matches:
                found += matches
                break
    return found


def _match(wanted: Wanted, text: str, index: int, row: int) -> list[_Match]:
    """Return the best quantity for a header text, or the one that vehicle.yaml states."""
    for quantity, column in wanted.mapping.items():
        if _is_mapped(column, text):
            header = next((h for h in split_header(text) if h.unit), split_header(text)[0])
            return [_Match(quantity, index, 1000, header, text, row)]
    best: _Match | None = None
    for score, quantity, header in _scores(text, _Vocabulary(wanted.vocabulary), wanted.split_words):
        if quantity in wanted.mapping:
            continue
        if best is None or score > best.score:
            best = _Match(quantity, index, score, header, text, row)
    return [] if best is None else [best]


class _Vocabulary:
    """A vocabulary by identity, so that texts are matched once however often they are repeated."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self.vocabulary = vocabulary

    def __hash__(self) -> int:
        return id(self.vocabulary)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Vocabulary) and other.vocabulary is self.vocabulary


@functools.lru_cache(maxsize=8192)
def _scores(
    text: str, vocabulary: _Vocabulary, split_words: tuple[str, ...]
) -> tuple[tuple[int, str, HeaderText], ...]:
    scores: list[tuple[int, str, HeaderText]] = []
    for header in split_header(text):
        bare = replace(header, name=_strip_words(header.name, split_words))
        for quantity, words in vocabulary.vocabulary.items():
            score = max(name_score(header, words), name_score(bare, words) - 1)
            if score > 0 and (header.unit is None or unit_fits(header.unit, words)):
                scores.append((score + (5 if header.unit else 0), quantity, header))
    return tuple(scores)


def _strip_words(name: str, words: tuple[str, ...]) -> str:
    """Take "loading" and the like out of a name, so that "n loading" is the symbol n."""
    for word in words:
        name = re.sub(rf"(?<!\w){re.escape(word)}(?!\w)", "", name, flags=re.IGNORECASE)
    return name.strip(" ,;:-–()")


def _is_mapped(column: Column, text: str) -> bool:
    wanted = plain(column.header)
    return plain(text) == wanted or any(plain(h.name) == wanted for h in split_header(text))


def _numbers_between(
    sheet: Sheet, wanted: Wanted, header: tuple[int, int, list[_Match]], row: int
) -> bool:
    """Tell whether data stands under a header row before the row."""
    required = {name for group in wanted.required for name in group}
    columns = [match.index for match in header[2] if match.quantity in required]
    return any(
        sum(is_number(sheet.cell(at, column)) for column in columns) > len(columns) // 2
        for at in range(header[0] + 1, row)
    )


# --- tables under one row of names ---------------------------------------------------------------


def _blocks_of_header(
    sheet: Sheet,
    wanted: Wanted,
    row: int,
    matches: Sequence[_Match],
    bounds: tuple[int, int],
) -> tuple[list[Block], list[Problem], int]:
    """Return the tables under a row of names, problems, and their last row."""
    free_from, following = bounds
    groups, problems = _side_by_side(sheet, wanted, row, matches)
    blocks: list[Block] = []
    last_of_all = row
    for number, group in enumerate(groups):
        required = [name for part in wanted.required for name in part if name in group]
        first = _first_data_row(sheet, row, [group[name].index for name in required], following)
        if first is None:
            problems.append(
                Problem(
                    "warning",
                    sheet.place(row),
                    "there are column names but no numbers under them.",
                    f"numbers within {_DEPTH} rows under the names.",
                    "Fill the table or delete it.",
                )
            )
            continue
        # What stands over the next table belongs to that one.
        last = following - 1
        if following <= sheet.last_row:
            last = _end_of_data(sheet, first, following, [group[name].index for name in required])
        low = min(match.index for match in group.values()) if number else 0
        high = (
            min(match.index for match in groups[number + 1].values()) - 1
            if number + 1 < len(groups)
            else max((len(cells) for cells in sheet.rows), default=1) - 1
        )
        columns, wrong = _columns(sheet, wanted, row, first, group, free_from)
        problems += wrong
        last_of_all = max(last_of_all, last)
        if not wanted.is_complete(set(columns)):
            continue
        only, wrong = _only(sheet, wanted, row)
        problems += wrong
        if wrong:
            continue
        above = _headings(sheet, max(free_from, row - _HEADING_ROWS), row, low, high)
        blocks.append(
            Block(
                sheet=sheet,
                columns=columns,
                header_row=row,
                first_row=first,
                last_row=last,
                above=above,
                other_headers=_unread(sheet, row, columns, (low, high)),
                only=only,
                span=(low, high),
            )
        )
    return blocks, problems, last_of_all


def _side_by_side(
    sheet: Sheet, wanted: Wanted, row: int, matches: Sequence[_Match]
) -> tuple[list[dict[str, _Match]], list[Problem]]:
    """Part the columns into tables where names repeat, and choose a column for each quantity."""
    parts: list[list[_Match]] = [[]]
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
    problems: list[Problem] = []
    needed = {name for part in wanted.required for name in part}
    repeats = sum(bool(needed & set(group)) for group in groups)
    if repeats >= _GRID and len(complete) <= 1:
        problems.append(
            Problem(
                "warning",
                sheet.place(row),
                f'"{shorten(parts[-1][0].text)}" names {repeats} columns: this looks like a grid (a '
                "map or a fit), not a list of points; it was not read.",
                "one column a quantity, or whole tables side by side.",
                "If it is measured, write it as a list of points; if not, nothing needs to be done.",
            )
        )
        return [], problems
    if not complete:
        complete = [_best(list(matches))]
    if len(complete) < len(groups):
        repeated = [
            match
            for part, group in zip(parts, groups, strict=True)
            if group not in complete or len(complete) == 1
            for match in part
            if match not in complete[0].values()
        ]
        if repeated:
            names = ", ".join(f'{column_letter(m.index)} "{shorten(m.text)}"' for m in repeated[:6])
            problems.append(
                Problem(
                    "note",
                    sheet.place(row),
                    f"column name repeated; the first column was read and not: {names}.",
                    "one column a quantity, or whole tables side by side.",
                    f"State the header of the right one in vehicle.yaml under columns: "
                    f"{wanted.kind}.",
                )
            )
    return complete, problems


def _without(name: str, split_words: tuple[str, ...]) -> str:
    text = plain(name)
    for word in split_words:
        text = re.sub(rf"(?<!\w){re.escape(plain(word))}\w*", "", text)
    return " ".join(re.sub(r"[\s_]*\d+$", "", text.strip()).split())


def _best(matches: Sequence[_Match]) -> dict[str, _Match]:
    best: dict[str, _Match] = {}
    for match in matches:
        if match.quantity not in best or match.score > best[match.quantity].score:
            best[match.quantity] = match
    return best


def _first_data_row(sheet: Sheet, row: int, columns: Sequence[int], following: int) -> int | None:
    """Return the first row under the names with numbers in most of the required columns."""
    limit = min(following, row + 1 + _DEPTH + 20, sheet.last_row + 1)
    for at in range(row + 1, limit):
        numbers = sum(is_number(sheet.cell(at, column)) for column in columns)
        if numbers > len(columns) // 2 or (numbers and is_commented(sheet.cells(at))):
            return at
    for at in range(row + 1, min(following, sheet.last_row + 1)):
        if any(is_number(sheet.cell(at, column)) for column in columns):
            return at
    return None


def _end_of_data(sheet: Sheet, first: int, following: int, columns: Sequence[int]) -> int:
    """Return the last row of numbers before the next table's headings."""
    for at in range(following - 1, first, -1):
        numbers = sum(is_number(sheet.cell(at, column)) for column in columns)
        if numbers > len(columns) // 2:
            return at
    return first


def _headings(sheet: Sheet, first: int, row: int, low: int, high: int) -> tuple[HeadingCell, ...]:
    cells: list[HeadingCell] = []
    for at in range(first, row):
        for index, cell in enumerate(sheet.cells(at)[low : high + 1], start=low):
            merged = (at, index) in sheet.filled and index > low
            if cell is not None and not merged:
                cells.append(HeadingCell(at, index, cell))
    return tuple(cells)


def _unread(
    sheet: Sheet, row: int, columns: Mapping[str, BlockColumn], span: tuple[int, int]
) -> tuple[str, ...]:
    read = {column.index for column in columns.values()}
    return tuple(
        shorten(cell, 40)
        for index, cell in enumerate(sheet.cells(row))
        if isinstance(cell, str) and index not in read and span[0] <= index <= span[1]
    )


# --- units ---------------------------------------------------------------------------------------


def _columns(
    sheet: Sheet,
    wanted: Wanted,
    row: int,
    first: int,
    group: Mapping[str, _Match],
    free_from: int,
) -> tuple[dict[str, BlockColumn], list[Problem]]:
    columns: dict[str, BlockColumn] = {}
    problems: list[Problem] = []
    for quantity, match in group.items():
        words = wanted.vocabulary[quantity]
        column = BlockColumn(
            quantity=quantity,
            index=match.index,
            header=" ".join(match.text.split()),
            unit="",
            unit_from="assumed",
            unit_row=None,
            factor=1.0,
            sign=1,
            group=_group_text(sheet, row, match.index, free_from),
        )
        stated = wanted.mapping.get(quantity)
        if stated is not None:
            column = replace(column, sign=stated.sign)
        try:
            columns[quantity] = _with_unit(sheet, column, words, match, (row, first), stated)
        except UnitTextError as error:
            others = group.keys() - {quantity}
            problems.append(_unit_problem(column, sheet, wanted, row, str(error), others))
    return columns, problems


def _group_text(sheet: Sheet, row: int, index: int, free_from: int) -> str:
    texts: list[str] = []
    for at in range(max(free_from, row - 3), row):
        cell = sheet.cell(at, index)
        if isinstance(cell, str) and cell not in texts:
            texts.append(cell)
    return " ".join(texts)


def _with_unit(
    sheet: Sheet,
    column: BlockColumn,
    words: Words,
    match: _Match,
    rows: tuple[int, int],
    stated: Column | None,
) -> BlockColumn:
    """Return the column with its unit; raises `UnitTextError` where it is missing or wrong."""
    kind = words.unit_kind
    found = _find_unit(sheet, column.index, words, match, rows, stated)
    if kind is None:
        if found is not None and "ratio" in quantities_of(found[0]):
            unit, unit_from, unit_row = found
            # A code in per cent stays a number of per cent: the reader knows the full scale.
            return replace(column, unit=unit, unit_from=unit_from, unit_row=unit_row)
        return column
    if found is not None:
        unit, unit_from, unit_row = found
        return replace(
            column,
            unit=unit,
            unit_from=unit_from,
            unit_row=unit_row,
            factor=factor(unit, kind),
        )
    odd = match.header.odd_unit
    if odd is not None and words.default_unit is None:
        raise UnitTextError(_unknown(odd, kind))
    told = unit_told_by_name(match.header, words) or words.default_unit
    if told is not None:
        return replace(column, unit=told, unit_from="assumed", factor=factor(told, kind))
    known = ", ".join(known_units(kind))
    raise UnitTextError(f"no unit is stated; known: {known}")


def _unknown(unit: str, kind: str) -> str:
    try:
        factor(unit, kind)
    except UnitTextError as error:
        return str(error)
    return ""


def _find_unit(
    sheet: Sheet,
    index: int,
    words: Words,
    match: _Match,
    rows: tuple[int, int],
    stated: Column | None,
) -> tuple[str, UnitFrom, int | None] | None:
    if stated is not None and stated.unit is not None:
        return stated.unit, "mapping", None
    if match.header.unit is not None:
        return match.header.unit, "header", None
    row, first = rows
    wrong: tuple[str, UnitFrom, int | None] | None = None
    for at in [*range(row + 1, first), row - 1]:
        cell = sheet.cell(at, index)
        if not isinstance(cell, str):
            continue
        unit = read_unit_cell(cell)
        if unit is not None and unit_fits(unit, words):
            return unit, "unit row", at
        if wrong is None and at > row and (unit is not None or _is_unit_row(sheet, at)):
            wrong = (unit or cell.strip(), "unit row", at)
    return wrong


def _is_unit_row(sheet: Sheet, row: int) -> bool:
    texts = [cell for cell in sheet.cells(row) if isinstance(cell, str)]
    units = sum(read_unit_cell(text) is not None for text in texts)
    return units >= max(1, len(texts) // 2)


def _unit_problem(
    column: BlockColumn,
    sheet: Sheet,
    wanted: Wanted,
    row: int,
    why: str,
    others: AbstractSet[str] = frozenset(),
) -> Problem:
    needed = any(column.quantity in group and others.isdisjoint(group) for group in wanted.required)
    name = column.quantity.replace("_", " ")
    left_out = "the table was left out" if needed else "the column was left out"
    return Problem(
        "error" if needed else "warning",
        sheet.place(row, column.letter),
        f'{name} "{shorten(column.header)}": {why}. So {left_out}.',
        "the unit in the header, e.g. [N m], or in the row under it.",
        "Write it there, or state it in vehicle.yaml:\n"
        f"  columns:\n    {wanted.kind}:\n      {column.quantity}: "
        f'{{header: "{shorten(column.header)}", unit: ...}}',
    )


# --- what vehicle.yaml states --------------------------------------------------------------------


def _letter(column: Column) -> str | None:
    found = _BY_LETTER.fullmatch(column.header.strip())
    return found[1].upper() if found else None


def _blocks_by_letter(sheet: Sheet, wanted: Wanted, by_letter: Mapping[str, Column]) -> BlockSearch:
    """Read a table without names: vehicle.yaml states "column A" and so on."""
    problems: list[Problem] = []
    columns: dict[str, BlockColumn] = {}
    for quantity, stated in by_letter.items():
        letter = _letter(stated) or "A"
        column = BlockColumn(
            quantity, column_index(letter), stated.header, "", "mapping", None, 1.0, stated.sign
        )
        kind = wanted.vocabulary[quantity].unit_kind
        try:
            if kind is not None and stated.unit is None:
                raise UnitTextError("no unit is stated in vehicle.yaml")
            if kind is not None and stated.unit is not None:
                column = replace(column, unit=stated.unit, factor=factor(stated.unit, kind))
            columns[quantity] = column
        except UnitTextError as error:
            problems.append(_unit_problem(column, sheet, wanted, sheet.first_row, str(error)))
    required = [c.index for name, c in columns.items() if any(name in g for g in wanted.required)]
    first = next(
        (
            row
            for row, _ in sheet.numbered()
            if all(is_number(sheet.cell(row, i)) for i in required)
        ),
        None,
    )
    if not wanted.is_complete(set(columns)) or first is None:
        return BlockSearch((), tuple(problems))
    above = _headings(sheet, sheet.first_row, first, 0, 10_000)
    return BlockSearch(
        (Block(sheet, columns, first - 1, first, sheet.last_row, above),), tuple(problems)
    )


def _missing_mapped(sheet: Sheet, wanted: Wanted) -> list[Problem]:
    """Say which stated columns are not on a sheet that has names."""
    import difflib

    texts = {
        " ".join(cell.split()): None
        for cells in sheet.rows[:60]
        for cell in cells
        if isinstance(cell, str) and is_text(cell)
    }
    missing = [
        (quantity, column)
        for quantity, column in wanted.mapping.items()
        if _letter(column) is None and not any(_is_mapped(column, text) for text in texts)
    ]
    if not missing or len(texts) < 2:
        return []
    names = {plain(text): text for text in texts}
    problems = []
    for quantity, column in missing:
        close = difflib.get_close_matches(plain(column.header), list(names), n=1, cutoff=0.6)
        hint = f' The nearest is "{shorten(names[close[0]])}".' if close else ""
        problems.append(
            Problem(
                "warning",
                sheet.place(),
                f'there is no column "{column.header}", stated in vehicle.yaml as columns: '
                f"{wanted.kind}: {quantity}.{hint}",
                "the header as it stands on the sheet.",
                "Correct the header in vehicle.yaml, or restrict the sheets with "
                f"columns: {wanted.kind}: sheets: [...].",
            )
        )
    return problems


def _misfits(sheet: Sheet, wanted: Wanted) -> list[Problem]:
    """Say which columns have the right name and a unit of something else."""
    for row, cells in sheet.numbered():
        found: dict[str, tuple[int, int, HeaderText, str]] = {}
        for index, cell in enumerate(cells):
            if not isinstance(cell, str):
                continue
            for header in split_header(cell):
                for quantity, words in wanted.vocabulary.items():
                    score = name_score(header, words)
                    if score > found.get(quantity, (0,))[0]:
                        found[quantity] = (score, index, header, cell)
        if not wanted.is_complete(set(found)):
            continue
        problems: list[Problem] = []
        for group in wanted.required:
            for quantity in group:
                kind = wanted.vocabulary[quantity].unit_kind
                if quantity not in found or kind is None:
                    continue
                _, index, header, text = found[quantity]
                if header.unit is None or unit_fits(header.unit, wanted.vocabulary[quantity]):
                    continue
                column = BlockColumn(quantity, index, text, "", "assumed", None, 1.0, 1)
                why = _unknown(header.unit, kind)
                problems.append(_unit_problem(column, sheet, wanted, row, why))
        if problems:
            return problems
    return []


def _only(
    sheet: Sheet, wanted: Wanted, row: int
) -> tuple[tuple[tuple[int, str], ...], list[Problem]]:
    found: list[tuple[int, str]] = []
    problems: list[Problem] = []
    for header, text in wanted.only.items():
        index = next(
            (
                index
                for index, cell in enumerate(sheet.cells(row))
                if isinstance(cell, str) and _is_mapped(Column(header=header), cell)
            ),
            None,
        )
        if index is None:
            problems.append(
                Problem(
                    "error",
                    sheet.place(row),
                    f'there is no column "{header}", stated in vehicle.yaml as columns: '
                    f"{wanted.kind}: only.",
                    "the header as it stands on the sheet.",
                    "Correct the header in vehicle.yaml.",
                )
            )
        else:
            found.append((index, text))
    return tuple(found), problems


def choose_sheets(
    sheets: Sequence[Sheet], names: tuple[str, ...] | None, kind: str
) -> tuple[tuple[Sheet, ...], tuple[Problem, ...]]:
    """Keep the sheets that vehicle.yaml names; a text file has one table without a name.

    Parameters
    ----------
    sheets : sequence of Sheet
        Of one file.
    names : tuple of str or None
        ``columns: <kind>: sheets`` of vehicle.yaml; None keeps all.
    kind : str
        Section of vehicle.yaml, for messages.

    Returns
    -------
    tuple of (tuple of Sheet, tuple of Problem)
        Kept sheets; a warning where a workbook has none of them.
    """
    if names is None or any(sheet.name is None for sheet in sheets):
        return tuple(sheets), ()
    wanted = {plain(name) for name in names}
    kept = tuple(sheet for sheet in sheets if plain(sheet.name or "") in wanted)
    if kept or not sheets:
        return kept, ()
    problem = Problem(
        "warning",
        replace(sheets[0].place(), sheet=None),
        f"none of the sheets stated in vehicle.yaml is here ({', '.join(names)}).",
        f"one of them; the workbook has {', '.join(str(sheet.name) for sheet in sheets)}.",
        f"Correct columns: {kind}: sheets in vehicle.yaml, or move the file.",
    )
    return (), (problem,)
