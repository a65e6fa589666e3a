"""Rows of a bench table as readings: numbers by quantity, and what is wrong with other cells."""

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Literal

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Reading
from pipeline.ingest.blocks import Block, is_commented, without_comment_mark
from pipeline.ingest.cells import NotANumberError, Row, are_spoilt, shorten
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.vocabulary import plain, words_of

COMMENTED, STATISTICS = "commented out", "statistics row"
#: In the units of the records (N, N m, rpm, us ...); keeps every later product finite, too.
_LARGEST = 1e9
#: What a person sets on a bench; it may hold for several rows.
_SET = frozenset({"code", "pwm", "voltage", "advance_ratio", "speed", "time"})
_COMMAND = ("code", "pwm")
_WORDS = frozenset({"branch", "status"})
#: Words of rows that sum up a table, such as its mean and spread; and those that others say, too.
_SUMS, _OF_READINGS = (
    frozenset(map(plain, words_of("groups", name))) for name in ("statistics", "of_readings")
)
#: Rows that sum up a table stand under it; fewer rows need none; how far they are rounded.
_MOST_SUMS, _LEAST_SUMMED, _ROUNDED = 4, 5, 2e-3
_MOST_NAMED = 8
_DAY_S = 86_400.0
_CLOCK = re.compile(r"(?:(\d{4}-\d\d-\d\d)[ T])?(\d{1,2}):(\d\d)(?::(\d\d(?:[.,]\d+)?))?")


def readings_of(
    block: Block, wanted: Wanted, headings: Collection[int], problems: list[Problem]
) -> list[Reading]:
    """Read the rows of a table; rows without any required number are headings or blank."""
    readings: list[Reading] = []
    odd: dict[str, list[tuple[int, str]]] = defaultdict(list)
    empty: dict[str, list[int]] = defaultdict(list)
    marked: dict[str, list[int]] = defaultdict(list)
    seen: set[str] = set()
    required = wanted.required
    if not block.columns.keys().isdisjoint(_COMMAND):  # a table that has commands has one a row
        required = tuple(dict.fromkeys((_COMMAND, *required)))
    given_once, held = _given_once(block), dict[str, float]()
    for row, cells in block.rows():
        if row in headings:
            held = {}
            continue
        mark = _mark(block, cells)
        commented = mark == COMMENTED
        given = without_comment_mark(cells) if commented else cells
        values, faults = _row_numbers(block, row, given)
        held |= {name: values[name] for name in given_once & values.keys()}
        values |= {name: one for name, one in held.items() if values and name not in faults}
        # a code in merged cells goes on over the blank rows under a table
        is_bare = all(block.is_merged_over(row, quantity) for quantity in values)
        if is_bare and (commented or not is_spoilt(block, cells, faults)):
            continue  # a heading, a note or a blank row
        seen |= set(values)
        complete = all(any(name in values for name in group) for group in required)
        if complete:
            readings.append(Reading(row, values, (mark,) if mark else ()))
        if mark:
            marked[mark] += [row] if complete or mark == STATISTICS else []
            continue
        for quantity, fault in faults.items():
            odd[quantity].append((row, fault))
        for quantity in _absent(block, required, values, faults) if values else ():
            empty[quantity].append(row)
    marked[STATISTICS] += _mark_sums(readings)
    if next(block.rows(), None) is not None:  # else no row has the text that vehicle.yaml asks for
        problems += [*_faults(block, wanted, odd, empty, seen), *_marked_rows(block, marked)]
    return readings


def _given_once(block: Block) -> set[str]:
    """Return the commands that stand in the first of several rows each, blank in the others."""
    found = set()
    for name in block.columns.keys() & {*_COMMAND}:
        others = [one for one in block.columns if one not in {*_COMMAND, *_WORDS}]
        there = [
            block.text(cells, name) is not None
            for _, cells in block.rows()
            if any(block.text(cells, one) is not None for one in others)
        ]
        if there and there[0] and 1 < sum(there) <= len(there) // 2:
            found.add(name)
    return found


def _absent(
    block: Block, required: Sequence[Sequence[str]], values: Iterable[str], faults: Iterable[str]
) -> list[str]:
    """Return a required quantity of each group of which a row has nothing, be it at fault."""
    there = {*values, *faults}
    if all(any(name in values for name in group) for group in required):
        return []
    groups = [[name for name in group if name in block.columns] for group in required]
    return [group[0] for group in groups if group and not there & set(group)]


def _marked_rows(block: Block, marked: Mapping[str, Sequence[int]]) -> Iterator[Problem]:
    """Say which rows are kept but not fitted: commented out, or summing up the others."""
    if rows := marked.get(COMMENTED):
        what = f'commented out with "#": {listed(rows)}; kept but not fitted.'
        yield block.place(rows[0]).note(what)
    if rows := marked.get(STATISTICS):
        what = (
            f"{counted(len(rows), 'row')} of means, spreads or sums ({listed(rows)}); kept but not "
            "fitted."
        )
        remedy = 'Delete them, or mark them with "#" in column A.'
        yield block.place(rows[0]).warning(what, "readings alone.", remedy)


def _mark(block: Block, cells: Row) -> str:
    """Return the mark of a row in which a cell says that it is no reading; empty of others."""
    if is_commented(cells):
        return COMMENTED
    low, high = block.span
    inside = [cell for cell in cells[low : high + 1] if cell is not None]
    words = [plain(cell) if isinstance(cell, str) else "" for cell in inside]
    return STATISTICS if words and _SUMS & {words[0], *{*words[1:]} - _OF_READINGS} else ""


def _mark_sums(readings: list[Reading]) -> Iterator[int]:
    """Mark the rows that sum up a table under it, whatever they are called; yield their numbers."""
    for at in range(max(len(readings) - _MOST_SUMS, 0), len(readings)):
        if not readings[at].marks and _sums_up(readings[:at], readings[at].values):
            readings[at] = readings[at].marked(STATISTICS)
            yield readings[at].row


def _sums_up(above: Sequence[Reading], values: Mapping[str, float]) -> bool:
    """Tell whether a row is the mean, the spread or the sum of all above it.

    Two numbers at least say so, and none denies it; a reading of nothing is like any mean of 0.
    """
    live = [one.values for one in above if not one.marks]
    if len(live) < _LEAST_SUMMED:
        return False
    columns = {name: [one.get(name, np.nan) for one in live] for name in values}
    varied = {name: np.array(own) for name, own in columns.items() if len({*own}) > 1}
    for summed_up in (np.mean, np.std, np.sum):
        whole = {name: float(summed_up(own)) for name, own in varied.items()}
        close = [
            abs(values[name] - one) <= _ROUNDED * abs(one) for name, one in whole.items() if one
        ]
        if len(close) > 1 and all(close):
            return True
    return False


def is_spoilt(block: Block, cells: Row, faults: Iterable[str]) -> bool:
    """Tell whether a row without a number was one of numbers, by the cells that are at fault."""
    columns = [block.columns[quantity].index for quantity in faults]
    return are_spoilt([cells[index] for index in columns if index < len(cells)])


def _row_numbers(block: Block, row: int, cells: Row) -> tuple[dict[str, float], dict[str, str]]:
    """Return the numbers of a row by quantity, and what is wrong with the other cells.

    What is set may stand in cells merged over several rows; what is measured is one reading, of
    the first of them.
    """
    values: dict[str, float] = {}
    faults: dict[str, str] = {}
    # in a towing tank the shaft speed is set, too
    held = _SET | {"shaft_speed"} if "speed" in block.columns else _SET
    for quantity in block.columns:
        if quantity in _WORDS:
            continue
        try:
            value = block.value(cells, quantity)
        except NotANumberError as error:
            value = None
            if quantity == "time":  # a clock that was not set is no fault
                value = _clock_s(block.text(cells, quantity) or "")
            else:
                faults[quantity] = str(error)
        if value is None:
            continue
        if quantity not in held and block.is_merged_over(row, quantity):
            faults[quantity] = "stands in a cell that is merged with the one above"
        elif abs(value) > _LARGEST and quantity != "time":
            faults[quantity] = f"{value:.3g} is beyond anything a bench measures"
        else:
            values[quantity] = value
    return values, faults


def _clock_s(text: str) -> float | None:
    """Return the seconds of a clock, of a date since the year 1; None where it was not set."""
    clock = _CLOCK.search(text)
    if clock is None:
        return None
    try:
        day = datetime.fromisoformat(clock[1]).toordinal() if clock[1] else 0
    except ValueError:
        return None  # e.g. 0000-00-00
    seconds = float((clock[4] or "0").replace(",", "."))
    return day * _DAY_S + int(clock[2]) * 3600.0 + int(clock[3]) * 60.0 + seconds


def _faults(
    block: Block,
    wanted: Wanted,
    odd: Mapping[str, Sequence[tuple[int, str]]],
    empty: Mapping[str, Sequence[int]],
    seen: set[str],
) -> Iterator[Problem]:

    for quantity, column in block.columns.items():
        if quantity in seen or quantity in _WORDS or quantity == "time":
            continue
        needed = any(
            quantity in group and not seen.intersection(group) for group in wanted.required
        )
        left_out = "the table was left out" if needed else "the column was left out"
        of_cells = odd[quantity][0][1] if odd.get(quantity) else _formulas(block, quantity)
        why = f" ({of_cells})" if of_cells else ""
        # a column that may be left away may be left blank, too
        optional: Literal["note", "warning"] = "note" if block.is_blank(quantity) else "warning"
        yield Problem(
            "error" if needed else optional,
            block.place(block.header_row, quantity),
            f'{_name(quantity)} "{shorten(column.header)}" holds no number at all{why}; '
            f"{left_out}.",
            "decimal numbers.",
            "Export the file again; formulas need their stored results.",
        )
    for quantity, faults in odd.items():
        if quantity not in seen:
            continue
        rows = [row for row, _ in faults]
        many = f" ({listed(rows)})" if len(rows) > 1 else ""
        left_out = "The rest of the row was read."
        if any(quantity in group for group in wanted.required):
            left_out = "The row was left out." if len(rows) == 1 else "The rows were left out."
        yield block.place(rows[0], quantity).warning(
            f"{_name(quantity)} {faults[0][1]}{many}. {left_out}",
            f"a decimal number (point or comma), {block.columns[quantity].unit_stated()}.",
            'Fix the cell, or mark the row with "#" in column A to leave it out.',
        )
    for quantity, blank in empty.items():
        if quantity not in seen:
            continue
        of_cells = _formulas(block, quantity)
        why = f" {of_cells}." if of_cells else ""
        yield block.place(blank[0], quantity).warning(
            f"{_name(quantity)} is empty in {listed(blank)}; left out.{why}",
            "a decimal number.",
            'Fill the cell, or mark the row with "#" in column A.',
        )


def _formulas(block: Block, quantity: str) -> str:
    """Say which cells of a column hold a formula that was never calculated, if any."""
    column = block.columns[quantity]
    rows = [row for row, _ in block.rows() if (row, column.index) in block.sheet.formulas]
    more = f" and {len(rows) - _MOST_NAMED} more" if len(rows) > _MOST_NAMED else ""
    named = ", ".join(f"{column.letter}{row}" for row in rows[:_MOST_NAMED])
    return f"{len(rows)} formula cell(s) hold no stored value: {named}{more}" if rows else ""


def _name(quantity: str) -> str:
    return quantity.replace("_", " ")
