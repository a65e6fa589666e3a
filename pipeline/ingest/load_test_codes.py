"""The control code of a load-test table: code column, heading, sheet name or file name."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import is_number, parse_number
from pipeline.ingest.code_units import percent_note
from pipeline.ingest.load_test_words import CodeText, code_in_text, is_code_label


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
