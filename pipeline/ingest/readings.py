"""Rows of a bench table as readings: numbers by quantity, and what is wrong with other cells."""

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block, is_commented, without_comment_mark
from pipeline.ingest.cells import NotANumberError, are_spoilt, shorten
from pipeline.ingest.headers import Wanted
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.sheet import Row
from pipeline.ingest.vocabulary import plain, words_of

COMMENTED, STATISTICS = "commented out", "statistics row"
#: In the units of the records (N, N m, rpm, us ...); keeps every later product finite, too.
_LARGEST = 1e9
#: What a person sets on a bench; it may hold for several rows.
_SET = frozenset({"code", "pwm", "voltage", "advance_ratio", "speed", "time"})
_COMMAND = ("code", "pwm")
_WORDS = frozenset({"branch", "status"})
#: Words of rows that sum up a table, such as its mean and spread.
_SUMS = frozenset(map(plain, words_of("groups", "statistics")))
_DAY_S = 86_400.0
_CLOCK = re.compile(r"(?:(\d{4}-\d\d-\d\d)[ T])?(\d{1,2}):(\d\d)(?::(\d\d(?:[.,]\d+)?))?")


@dataclass(frozen=True)
class Reading:
    """One row: numbers by quantity, in the units of the records, signs of the mapping applied."""

    row: int
    values: Mapping[str, float]
    marks: tuple[str, ...] = ()
    branch: Literal["loading", "unloading"] | None = None

    @property
    def is_zero(self) -> bool:
        """Whether it is of a command of 0 and counts: a reading of the tare."""
        return not self.marks and self.values.get("code") == 0.0

    def marked(self, *marks: str) -> "Reading":
        """Return the reading with more marks, each once."""
        both = tuple(dict.fromkeys((*self.marks, *marks)))
        return Reading(self.row, self.values, both, self.branch)

    def with_values(self, **values: float) -> "Reading":
        """Return the reading with other numbers; adding 0.0 turns -0.0 into 0.0."""
        given = {name: value + 0.0 for name, value in values.items()}
        return Reading(self.row, {**self.values, **given}, self.marks, self.branch)


def readings_of(
    block: Block, wanted: Wanted, headings: Collection[int]
) -> tuple[tuple[Reading, ...], list[Problem]]:
    """Read the rows of a table; rows without any required number are headings or blank."""
    readings: list[Reading] = []
    odd: dict[str, list[tuple[int, str]]] = defaultdict(list)
    empty: dict[str, list[int]] = defaultdict(list)
    statistics: list[int] = []
    seen: set[str] = set()
    rows = list(block.rows())
    if not rows:
        return (), []  # no row has the texts that vehicle.yaml asks for
    required = wanted.required
    if not block.columns.keys().isdisjoint(_COMMAND):  # a table that has commands has one a row
        required = tuple(dict.fromkeys((_COMMAND, *required)))
    for row, cells in (one for one in rows if one[0] not in headings):
        commented = is_commented(cells)
        given = without_comment_mark(cells) if commented else cells
        values, faults = row_numbers(block, row, given, block.columns)
        # a code in merged cells goes on over the blank rows under a table
        is_bare = all(block.is_merged_over(row, quantity) for quantity in values)
        if is_bare and (commented or not is_spoilt(block, cells, faults)):
            continue  # a heading, a note or a blank row
        seen |= set(values)
        complete = all(any(name in values for name in group) for group in required)
        sums_up = not commented and _is_statistics(block, cells)
        marks = (COMMENTED,) * commented + (STATISTICS,) * sums_up
        statistics += [row] * sums_up
        if complete:
            readings.append(Reading(row, values, marks))
        if marks:
            continue
        for quantity, fault in faults.items():
            odd[quantity].append((row, fault))
        if values and not complete:
            for quantity in _absent(block, required, values.keys() | faults.keys()):
                empty[quantity].append(row)
    problems = _faults(block, wanted, odd, empty, seen)
    problems += [*_commented_out(block, readings), *_statistics_problems(block, statistics)]
    return tuple(readings), problems


def _commented_out(block: Block, readings: Sequence[Reading]) -> list[Problem]:
    rows = [one.row for one in readings if COMMENTED in one.marks]
    if not rows:
        return []
    what = f'commented out with "#": {listed(rows)}; kept but not fitted.'
    return [Problem("note", block.place(rows[0]), what)]


def _is_statistics(block: Block, cells: Row) -> bool:
    """Tell whether the first filled cell of a row within the table is a word such as "mean"."""
    low, high = block.span
    first = next((cell for cell in cells[low : high + 1] if cell is not None), None)
    return isinstance(first, str) and plain(first) in _SUMS


def _statistics_problems(block: Block, rows: Sequence[int]) -> list[Problem]:
    """Warn of the rows that were left out because they only sum up the others."""
    if not rows:
        return []
    what = (
        f"{counted(len(rows), 'row')} of means, spreads or sums ({listed(rows)}); kept but not "
        "fitted."
    )
    remedy = 'Delete them, or mark them with "#" in column A.'
    return [Problem("warning", block.place(rows[0]), what, "readings alone.", remedy)]


def is_spoilt(block: Block, cells: Row, faults: Iterable[str]) -> bool:
    """Tell whether a row without a number was one of numbers, by the cells that are at fault."""
    columns = [block.columns[quantity].index for quantity in faults]
    return are_spoilt([cells[index] for index in columns if index < len(cells)])


def row_numbers(
    block: Block, row: int, cells: Row, quantities: Iterable[str]
) -> tuple[dict[str, float], dict[str, str]]:
    """Return the numbers of a row by quantity, and what is wrong with the other cells.

    What is set may stand in cells merged over several rows; what is measured is one reading, of
    the first of them.
    """
    values: dict[str, float] = {}
    faults: dict[str, str] = {}
    # in a towing tank the shaft speed is set, too
    held = _SET | {"shaft_speed"} if "speed" in block.columns else _SET
    for quantity in quantities:
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


def _absent(block: Block, required: Sequence[Sequence[str]], there: AbstractSet[str]) -> list[str]:
    """Return a required quantity of each group of which nothing is there."""
    groups = [[name for name in group if name in block.columns] for group in required]
    return [group[0] for group in groups if group and not there & set(group)]


def _faults(
    block: Block,
    wanted: Wanted,
    odd: Mapping[str, Sequence[tuple[int, str]]],
    empty: Mapping[str, Sequence[int]],
    seen: set[str],
) -> list[Problem]:
    problems: list[Problem] = []
    for quantity, column in block.columns.items():
        if quantity in seen or quantity in _WORDS or quantity == "time":
            continue
        needed = any(
            quantity in group and not seen.intersection(group) for group in wanted.required
        )
        left_out = "the table was left out" if needed else "the column was left out"
        why = f" ({odd[quantity][0][1]})" if odd.get(quantity) else ""
        # a column that may be left away may be left blank, too
        optional: Literal["note", "warning"] = "note" if block.is_blank(quantity) else "warning"
        problems.append(
            Problem(
                "error" if needed else optional,
                block.place(block.header_row, quantity),
                f'{_name(quantity)} "{shorten(column.header)}" holds no number at all{why}; '
                f"{left_out}.",
                "decimal numbers.",
                "Export the file again; formulas need their stored results.",
            )
        )
    for quantity, faults in odd.items():
        if quantity not in seen:
            continue
        rows = [row for row, _ in faults]
        first = faults[0][1]
        needed = any(quantity in group for group in wanted.required)
        many = f" ({listed(rows)})" if len(rows) > 1 else ""
        left_out = "The rest of the row was read."
        if needed:
            left_out = "The row was left out." if len(rows) == 1 else "The rows were left out."
        problems.append(
            Problem(
                "warning",
                block.place(rows[0], quantity),
                f"{_name(quantity)} {first}{many}. {left_out}",
                f"a decimal number (point or comma), {block.columns[quantity].unit_stated()}.",
                'Fix the cell, or mark the row with "#" in column A to leave it out.',
            )
        )
    for quantity, blank in empty.items():
        if quantity not in seen:
            continue
        problems.append(
            Problem(
                "warning",
                block.place(blank[0], quantity),
                f"{_name(quantity)} is empty in {listed(blank)}; left out.",
                "a decimal number.",
                'Fill the cell, or mark the row with "#" in column A.',
            )
        )
    return problems


def _name(quantity: str) -> str:
    return quantity.replace("_", " ")
