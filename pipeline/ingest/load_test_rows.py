"""What words say of a load-test table and of its rows: control code, branch and warm-up."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Reading, RowWords, Table
from pipeline.ingest.blocks import Block, HeadingCell, is_commented
from pipeline.ingest.cells import Row, is_number, parse_number
from pipeline.ingest.commands import percent_note
from pipeline.ingest.load_test_words import (
    Branch,
    CodeText,
    branch_in_text,
    code_in_text,
    is_code_label,
    is_warm_up,
)
from pipeline.ingest.readings import is_spoilt
from pipeline.ingest.rows import listed
from pipeline.vehicle.schema import Vehicle

WARM_UP = "warm-up"
_DAY_S = 86_400.0


def row_words(block: Block, vehicle: Vehicle) -> RowWords:
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
            f"the branch is neither loading nor unloading in {listed(odd)}; it was taken from the "
            "torque."
        )
        place = block.place(odd[0], "branch")
        said.problems.append(place.note(what, '"loading" or "unloading".'))
    if percent is not None:
        said.problems.append(percent_note(block.place(percent), vehicle.drive.code_max))
    return said


def with_words(table: Table) -> tuple[Problem, ...]:
    """Tell code, branch and warm-up of each row by words."""
    said, code_max = table.words, table.vehicle.drive.code_max

    def told(one: Reading) -> Reading:
        stated = said.codes[one.row].in_codes(code_max) if one.row in said.codes else table.code
        if stated is not None and "code" not in one.values:
            one = one.with_values(code=stated)
        marks = (*one.marks, *((WARM_UP,) if one.row in said.warm_up else ()))
        return Reading(one.row, one.values, marks, said.branches.get(one.row))

    table.change(told)
    return ()


def mark_early(table: Table) -> tuple[Problem, ...]:
    """Mark the rows of the time that vehicle.yaml states for warming up, from the first on."""
    warm_up_s = table.vehicle.columns.load_test.warm_up_s
    times = [one.values["time"] for one in table.readings if "time" in one.values]
    if warm_up_s is None:
        return ()
    if not times:
        what = f"vehicle.yaml states warm_up_s: {warm_up_s:g}, and there is no time to count it by."
        return (table.at(table.head).warning(what, "a time column."),)
    # A clock time starts somewhere in the day; a running time may start above zero on purpose.
    by_clock = times[0] > 10.0 * max(warm_up_s, 60.0)
    start = times[0] if by_clock else 0.0
    early = set()
    for one in table.readings:
        since_s = one.values.get("time", float("inf")) - start
        if by_clock and since_s < 0.0:
            since_s += _DAY_S  # midnight has passed
        if since_s < warm_up_s:
            early.add(one.row)
    table.mark(early, WARM_UP)
    return ()


def _is_heading(block: Block, cells: Row) -> bool:
    """Tell whether a row is a heading: no speed, and a code or nothing but text."""
    speed = block.columns["shaft_speed"].index
    if speed < len(cells) and is_number(cells[speed]):
        return False
    # A row of text alone is a remark; a word in place of a number has numbers beside it.
    return _code_of_heading(block, cells) is not None or block.section_text(cells) is not None


def _code_of_heading(block: Block, cells: Row) -> CodeText | None:
    low, high = block.span
    inside = enumerate(cells[low : high + 1], start=low)
    return _code_in([HeadingCell(0, at, cell) for at, cell in inside if cell is not None])


def _code_in(cells: Sequence[HeadingCell]) -> CodeText | None:
    """Return the code that the last of these cells states, or announces for one beside or below."""
    for position in range(len(cells) - 1, -1, -1):
        cell = cells[position]
        if not isinstance(cell.value, str):
            continue
        code = code_in_text(cell.value)
        if code is not None:
            return code
        for other in cells[position + 1 :] if is_code_label(cell.value) else ():
            if other.row > cell.row + 1:
                break
            beside = other.row == cell.row or other.column == cell.column
            number = parse_number(other.value) if beside and is_number(other.value) else None
            if number is not None:
                return CodeText(number)
    return None


def _branch_of_table(block: Block) -> Branch | None:
    """Return the branch that a group heading, a heading or the sheet's name states."""
    torque = block.columns["torque"]
    headings = [cell for cell in block.above if isinstance(cell.value, str)]
    texts = [torque.header, torque.group, *(str(cell.value) for cell in reversed(headings))]
    told = (branch_in_text(text) for text in (*texts, block.sheet.name or ""))
    return next((branch for branch in told if branch is not None), None)


def tell_codes(tables: Sequence[Table], path: Path) -> None:
    """Find the code of each table of a sheet, which the file's name may state, too."""
    for table in tables:
        _tell_code(table, path)
    for table in tables:
        # "Code 90" stands over the first of two tables side by side and holds for both.
        beside = {
            one.code
            for one in tables
            if one.head == table.head and one.code_from == "table heading"
        }
        of_rows = not table.block.columns.keys().isdisjoint({"code", "pwm"})
        if table.code_from != "table heading" and len(beside) == 1 and not of_rows:
            table.code, table.code_from = beside.pop(), "table heading"


def _tell_code(table: Table, path: Path) -> None:
    """Tell the code of a table, and where it was found: what is nearest goes first."""
    block, code_max, name = table.block, table.vehicle.drive.code_max, table.block.sheet.name
    table.code_from = "pulse width column" if "pwm" in block.columns else "not stated"
    if "code" in block.columns:
        table.code_from = "code column"
    if table.code_from != "not stated":
        return
    in_name = None if name is None else code_in_text(name, alone=True)
    places = {"table heading": _code_in(block.above), "sheet name": in_name}
    places["file name"] = code_in_text(path.stem)
    code = next((one for one in places.values() if one is not None), None)
    if code is None:
        return
    table.code_from = next(where for where, one in places.items() if one is code)
    table.code = code.in_codes(code_max)
    if code.percent:
        table.problems.append(percent_note(table.at(table.head), code_max))
    if table.code_from != "table heading":
        table.code = _with_sign(table, code, table.code)
    elif in_name is not None and abs(in_name.in_codes(code_max)) != abs(table.code):
        what = (
            f"the heading says code {table.code:g}, the sheet's name "
            f"{in_name.in_codes(code_max):g}; the heading was used."
        )
        remedy = "Correct the heading or the name."
        table.problems.append(table.at(table.head).warning(what, "one code.", remedy))


def _with_sign(table: Table, code: CodeText, whole: float) -> float:
    """Take a hyphen before the number for a minus where the speed is negative throughout."""
    if not code.doubtful_sign:
        return whole
    column = table.block.columns["shaft_speed"]
    cells = [row[column.index] for _, row in table.block.rows() if column.index < len(row)]
    numbers = [parse_number(cell) or 0.0 for cell in cells if is_number(cell)]
    negative = bool(numbers) and max(number * column.sign for number in numbers) <= 0.0
    value = -whole if negative else whole
    what = (
        f"the hyphen before {code.value:g} was taken for a {'minus' if negative else 'dash'}, "
        f"as the speed is {'negative' if negative else 'positive'}: code {value:g}."
    )
    remedy = f'Write "code {code.value:g}" or "code = -{code.value:g}".'
    table.problems.append(table.place.note(what, "", remedy))
    return value
