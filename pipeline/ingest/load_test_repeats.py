"""Readings that occur twice: repeated rows, copied sheets, a code measured on two sheets."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.load_test_rows import LoadTestReading, with_mark
from pipeline.ingest.rows import counted, listed
from pipeline.records.measurements import ColumnNotUsed, ColumnRead
from pipeline.types import FloatArray

_Key = tuple[str, ...]
#: Of the largest value; what rounding to three digits may change.
_ROUNDING = 1e-3
_DERIVED_SHARE = 0.9
_LEAST_DERIVED = 10
_MOST_PAIRS = 4_000_000


@dataclass(frozen=True)
class SheetReading:
    """A reading and where its code was found."""

    reading: LoadTestReading
    code_from: str


@dataclass(frozen=True)
class LoadTestSheet:
    """What was read on one sheet."""

    file: str
    name: str | None
    readings: tuple[SheetReading, ...]
    columns: tuple[ColumnRead, ...]
    summary: str
    problems: tuple[Problem, ...]
    not_used: tuple[ColumnNotUsed, ...] = ()
    stated_as: tuple[tuple[str, str], ...] = ()

    @property
    def place(self) -> Place:
        """The sheet, for a message."""
        return Place(self.file, self.name)


def mark_repeats(sheets: Sequence[LoadTestSheet]) -> tuple[list[LoadTestSheet], list[Problem]]:
    """Mark readings that were already read, and codes that another sheet of the file has.

    Parameters
    ----------
    sheets : sequence of LoadTestSheet
        All sheets of all files, in order.

    Returns
    -------
    tuple of (list of LoadTestSheet, list of Problem)
        The sheets with marks, and what was marked. Several files may measure the same code: that
        is a repetition of the test and nothing is marked.
    """
    done: list[LoadTestSheet] = []
    problems: list[Problem] = []
    seen: dict[_Key, Place] = {}
    for sheet in sheets:
        marked, wrong = _mark_codes(sheet, [one for one in done if one.file == sheet.file])
        problems += wrong
        marked, wrong = _mark_rows(marked, seen)
        problems += wrong
        marked, wrong = _mark_derived(marked, [one for one in done if one.file == sheet.file])
        problems += wrong
        done.append(marked)
    return done, problems


def _mark_codes(
    sheet: LoadTestSheet, earlier: Sequence[LoadTestSheet]
) -> tuple[LoadTestSheet, list[Problem]]:
    """Mark the readings at a code that an earlier sheet of the file has with other values."""
    marked = sheet
    problems: list[Problem] = []
    for code in sorted(
        {one.reading.code for one in sheet.readings if one.reading.code is not None}
    ):
        mine = [one for one in sheet.readings if one.reading.code == code]
        for other in earlier:
            theirs = [one for one in other.readings if one.reading.code == code]
            if not theirs or _branches(mine).isdisjoint(_branches(theirs)):
                continue
            if {_key(one.reading) for one in mine} <= {_key(one.reading) for one in theirs}:
                continue  # a copy: its rows are marked as duplicates
            listed_in_rows = mine[0].code_from == theirs[0].code_from == "code column"
            problems.append(_code_twice(sheet, other, code, left_out=not listed_in_rows))
            if not listed_in_rows:
                mark = f'code {code:g} also on sheet "{other.name}"'
                marked = replace(
                    marked,
                    readings=tuple(
                        replace(one, reading=with_mark(one.reading, mark))
                        if one.reading.code == code
                        else one
                        for one in marked.readings
                    ),
                )
            break
    return marked, problems


def _branches(readings: Sequence[SheetReading]) -> set[str]:
    return {one.reading.branch or "loading" for one in readings if not one.reading.marks}


def _code_twice(
    sheet: LoadTestSheet, other: LoadTestSheet, code: float, *, left_out: bool
) -> Problem:
    if left_out:
        return Problem(
            "error",
            sheet.place,
            f'code {code:g} is also on sheet "{other.name}", with other values; the points of '
            f'"{sheet.name}" are kept but not fitted.',
            "each code on one sheet of a workbook.",
            "Correct the code of one of them, or move a repeated test to a workbook of its own.",
        )
    return Problem(
        "warning",
        sheet.place,
        f'code {code:g} is also on sheet "{other.name}", with other values; both were read.',
        "each code once, unless the test was repeated.",
        "If it was not repeated, correct the code.",
    )


def _mark_rows(
    sheet: LoadTestSheet, seen: dict[_Key, Place]
) -> tuple[LoadTestSheet, list[Problem]]:
    """Mark the readings that were read before, here or on an earlier sheet."""
    readings: list[SheetReading] = []
    repeated: dict[Place, list[int]] = {}
    for one in sheet.readings:
        key = _key(one.reading)
        if not one.reading.marks and key in seen:
            repeated.setdefault(seen[key], []).append(one.reading.row)
            readings.append(replace(one, reading=with_mark(one.reading, "duplicate")))
            continue
        if not one.reading.marks:
            seen[key] = sheet.place
        readings.append(one)
    problems = [
        Problem(
            "warning" if len(rows) == len(sheet.readings) else "note",
            replace(sheet.place, row=rows[0]),
            f"{counted(len(rows), 'row')} again as "
            f"{'further up' if first == sheet.place else f'in {first}'} in every number "
            f"({listed(rows)}); kept but not fitted.",
            "",
            "If the whole sheet is a copy, delete it." if len(rows) == len(sheet.readings) else "",
        )
        for first, rows in repeated.items()
    ]
    return replace(sheet, readings=tuple(readings)), problems


def _mark_derived(
    sheet: LoadTestSheet, earlier: Sequence[LoadTestSheet]
) -> tuple[LoadTestSheet, list[Problem]]:
    """Mark a sheet that holds an earlier one once more, rounded or without signs.

    Only among sheets without control codes: results beside the measurements they are from.
    """
    mine = _codeless(sheet)
    if len(mine) < _LEAST_DERIVED:
        return sheet, []
    for other in earlier:
        theirs = _codeless(other)
        if len(theirs) < len(mine) or len(theirs) * len(mine) > _MOST_PAIRS:
            continue
        apart = np.abs(mine[:, None, :] - theirs[None, :, :])
        close = (apart <= _ROUNDING * theirs.max(axis=0)).all(axis=2).any(axis=1)
        if close.mean() < _DERIVED_SHARE:
            continue
        problem = Problem(
            "warning",
            sheet.place,
            f'the sheet holds the points of "{other.name}" once more, rounded or without signs; '
            "they are kept but not fitted.",
            "",
            "State the sheet to read in vehicle.yaml under columns: load_test: sheets.",
        )
        mark = f'also on sheet "{other.name}"'
        readings = tuple(
            replace(one, reading=with_mark(one.reading, mark)) for one in sheet.readings
        )
        return replace(sheet, readings=readings), [problem]
    return sheet, []


def _codeless(sheet: LoadTestSheet) -> FloatArray:
    """Return (|speed|, |torque|) of the readings without a code, shape (n, 2)."""
    return np.array(
        [
            (abs(one.reading.shaft_speed_rpm), abs(one.reading.torque_nm))
            for one in sheet.readings
            if one.reading.code is None
        ]
    ).reshape(-1, 2)


def _key(reading: LoadTestReading) -> _Key:
    numbers = (reading.code, reading.shaft_speed_rpm, reading.torque_nm)
    # Nine digits: the same file read as text and as a workbook differs in the last ones.
    texts = ["" if number is None else f"{number:.9g}" for number in numbers]
    return (*texts, *(f"{name}={value:.9g}" for name, value in sorted(reading.values.items())))
