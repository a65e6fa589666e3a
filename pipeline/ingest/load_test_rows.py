"""Rows of one load-test table: numbers, code, branch and what the rows say about themselves."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime

from pipeline.errors import Problem
from pipeline.ingest.bench_file import COMMENTED, is_spoilt, row_numbers
from pipeline.ingest.blocks import Block, is_commented, without_comment_mark
from pipeline.ingest.cells import NotANumberError, column_letter, is_number, parse_number
from pipeline.ingest.code_units import command_scale, percent_note
from pipeline.ingest.load_test_words import (
    Branch,
    branch_in_text,
    code_in_text,
    is_code_label,
    is_warm_up,
)
from pipeline.ingest.mooring_codes import code_from_pwm
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.sheet import Row
from pipeline.ingest.statistics_rows import STATISTICS, is_statistics, statistics_problems
from pipeline.vehicle.bench_schema import Pwm

OPTIONAL = ("current", "voltage", "input_power", "output_power")
_MOST_MESSAGES = 5
_DAY_S = 86_400.0
_CLOCK = re.compile(r"(?:(\d{4}-\d\d-\d\d)[ T])?(\d{1,2}):(\d\d)(?::(\d\d(?:[.,]\d+)?))?")


@dataclass(frozen=True)
class LoadTestReading:
    """One row in the units of the records; `values` holds the optional quantities that it has."""

    row: int
    code: float | None
    shaft_speed_rpm: float
    torque_nm: float
    values: Mapping[str, float]
    time_s: float | None
    branch: Branch | None
    marks: tuple[str, ...] = ()


@dataclass
class _State:
    """What section headings within the table said last."""

    code: float | None
    branch: Branch | None
    code_max: int
    pwm: Pwm
    warm_up: bool = False
    percent_from: int | None = None
    """First row of a heading with a code in per cent."""


@dataclass
class _Log:
    """What was wrong with the rows, by column."""

    not_numbers: dict[str, list[tuple[int, str]]] = field(default_factory=dict)
    incomplete: dict[str, list[int]] = field(default_factory=dict)
    odd_branches: list[int] = field(default_factory=list)
    codeless: list[int] = field(default_factory=list)
    statistics: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class RowsRead:
    """The readings of a table and the problems with its rows."""

    readings: tuple[LoadTestReading, ...]
    problems: tuple[Problem, ...]
    in_shares: bool = False
    """Whether the code column counts per cent or shares of full throttle."""


def read_rows(
    block: Block,
    code: float | None,
    branch: Branch | None,
    scale: tuple[int, Pwm],
    warm_up_s: float | None,
) -> RowsRead:
    """Read the rows of a table.

    Parameters
    ----------
    block : Block
        The table.
    code : float or None
        Control code of the whole table, where it has no code column.
    branch : str or None
        Branch of the whole table, where a heading or the sheet's name states it.
    scale : tuple of (int, Pwm)
        Code at full command, for codes in per cent, and the range of pulse widths.
    warm_up_s : float or None
        Rows before this time are warm-up. [s]

    Returns
    -------
    RowsRead
        Readings in the order of the rows, and problems.
    """
    code_max, pwm = scale
    state, log = _State(code, branch, code_max, pwm), _Log()
    readings: list[LoadTestReading] = []
    for row, cells in block.rows():
        reading = _read_row(block, row, cells, state, log)
        if reading is not None:
            readings.append(reading)
    problems = [*_number_problems(block, log), *_row_problems(block, log)]
    problems += statistics_problems(block, log.statistics)
    codes = [one.code for one in readings if one.code is not None and not one.marks]
    worth = command_scale(block, codes, code_max, problems)
    if worth != 1.0:
        readings = [_scaled(reading, worth) for reading in readings]
    if state.percent_from is not None:
        problems.append(percent_note(block.place(state.percent_from), code_max))
    if warm_up_s is not None:
        readings = _mark_early(readings, warm_up_s)
    return RowsRead(tuple(readings), tuple(problems), worth != 1.0)


def _read_row(
    block: Block, row: int, cells: Row, state: _State, log: _Log
) -> LoadTestReading | None:
    commented = is_commented(cells)
    spoilt = is_spoilt(block, cells, ("shaft_speed", "torque"))
    if not commented and not spoilt and _is_section(block, row, cells, state):
        return None
    given = without_comment_mark(cells) if commented else cells
    values, wrong = row_numbers(
        block, row, given, ("shaft_speed", "torque", "code", "pwm", *OPTIONAL)
    )
    sums_up = not commented and is_statistics(block, cells)
    if not commented and not sums_up:
        _note_faults(block, row, values, wrong, log)
    if "shaft_speed" not in values or "torque" not in values:
        return None
    if "code" in block.columns and "code" not in values:
        return None
    if "pwm" in values and "code" not in values:
        values["code"] = round(code_from_pwm(values["pwm"], state.pwm, state.code_max), 9)
    marks: tuple[str, ...] = (COMMENTED,) if commented else ()
    if sums_up:
        marks = (STATISTICS,)
        log.statistics.append(row)
    status = block.text(cells, "status")
    if state.warm_up or (status is not None and is_warm_up(status)):
        marks += ("warm-up",)
    return LoadTestReading(
        row=row,
        code=values.get("code", state.code),
        shaft_speed_rpm=values["shaft_speed"],
        torque_nm=values["torque"],
        values={name: values[name] for name in OPTIONAL if name in values},
        time_s=_time(block, cells),
        branch=_branch(block, row, cells, state, log),
        marks=marks,
    )


def _note_faults(
    block: Block, row: int, values: Mapping[str, float], wrong: Mapping[str, str], log: _Log
) -> None:
    for quantity, reason in wrong.items():
        log.not_numbers.setdefault(quantity, []).append((row, reason))
    missing = [name for name in ("shaft_speed", "torque") if name not in values]
    # A code in merged cells goes on over the blank rows under a table.
    if wrong or not set(values) - {"code", "pwm"}:
        return
    for name in missing:
        log.incomplete.setdefault(name, []).append(row)
    if not missing and "code" in block.columns and "code" not in values:
        log.codeless.append(row)


def _is_section(block: Block, row: int, cells: Row, state: _State) -> bool:
    """Take in a heading between the rows ("Code: 100", "Unloading"); True where it was one."""
    speed = block.columns["shaft_speed"].index
    if speed < len(cells) and is_number(cells[speed]):
        return False
    low, high = block.span
    inside = cells[low : high + 1]
    for index, cell in enumerate(inside):
        if not isinstance(cell, str):
            continue
        code = code_in_text(cell)
        if code is not None:
            if code.percent and state.percent_from is None:
                state.percent_from = row
            state.code, state.branch, state.warm_up = code.in_codes(state.code_max), None, False
            return True
        following = inside[index + 1] if index + 1 < len(inside) else None
        if is_code_label(cell) and is_number(following):
            state.code, state.branch, state.warm_up = parse_number(following), None, False
            return True
    text = block.section_text(cells)
    if text is None:
        return False
    branch = branch_in_text(text)
    if is_warm_up(text):
        state.warm_up = True
    elif branch is not None:
        state.branch, state.warm_up = branch, False
    # A row of text alone is a remark; a word in place of a number has numbers beside it.
    return True


def _branch(block: Block, row: int, cells: Row, state: _State, log: _Log) -> Branch | None:
    for quantity in ("branch", "status"):
        text = block.text(cells, quantity)
        if text is None:
            continue
        branch = branch_in_text(text)
        if branch is not None:
            return branch
        if quantity == "branch":
            log.odd_branches.append(row)
    return state.branch


def _time(block: Block, cells: Row) -> float | None:
    column = block.columns.get("time")
    if column is None or column.index >= len(cells):
        return None
    cell = cells[column.index]
    try:
        return column.value(cell)
    except NotANumberError:
        clock = _CLOCK.search(str(cell))
    if clock is None:
        return None
    try:
        day = datetime.fromisoformat(clock[1]).toordinal() if clock[1] else 0
    except ValueError:
        return None  # of a logger whose clock was not set, e.g. 0000-00-00
    seconds = float((clock[4] or "0").replace(",", "."))
    return day * _DAY_S + int(clock[2]) * 3600.0 + int(clock[3]) * 60.0 + seconds


def _scaled(reading: LoadTestReading, scale: float) -> LoadTestReading:
    code = None if reading.code is None else reading.code * scale
    return replace(reading, code=code)


def _mark_early(readings: list[LoadTestReading], warm_up_s: float) -> list[LoadTestReading]:
    """Mark the rows before `warm_up_s`, counted from the first time of the table."""
    times = [reading.time_s for reading in readings if reading.time_s is not None]
    if not times:
        return readings
    # A clock time starts somewhere in the day; a running time may start above zero on purpose.
    by_clock = times[0] > 10.0 * max(warm_up_s, 60.0)
    start = times[0] if by_clock else 0.0

    def is_early(time_s: float) -> bool:
        since_s = time_s - start
        if by_clock and since_s < 0.0:
            since_s += _DAY_S  # midnight has passed
        return since_s < warm_up_s

    return [
        with_mark(reading, "warm-up")
        if reading.time_s is not None and is_early(reading.time_s)
        else reading
        for reading in readings
    ]


def with_mark(reading: LoadTestReading, mark: str) -> LoadTestReading:
    """Return the reading with one more mark."""
    return reading if mark in reading.marks else replace(reading, marks=(*reading.marks, mark))


def _number_problems(block: Block, log: _Log) -> list[Problem]:
    problems: list[Problem] = []
    for quantity, faults in log.not_numbers.items():
        column = block.columns[quantity]
        name = quantity.replace("_", " ")
        optional = quantity in OPTIONAL
        what_is_lost = "The row is kept without it." if optional else "The row was left out."
        for row, reason in faults[:_MOST_MESSAGES]:
            problems.append(
                Problem(
                    "warning",
                    block.place(row, quantity),
                    f"{name} {reason}. {what_is_lost}",
                    f"a decimal number (point or comma) in {column.unit_stated()}."
                    if column.unit
                    else "a decimal number (point or comma).",
                    'Fix the cell, or mark the row with "#" in column '
                    f"{column_letter(block.span[0])} to leave it out.",
                )
            )
        rest = [row for row, _ in faults[_MOST_MESSAGES:]]
        if rest:
            problems.append(
                Problem(
                    "warning",
                    block.place(rest[0], quantity),
                    f"{name} is not a number in {len(rest)} more rows ({listed(rest)}). "
                    f"{'They are kept without it.' if optional else 'They were left out.'}",
                    "decimal numbers (point or comma).",
                    "Fix the cells.",
                )
            )
    return problems


def _row_problems(block: Block, log: _Log) -> list[Problem]:
    problems = [
        Problem(
            "warning",
            block.place(rows[0], quantity),
            f"no {quantity.replace('_', ' ')} in {counted(len(rows), 'row')}, left out "
            f"({listed(rows)}).",
            "speed and torque in every row.",
            "Fill the cells or delete the rows.",
        )
        for quantity, rows in log.incomplete.items()
    ]
    if log.codeless:
        rows = log.codeless
        problems.append(
            Problem(
                "warning",
                block.place(rows[0], "code"),
                f"no control code in {counted(len(rows), 'row')}, left out ({listed(rows)}).",
                "the code in every row, or in merged cells.",
                "Fill the column.",
            )
        )
    if log.odd_branches:
        rows = log.odd_branches
        problems.append(
            Problem(
                "note",
                block.place(rows[0], "branch"),
                f"the branch is neither loading nor unloading in {listed(rows)}; it was told from "
                "the torque.",
                '"loading" or "unloading".',
            )
        )
    return problems
