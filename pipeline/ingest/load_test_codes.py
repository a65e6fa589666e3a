"""The control code of a load-test table: code column, heading, sheet name or file name."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import is_number, parse_number
from pipeline.ingest.load_test_words import CodeText, code_in_text, is_code_label


@dataclass(frozen=True)
class TableCode:
    """The control code of a table, None where rows or nothing state it, and where it was found."""

    value: float | None
    found_in: str


def codes_of_blocks(
    blocks: Sequence[Block], path: Path, problems: list[Problem]
) -> list[TableCode]:
    """Find the code of each table of a sheet.

    Parameters
    ----------
    blocks : sequence of Block
        All tables of the sheet.
    path : Path
        The file; its name may state the code.
    problems : list of Problem
        What is contradictory is added here.

    Returns
    -------
    list of TableCode
        One for each table.
    """
    found = [_code_of(block, path, problems) for block in blocks]
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
            and "code" not in block.columns
        ):
            found[position] = TableCode(beside.pop(), "heading")
    return found


def _code_of(block: Block, path: Path, problems: list[Problem]) -> TableCode:
    if "code" in block.columns:
        return TableCode(None, "code column")
    name = block.sheet.name
    in_name = None if name is None else code_in_text(name, alone=True)
    in_heading = _code_in_headings(block)
    if in_heading is not None:
        if in_name is not None and abs(in_name.value) != abs(in_heading):
            problems.append(
                Problem(
                    "warning",
                    block.place(block.header_row),
                    f"the heading says code {in_heading:g}, the sheet's name {in_name.value:g}; "
                    "the heading was used.",
                    "one code.",
                    "Correct the heading or the name.",
                )
            )
        return TableCode(in_heading, "heading")
    for code, origin in ((in_name, "sheet name"), (code_in_text(path.stem), "file name")):
        if code is not None:
            return TableCode(_with_sign(code, block, problems), origin)
    return TableCode(None, "not stated")


def _with_sign(code: CodeText, block: Block, problems: list[Problem]) -> float:
    """Take a hyphen before the number for a minus where the speed is negative throughout."""
    if not code.doubtful_sign:
        return code.value
    speeds = [cells[index] for _, cells in block.rows() if (index := _speed(block)) < len(cells)]
    numbers = [parse_number(cell) or 0.0 for cell in speeds if is_number(cell)]
    sign = block.columns["shaft_speed"].sign
    negative = bool(numbers) and max(number * sign for number in numbers) <= 0.0
    value = -code.value if negative else code.value
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


def _code_in_headings(block: Block) -> float | None:
    """Return the code that the nearest heading above the table states."""
    cells = block.above
    for position in range(len(cells) - 1, -1, -1):
        cell = cells[position]
        if not isinstance(cell.value, str):
            continue
        code = code_in_text(cell.value)
        if code is not None:
            return code.value
        if is_code_label(cell.value):
            for other in cells[position + 1 :]:
                if other.row > cell.row + 1:
                    break
                beside = other.row == cell.row or other.column == cell.column
                if beside and is_number(other.value):
                    return parse_number(other.value)
    return None
