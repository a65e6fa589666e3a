"""What stands twice counts once: copied files, tables and rows, and a code on two sheets."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_table import Reading, Table
from pipeline.ingest.rows import counted, listed
from pipeline.types import FloatArray

_COPY = "duplicate"
#: Of which rows one is a copy: of the one above it, as readings of thrust alone may repeat; of any
#: of its table; of any of the folder, as speeds and torques have many digits.
RowCopies = Literal["above", "table", "folder"]
#: Fewer readings may agree by chance.
_LEAST_ROWS = 4
#: Of the largest value; what rounding to three digits may change.
_ROUNDING = 1e-3
_DERIVED_SHARE = 0.9
_LEAST_DERIVED = 10
_MOST_PAIRS = 4_000_000
#: A thrust alone, read coarsely, may well repeat in the next row; so many quantities do not.
_LEAST_QUANTITIES = 3


def without_copies(paths: Sequence[Path], shown: Sequence[str]) -> tuple[list[Path], list[Problem]]:
    """Leave out files that are byte for byte a copy of an earlier one; `shown` are their names.

    One that cannot be read is kept: its reader will say why.
    """
    kept: list[Path] = []
    problems: list[Problem] = []
    first: dict[str, int] = {}
    for number, path in enumerate(paths):
        try:
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError:
            digest = str(path)
        earlier = first.setdefault(digest, number)
        if earlier == number:
            kept.append(path)
            continue
        what = f"the same content as {shown[earlier]}; left out."
        problems.append(Place(shown[number]).warning(what, remedy="Delete the copy."))
    return kept, problems


class Repeats:
    """Remembers the tables of all files of a folder and marks what was read before."""

    def __init__(self, rows: RowCopies) -> None:
        """Begin with nothing seen; `rows` tells which row is a copy of which."""
        self._which = rows
        self._rows: dict[object, tuple[Place, int]] = {}
        self._tables: dict[object, Place] = {}

    def mark(self, tables: Sequence[Table]) -> None:
        """Mark the readings of a file's tables that were read before, and say so.

        Several files may measure the same code: that is a repetition of the test and nothing is
        marked.
        """
        for number, table in enumerate(tables):
            earlier = [one for one in tables[:number] if one.place != table.place]
            if self._which == "folder":
                _codes_twice(table, earlier)
            else:
                self._whole(table)
                self._rows = {}
            self._rows_twice(table)
            if self._which == "folder":
                _derived(table, earlier)

    def _whole(self, table: Table) -> None:
        live = table.live()
        keys = tuple(map(_key, live))
        key = (table.nominal_voltage_v, table.sense, keys)
        if len(set(keys)) < _LEAST_ROWS:
            return
        first = self._tables.setdefault(key, table.place)
        if first is not table.place:
            what = (
                f"all {len(live)} rows stand in {first}, too, with the same numbers; kept but not "
                "fitted."
            )
            table.problems.append(table.place.warning(what, "", "Delete the copy."))
            table.change(lambda one: one if one.marks else one.marked(_COPY))

    def _rows_twice(self, table: Table) -> None:
        repeated: dict[Place, list[int]] = {}
        for at, one in enumerate(table.readings):
            here = (table.place, one.row)
            seen = here if one.marks else self._rows.setdefault(_key(one), here)
            if self._which == "above":  # then the rows before count no more
                self._rows = {_key(one): here}
            # of few quantities, or at rest, equal readings are nothing odd
            values = one.values
            at_rest = 0.0 in {values.get(name) for name in ("code", "advance_ratio", "speed")}
            least = _LEAST_QUANTITIES - ("advance_ratio" in values)
            is_telling = len(values) >= least and not at_rest
            if seen != here and (self._which == "folder" or is_telling):
                repeated.setdefault(seen[0], []).append(one.row)
                table.readings[at] = one.marked(_COPY)
        for first, rows in repeated.items():
            whole = len(rows) == len(table.readings)
            where = "further up" if first == table.place else f"in {first}"
            what = (
                f"{counted(len(rows), 'row')} again as {where} in every number ({listed(rows)}); "
                "kept but not fitted."
            )
            is_warning = whole or self._which != "folder"
            severity: Literal["warning", "note"] = "warning" if is_warning else "note"
            remedy = "If the whole sheet is a copy, delete it." if whole else ""
            table.problems.append(Problem(severity, table.at(rows[0]), what, "", remedy))


def _codes_twice(table: Table, earlier: Sequence[Table]) -> None:
    """Mark the readings at a code that an earlier sheet of the file has with other values."""
    readings = list(table.readings)
    for code in sorted({one.values["code"] for one in readings if "code" in one.values}):
        mine = [one for one in readings if one.values.get("code") == code]
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
                table.problems.append(table.place.warning(what, expected, remedy))
                break
            what = f'{there}; the points of "{table.place.sheet}" are kept but not fitted.'
            expected = "each code on one sheet of a workbook."
            remedy = "Correct the code of one, or move a repeated test to a workbook of its own."
            table.problems.append(table.place.error(what, expected, remedy))
            mark = f'code {code:g} also on sheet "{other.place.sheet}"'
            table.mark({one.row for one in mine}, mark)
            break


def _branches(readings: Sequence[Reading]) -> set[str]:
    return {one.branch or "loading" for one in readings if not one.marks}


def _derived(table: Table, earlier: Sequence[Table]) -> None:
    """Mark a sheet that holds an earlier one once more, rounded or without signs.

    Only among sheets without control codes: results beside the measurements they are from.
    """
    mine = _codeless(table.readings)
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
        table.problems.append(table.place.warning(what, "", remedy))
        mark = f'also on sheet "{other.place.sheet}"'
        table.change(lambda one: one.marked(mark))  # noqa: B023 - and then it returns
        return


def _codeless(readings: Sequence[Reading]) -> FloatArray:
    """Return (|speed|, |torque|) of the readings without a code, shape (n, 2)."""
    return np.array(
        [
            (abs(one.values["shaft_speed"]), abs(one.values["torque"]))
            for one in readings
            if "code" not in one.values
        ]
    ).reshape(-1, 2)


def _key(reading: Reading) -> tuple[str, ...]:
    # Nine digits: the same file read as text and as a workbook differs in the last ones.
    values = {name: v for name, v in reading.values.items() if name != "time"}
    return tuple(f"{name}={value:.9g}" for name, value in sorted(values.items()))
