"""Readings that occur twice: repeated rows, copied sheets, a code measured on two sheets."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.readings import Reading
from pipeline.ingest.rows import counted, listed
from pipeline.types import FloatArray

_Key = tuple[str, ...]
#: Of the largest value; what rounding to three digits may change.
_ROUNDING = 1e-3
_DERIVED_SHARE = 0.9
_LEAST_DERIVED = 10
_MOST_PAIRS = 4_000_000


@dataclass(frozen=True)
class LoadTable:
    """Readings of a table, its sheet, and where their codes were found."""

    place: Place
    readings: tuple[Reading, ...]
    code_from: str


class Repeats:
    """Remembers the load tests of all files and marks readings that were read before."""

    def __init__(self) -> None:
        self._seen: dict[_Key, tuple[Place, int]] = {}

    def marked(self, tables: Sequence[LoadTable], problems: list[Problem]) -> list[LoadTable]:
        """Return the tables of a file, marked where a reading or a code was read before.

        Several files may measure the same code: that is a repetition of the test and nothing is
        marked. What was marked is added to `problems`.
        """
        done: list[LoadTable] = []
        for table in tables:
            earlier = [one for one in done if one.place != table.place]
            readings = _codes_twice(table, earlier, problems)
            readings = self._rows_twice(table.place, readings, problems)
            readings = _derived(table.place, readings, earlier, problems)
            done.append(replace(table, readings=tuple(readings)))
        return done

    def _rows_twice(
        self, place: Place, readings: Sequence[Reading], problems: list[Problem]
    ) -> list[Reading]:
        marked: list[Reading] = []
        repeated: dict[Place, list[int]] = {}
        for one in readings:
            here = (place, one.row)
            seen = here if one.marks else self._seen.setdefault(_key(one), here)
            if seen != here:
                repeated.setdefault(seen[0], []).append(one.row)
            marked.append(one if seen == here else one.marked("duplicate"))
        for first, rows in repeated.items():
            whole = len(rows) == len(readings)
            where = "further up" if first == place else f"in {first}"
            what = (
                f"{counted(len(rows), 'row')} again as {where} in every number ({listed(rows)}); "
                "kept but not fitted."
            )
            remedy = "If the whole sheet is a copy, delete it." if whole else ""
            at = replace(place, row=rows[0])
            problems.append(Problem("warning" if whole else "note", at, what, "", remedy))
        return marked


def _codes_twice(
    table: LoadTable, earlier: Sequence[LoadTable], problems: list[Problem]
) -> list[Reading]:
    """Mark the readings at a code that an earlier sheet of the file has with other values."""
    marked = list(table.readings)
    for code in sorted({one.values["code"] for one in marked if "code" in one.values}):
        mine = [one for one in table.readings if one.values.get("code") == code]
        for other in earlier:
            theirs = [one for one in other.readings if one.values.get("code") == code]
            if not theirs or _branches(mine).isdisjoint(_branches(theirs)):
                continue
            if {_key(one) for one in mine} <= {_key(one) for one in theirs}:
                continue  # a copy: its rows are marked as duplicates
            there = f'code {code:g} is also on sheet "{other.place.sheet}", with other values'
            if table.code_from == other.code_from == "code column":
                what = f"{there}; both were read."
                expected = "each code once, unless the test was repeated."
                remedy = "If it was not repeated, correct the code."
                problems.append(Problem("warning", table.place, what, expected, remedy))
                break
            what = f'{there}; the points of "{table.place.sheet}" are kept but not fitted.'
            expected = "each code on one sheet of a workbook."
            remedy = "Correct the code of one, or move a repeated test to a workbook of its own."
            problems.append(Problem("error", table.place, what, expected, remedy))
            mark = f'code {code:g} also on sheet "{other.place.sheet}"'
            rows = {one.row for one in mine}
            marked = [one.marked(mark) if one.row in rows else one for one in marked]
            break
    return marked


def _branches(readings: Sequence[Reading]) -> set[str]:
    return {one.branch or "loading" for one in readings if not one.marks}


def _derived(
    place: Place,
    readings: Sequence[Reading],
    earlier: Sequence[LoadTable],
    problems: list[Problem],
) -> list[Reading]:
    """Mark a sheet that holds an earlier one once more, rounded or without signs.

    Only among sheets without control codes: results beside the measurements they are from.
    """
    mine = _codeless(readings)
    for other in earlier if len(mine) >= _LEAST_DERIVED else ():
        theirs = _codeless(other.readings)
        if len(theirs) < len(mine) or len(theirs) * len(mine) > _MOST_PAIRS:
            continue
        apart = np.abs(mine[:, None, :] - theirs[None, :, :])
        close = (apart <= _ROUNDING * theirs.max(axis=0)).all(axis=2).any(axis=1)
        if close.mean() < _DERIVED_SHARE:
            continue
        what = (
            f'the sheet holds the points of "{other.place.sheet}" once more, rounded or without '
            "signs; they are kept but not fitted."
        )
        remedy = "State the sheet to read in vehicle.yaml under columns: load_test: sheets."
        problems.append(Problem("warning", place, what, "", remedy))
        return [one.marked(f'also on sheet "{other.place.sheet}"') for one in readings]
    return list(readings)


def _codeless(readings: Sequence[Reading]) -> FloatArray:
    """Return (|speed|, |torque|) of the readings without a code, shape (n, 2)."""
    return np.array(
        [
            (abs(one.values["shaft_speed"]), abs(one.values["torque"]))
            for one in readings
            if "code" not in one.values
        ]
    ).reshape(-1, 2)


def _key(reading: Reading) -> _Key:
    # Nine digits: the same file read as text and as a workbook differs in the last ones.
    values = {name: v for name, v in reading.values.items() if name != "time"}
    return tuple(f"{name}={value:.9g}" for name, value in sorted(values.items()))
