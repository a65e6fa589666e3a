"""What words say of a load-test table and of its rows: control code, branch and warm-up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block, is_commented
from pipeline.ingest.cells import is_number, parse_number
from pipeline.ingest.commands import percent_note
from pipeline.ingest.load_test_words import (
    Branch,
    CodeText,
    branch_in_text,
    code_in_text,
    is_code_label,
    is_warm_up,
)
from pipeline.ingest.readings import Reading, is_spoilt
from pipeline.ingest.rows import listed
from pipeline.ingest.sheet import Row

WARM_UP = "warm-up"
_DAY_S = 86_400.0


@dataclass
class RowWords:
    """By row: the code of the nearest heading, the branch; rows of warm-up; rows of headings."""

    codes: dict[int, CodeText] = field(default_factory=dict)
    branches: dict[int, Branch | None] = field(default_factory=dict)
    warm_up: set[int] = field(default_factory=set)
    headings: set[int] = field(default_factory=set)
    problems: list[Problem] = field(default_factory=list)


def row_words(block: Block, code_max: int) -> RowWords:
    """Read headings between the rows ("Code: 100", "Unloading") and columns of words."""
    said = RowWords()
    code: CodeText | None = None
    branch, warm_up = _branch_of_table(block), False
    odd: list[int] = []
    worded = [name for name in ("branch", "status") if name in block.columns]
    for row, cells in block.rows():
        if (
            _is_heading(block, cells)
            and not is_commented(cells)
            and not is_spoilt(block, cells, ("shaft_speed", "torque"))
        ):
            said.headings.add(row)
            found = _code_of_heading(block, cells)
            text = block.section_text(cells) or ""
            stated = branch_in_text(text)
            if found is not None:
                code, branch, warm_up = found, None, False
            elif stated is not None or is_warm_up(text):
                branch, warm_up = stated or branch, is_warm_up(text)
            continue
        words = {name: block.text(cells, name) or "" for name in worded}
        told = {name: branch_in_text(text) for name, text in words.items()}
        if words.get("branch") and told["branch"] is None:
            odd.append(row)
        if code is not None:
            said.codes[row] = code
        said.branches[row] = told.get("branch") or told.get("status") or branch
        if warm_up or is_warm_up(words.get("status", "")):
            said.warm_up.add(row)
    percent = next((row for row, one in said.codes.items() if one.percent), None)
    if odd:
        what = (
            f"the branch is neither loading nor unloading in {listed(odd)}; it was told from the "
            "torque."
        )
        place = block.place(odd[0], "branch")
        said.problems.append(Problem("note", place, what, '"loading" or "unloading".'))
    if percent is not None:
        said.problems.append(percent_note(block.place(percent), code_max))
    return said


def with_words(
    readings: Sequence[Reading], said: RowWords, code: float | None, code_max: int
) -> list[Reading]:
    """Give readings the code, branch and warm-up that words say; `code` is that of the table."""
    done = []
    for one in readings:
        stated = said.codes[one.row].in_codes(code_max) if one.row in said.codes else code
        marks = (WARM_UP,) if one.row in said.warm_up else ()
        values = one.values
        if stated is not None and "code" not in values:
            values = {**values, "code": stated + 0.0}
        branch = said.branches.get(one.row)
        done.append(Reading(one.row, values, (*one.marks, *marks), branch))
    return done


def mark_early(readings: Sequence[Reading], warm_up_s: float) -> list[Reading]:
    """Mark the rows before `warm_up_s`, counted from the first time of the table. [s]."""
    times = [one.values["time"] for one in readings if "time" in one.values]
    if not times:
        return list(readings)
    # A clock time starts somewhere in the day; a running time may start above zero on purpose.
    by_clock = times[0] > 10.0 * max(warm_up_s, 60.0)
    start = times[0] if by_clock else 0.0

    def is_early(values: Mapping[str, float]) -> bool:
        since_s = values.get("time", float("inf")) - start
        if by_clock and since_s < 0.0:
            since_s += _DAY_S  # midnight has passed
        return since_s < warm_up_s

    return [one.marked(WARM_UP) if is_early(one.values) else one for one in readings]


def _is_heading(block: Block, cells: Row) -> bool:
    """Tell whether a row is a heading: no speed, and a code or nothing but text."""
    speed = block.columns["shaft_speed"].index
    if speed < len(cells) and is_number(cells[speed]):
        return False
    # A row of text alone is a remark; a word in place of a number has numbers beside it.
    return _code_of_heading(block, cells) is not None or block.section_text(cells) is not None


def _code_of_heading(block: Block, cells: Row) -> CodeText | None:
    inside = cells[block.span[0] : block.span[1] + 1]
    for index, cell in enumerate(inside):
        if not isinstance(cell, str):
            continue
        code = code_in_text(cell)
        if code is not None:
            return code
        following = inside[index + 1] if index + 1 < len(inside) else None
        if is_code_label(cell) and is_number(following):
            return CodeText(parse_number(following) or 0.0)
    return None


def _branch_of_table(block: Block) -> Branch | None:
    """Return the branch that a group heading, a heading or the sheet's name states."""
    torque = block.columns["torque"]
    headings = [cell for cell in block.above if isinstance(cell.value, str)]
    texts = [torque.header, torque.group, *(str(cell.value) for cell in reversed(headings))]
    told = (branch_in_text(text) for text in (*texts, block.sheet.name or ""))
    return next((branch for branch in told if branch is not None), None)


@dataclass(frozen=True)
class TableCode:
    """The control code of a table, None where rows or nothing state it, and where it was found."""

    value: float | None
    found_in: str


def codes_of_blocks(
    blocks: Sequence[Block], path: Path, code_max: int, problems: list[Problem]
) -> list[TableCode]:
    """Find the code of each table of a sheet; the file's name may state it, too.

    Per cent are of `code_max`. What is contradictory is added to the problems.
    """
    found = [_code_of(block, path, code_max, problems) for block in blocks]
    for position, block in enumerate(blocks):
        # "Code 90" stands over the first of two tables side by side and holds for both.
        beside = {
            found[other].value
            for other, block_beside in enumerate(blocks)
            if block_beside.header_row == block.header_row and found[other].found_in == "heading"
        }
        if (
            found[position].found_in != "heading"
            and len(beside) == 1
            and block.columns.keys().isdisjoint({"code", "pwm"})
        ):
            found[position] = TableCode(beside.pop(), "heading")
    return found


def _code_of(block: Block, path: Path, code_max: int, problems: list[Problem]) -> TableCode:
    if "code" in block.columns:
        return TableCode(None, "code column")
    if "pwm" in block.columns:
        return TableCode(None, "pulse width column")
    name = block.sheet.name
    in_name = None if name is None else code_in_text(name, alone=True)
    heading = _code_in_headings(block)
    if heading is not None:
        in_heading = _in_codes(heading, block, code_max, problems)
        if in_name is not None and abs(in_name.in_codes(code_max)) != abs(in_heading):
            problems.append(
                Problem(
                    "warning",
                    block.place(block.header_row),
                    f"the heading says code {in_heading:g}, the sheet's name "
                    f"{in_name.in_codes(code_max):g}; "
                    "the heading was used.",
                    "one code.",
                    "Correct the heading or the name.",
                )
            )
        return TableCode(in_heading, "heading")
    for code, origin in ((in_name, "sheet name"), (code_in_text(path.stem), "file name")):
        if code is not None:
            return TableCode(_with_sign(code, block, code_max, problems), origin)
    return TableCode(None, "not stated")


def _in_codes(code: CodeText, block: Block, code_max: int, problems: list[Problem]) -> float:
    if code.percent:
        problems.append(percent_note(block.place(block.header_row), code_max))
    return code.in_codes(code_max)


def _with_sign(code: CodeText, block: Block, code_max: int, problems: list[Problem]) -> float:
    """Take a hyphen before the number for a minus where the speed is negative throughout."""
    whole = _in_codes(code, block, code_max, problems)
    if not code.doubtful_sign:
        return whole
    speeds = [cells[index] for _, cells in block.rows() if (index := _speed(block)) < len(cells)]
    numbers = [parse_number(cell) or 0.0 for cell in speeds if is_number(cell)]
    sign = block.columns["shaft_speed"].sign
    negative = bool(numbers) and max(number * sign for number in numbers) <= 0.0
    value = -whole if negative else whole
    problems.append(
        Problem(
            "note",
            block.place(),
            f"the hyphen before {code.value:g} was taken for a {'minus' if negative else 'dash'}, "
            f"as the speed is {'negative' if negative else 'positive'}: code {value:g}.",
            "",
            f'Write "code {code.value:g}" or "code = -{code.value:g}".',
        )
    )
    return value


def _speed(block: Block) -> int:
    return block.columns["shaft_speed"].index


def _code_in_headings(block: Block) -> CodeText | None:
    """Return the code that the nearest heading above the table states."""
    cells = block.above
    for position in range(len(cells) - 1, -1, -1):
        cell = cells[position]
        if not isinstance(cell.value, str):
            continue
        code = code_in_text(cell.value)
        if code is not None:
            return code
        if is_code_label(cell.value):
            for other in cells[position + 1 :]:
                if other.row > cell.row + 1:
                    break
                beside = other.row == cell.row or other.column == cell.column
                number = parse_number(other.value) if beside and is_number(other.value) else None
                if number is not None:
                    return CodeText(number)
    return None
