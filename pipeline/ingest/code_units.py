"""What control codes are counted in: codes, per cent of the full code, or shares of it."""

from collections.abc import Callable, Sequence

from pipeline.errors import Place, Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import shorten
from pipeline.ingest.unit_text import is_percent
from pipeline.ingest.vocabulary import plain

#: Names of a command that is always a share, whatever the controller counts in.
_THROTTLE = ("throttle", "газ", "дроссель", "duty", "скважность")


def command_scale(
    block: Block, codes: Sequence[float], code_max: int, problems: list[Problem]
) -> float:
    """Return what a number of the code column is worth in codes.

    1 where the column counts codes, else what its per cent or its share of full throttle is, of
    `code_max` at full command. What was assumed is added to the problems.
    """
    column = block.columns.get("code")
    if column is None:
        return 1.0
    place = block.place(block.header_row, "code")
    largest = max((abs(code) for code in codes), default=0.0)
    fractions = any(not code.is_integer() for code in codes)
    throttle = any(plain(word) in plain(column.header).split() for word in _THROTTLE)
    if is_percent(column.unit):
        if not 0.0 < largest <= 1.0:
            problems.append(percent_note(place, code_max))
            return code_max / 100.0
        problems.append(
            Problem(
                "warning",
                place,
                f"code is in per cent, but no value is above {largest:g}: these look like shares, "
                f"as a cell that shows 100 % holds 1. So 1 is taken for code {code_max}.",
                "numbers up to 100, or a code column without % in its name.",
                "Write 25 in place of 25 %, and format the cells as plain numbers.",
            )
        )
        return float(code_max)
    header = shorten(column.header)
    if 0.0 < largest <= 1.0 < code_max and (fractions or throttle):
        what = f'"{header}" has no number above {largest:g}: shares of full throttle, 1 is code '
        problems.append(Problem("note", place, f"{what}{code_max}."))
        return float(code_max)
    if throttle and largest == 100.0 != code_max:
        what = f'"{header}" ends at 100: per cent of full throttle, code {code_max}.'
        problems.append(Problem("warning", place, what))
        return code_max / 100.0
    return 1.0


def percent_note(place: Place, code_max: int) -> Problem:
    """Say what a code in per cent is taken for."""
    what = f"code is in per cent: 100 % is taken for code {code_max}."
    return Problem("note", place, what)


def fractional_codes(
    codes: Sequence[tuple[int, float]], place_of: Callable[[int], Place], kind: str
) -> list[Problem]:
    """Warn of a code column with fractions: it is often a current or a share.

    `codes` are row and number; `kind` is the section of vehicle.yaml.
    """
    odd = [(row, code) for row, code in codes if not code.is_integer()]
    if not odd:
        return []
    values = ", ".join(f"{code:g}" for code in sorted({code for _, code in odd})[:6])
    return [
        Problem(
            "warning",
            place_of(odd[0][0]),
            f"code {values}: a control code is a whole number. The {len(odd)} points are "
            "fitted at the codes as they stand.",
            "whole numbers, as the drive is sent them, or a share with % in the column's name.",
            "Correct the codes, write % into the name, or state the right column in vehicle.yaml "
            f"under columns: {kind}: code.",
        )
    ]
