"""Open-water tests: K_T and K_Q (the papers' K_M) against the advance ratio."""

import re
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_file import BenchFile
from pipeline.ingest.bench_kind import Kind, read_files
from pipeline.ingest.bench_table import Table, numbers
from pipeline.ingest.cells import shorten
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.open_water_coefficients import (
    TORQUE_FACTORS,
    Coefficients,
    check_efficiency,
    coefficients,
    doubt,
    ends_too_early,
    far_from_pitch,
    impossible,
)
from pipeline.ingest.row_directions import column_that_parts
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.vocabulary import plain
from pipeline.records.base import Source
from pipeline.records.measurements import OpenWaterPoint, OpenWaterRecord
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

_TEN_TIMES = re.compile(r"^\s*10\s*[·*×x]?\s*[A-Za-zА-Яа-я]|[·*×x]\s*10\s*$")
#: Outside of it an advance ratio is a mistake of units or of columns.
_LARGEST_ADVANCE_RATIO = 3.0
#: Share of the rows.
_MOST_LARGE = 0.2
#: Scatter of K_T about one curve, a share of the largest; fewer readings are no two curves.
_MOST_SCATTER, _LEAST_OF_TWO = 0.04, 8
_QUANTITIES = (
    *("advance_ratio", "thrust_coefficient", *TORQUE_FACTORS, "efficiency"),
    *("speed", "shaft_speed", "thrust", "torque"),
)
#: A coefficient that differs by more from its thrust is of another one.
_MOST_APART = 0.1


def read_open_water(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> OpenWaterRecord:
    """Read all open-water tests of a vehicle; sources are named relative to `raw_root`.

    Density of the water and diameter of the propeller are those of the vehicle file. A file that
    cannot be read is a problem of severity "error", and the others are read.
    """
    read = read_files(_KIND, paths, vehicle, raw_root)
    return OpenWaterRecord(points=read.points, sheets=read.sheets, problems=read.problems)


@dataclass(frozen=True)
class _Rows:
    """Rows of a table that have coefficients: their numbers, what they hold, which of them count.

    `number` and `used` are (n,), as are the `values` by quantity.
    """

    number: IntArray
    values: dict[str, FloatArray]
    found: Coefficients
    used: BoolArray

    def counting(self) -> "_Rows":
        """Return those that count."""
        values = {name: own[self.used] for name, own in self.values.items()}
        return _Rows(self.number[self.used], values, self.found.of(self.used), self.used[self.used])


def _points(file: BenchFile) -> list[tuple[OpenWaterPoint, ...]]:
    return [tuple(_of_table(table)) for table in file.tables]


def _coefficients(table: Table, values: dict[str, FloatArray]) -> Coefficients:
    diameter_m = table.vehicle.propeller.diameter_m
    with np.errstate(divide="ignore", invalid="ignore"):
        return coefficients(values, table.vehicle.water.density_kgpm3, diameter_m)


def _of_table(table: Table) -> Iterator[OpenWaterPoint]:
    problems, block = table.problems, table.block
    problems += _notes(table)
    values = {name: numbers(table.readings, name) for name in _QUANTITIES}
    torque = block.columns.get("torque_coefficient")
    if torque is not None and _TEN_TIMES.search(torque.header) is not None:
        # vehicle.yaml names a column "10KQ" as the torque coefficient.
        values["torque_coefficient_x10"] = values.pop("torque_coefficient")
    found = _coefficients(table, values)
    known = np.isfinite(found.thrust_coefficient) | np.isfinite(found.torque_coefficient)
    there = np.isfinite(found.advance_ratio) & known
    if not there.all():
        first = int(np.argmin(there))
        why = "neither a thrust nor a torque coefficient follows from the row"
        if np.isnan(found.advance_ratio[first]):
            stands = {"speed", "shaft_speed"} <= table.readings[first].values.keys()
            why = "no advance ratio, and no speed with shaft speed to compute it from"
            why = "the shaft stands still, J = V / (n D) is not defined" if stands else why
        without = [table.readings[at].row for at in np.flatnonzero(~there)]
        problems.append(block.place(without[0]).warning(f"{why}; left out: {listed(without)}."))
    readings = [table.readings[at] for at in np.flatnonzero(there)]
    found = found.of(there)
    row = np.array([one.row for one in readings], dtype=np.int64)
    odd = _beyond(table, row, found)
    marks = [(*one.marks, *more) for one, more in zip(readings, odd, strict=True)]
    used = np.array([not own for own in marks], np.bool_)
    rows = _Rows(row, {name: own[there] for name, own in values.items()}, found, used).counting()
    problems += _cross_check(table, rows)
    unclear = (
        [*_impossible(table, rows)] or [*_two_curves(table, rows)] or [*_too_early(table, rows)]
    )
    problems += unclear
    if any(one.severity == "error" for one in unclear):
        return
    for at, own in enumerate(marks):
        yield OpenWaterPoint(
            source=Source(file=block.sheet.file, sheet=block.sheet.name, row=int(row[at])),
            advance_ratio=float(found.advance_ratio[at]),
            thrust_coefficient=_or_none(found.thrust_coefficient[at]),
            torque_coefficient=_or_none(found.torque_coefficient[at]),
            marks=own,
        )


def _or_none(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _notes(table: Table) -> Iterator[Problem]:
    """Say what was assumed of the columns."""
    block, vehicle = table.block, table.vehicle
    there = set(block.columns)
    raw = [
        name.replace("_", " ")
        for name, stated in (
            ("thrust", {"thrust_coefficient"}),
            ("torque", {"torque_coefficient", "torque_coefficient_x10", "power_coefficient"}),
        )
        if name in there and not there & stated
    ]
    if raw:
        yield block.place(block.header_row).note(
            f"{' and '.join(raw)} made a coefficient with density "
            f"{vehicle.water.density_kgpm3:g} kg/m^3 and diameter "
            f"{vehicle.propeller.diameter_m:g} m of vehicle.yaml."
        )
    if "power_coefficient" in there:
        place = block.place(block.header_row, "power_coefficient")
        yield place.note(
            "C_P = P / (rho n^3 D^5) and C_T = T / (rho n^2 D^4) are assumed: K_Q = C_P / 2 pi, "
            "K_T = C_T, whatever the fluid."
        )


def _beyond(table: Table, row: IntArray, found: Coefficients) -> list[tuple[str, ...]]:
    """Mark impossible coefficients and advance ratios; return the marks of each row."""
    large = found.are_impossible
    far = np.abs(found.advance_ratio) > _LARGEST_ADVANCE_RATIO
    # where many are, the column is another quantity, and what is small of it is no better
    none_is_sound = bool(large.sum() > _MOST_LARGE * len(large))
    rows = listed(row[large].tolist())
    what = f"K_T or K_Q beyond any propeller in {rows}; left out."
    if none_is_sound:
        what = f"K_T or K_Q beyond any propeller in {rows}; the table was left out."
    expected = "K_T = T / (rho n^2 D^4), K_Q = Q / (rho n^2 D^5); no thrust loading C_Th."
    rows = listed(row[far].tolist())
    fast = f"advance ratio above {_LARGEST_ADVANCE_RATIO:g} in {rows}; left out."
    remedy = "Check the units of speed and shaft speed, and the diameter in vehicle.yaml."
    for wrong, said in ((large, (what, expected, _CHECK_COLUMN)), (far, (fast, "", remedy))):
        if wrong.any():
            table.problems.append(table.at(int(row[np.argmax(wrong)])).warning(*said))
    return [
        ("advance ratio beyond any propeller",)
        if is_far
        else ("coefficient beyond any propeller",) * (none_is_sound or is_large)
        for is_far, is_large in zip(far.tolist(), large.tolist(), strict=True)
    ]


def _against_raw(table: Table, rows: _Rows) -> Iterator[Problem]:
    """Compare coefficients that the table states with those of its thrust, torque and speed."""
    for name, raw, stated_by in (
        ("advance_ratio", "speed", ("advance_ratio",)),
        ("thrust_coefficient", "thrust", ("thrust_coefficient",)),
        ("torque_coefficient", "torque", tuple(TORQUE_FACTORS)),
    ):
        bare = {key: own for key, own in rows.values.items() if key not in stated_by}
        own, stated = getattr(_coefficients(table, bare), name), getattr(rows.found, name)
        given = [rows.values[one] for one in stated_by if one in rows.values]
        there = np.isfinite(own) & np.isfinite(given).any(axis=0) & (stated != 0.0)
        ratio = float(np.median(own[there] / stated[there])) if there.any() else 1.0
        if abs(ratio - 1.0) > _MOST_APART:
            what = f"the {raw} gives {ratio:.3g} times the {name.replace('_', ' ')} that is stated."
            expected = "thrust, torque and coefficients of one propeller in one water."
            yield table.at(table.head).warning(what, expected, _CHECK_COLUMN)


def _too_early(table: Table, rows: _Rows) -> Iterator[Problem]:
    """Refuse an advance coefficient that may be V / (pi n D), unless vehicle.yaml has its scale."""
    column = table.block.columns.get("advance_ratio")
    stated = table.vehicle.columns.open_water.advance_ratio
    if column is None or (stated is not None and "scale" in stated.model_fields_set):
        return
    is_called_j = bool({"j", "jv"} & set(plain(column.header).split()))
    if why := ends_too_early(rows.found, is_called_j=is_called_j):
        yield table.at(table.head, "advance_ratio").error(
            f'"{shorten(column.header)}": {why}, as of no screw; it may be lambda = V / (pi n D), '
            "not J = V / (n D). So the table was left out.",
            "an advance coefficient that is known.",
            "State it in vehicle.yaml (scale: 1 for J):\n  columns:\n    open_water:\n"
            f'      advance_ratio: {{header: "{shorten(column.header)}", scale: 3.14159}}',
        )


def _impossible(table: Table, rows: _Rows) -> Iterator[Problem]:
    if why := impossible(rows.found):
        what, expected = f"{why}. So the table was left out.", "readings of a turning propeller."
        yield table.at(table.head).error(what, expected, _CHECK_SIGN)


def _two_curves(table: Table, rows: _Rows) -> Iterator[Problem]:
    """Refuse a table whose readings lie to both sides of one curve, as a column parts them."""
    known = np.isfinite(rows.found.thrust_coefficient)
    if known.sum() < _LEAST_OF_TWO:
        return
    row = rows.number[known]
    ratio, k_t = rows.found.advance_ratio[known], rows.found.thrust_coefficient[known]
    off = k_t - np.polyval(np.polyfit(ratio, k_t, min(3, len(np.unique(ratio)) - 1)), ratio)
    scatter, largest = float(off.std()), float(np.abs(k_t).max())
    sides = row[off < -scatter].tolist(), row[off > scatter].tolist()
    head = column_that_parts(table.block, *sides) if scatter > _MOST_SCATTER * largest else ""
    if head:
        yield table.at(table.head).error(
            f'column "{head}" parts the rows, and K_T lies on curves '
            f"{200.0 * scatter / largest:.0f} % apart. So the table was left out.",
            "one characteristic in a table.",
            "State in vehicle.yaml which rows are meant:\n  columns:\n    open_water:\n"
            f'      only: {{"{head}": ...}}',
        )


def _cross_check(table: Table, rows: _Rows) -> Iterator[Problem]:
    """Compare with the efficiency column; without one, look for what cannot be true."""
    yield from _against_raw(table, rows)
    check = check_efficiency(rows.found.efficiency, rows.values["efficiency"])
    if pitch := far_from_pitch(rows.found, table.vehicle.propeller.pitch_ratio):
        what = (
            f"{pitch}: the speed or the shaft speed is in another unit, or the propeller another."
        )
        yield table.at(table.head).warning(what, "", _CHECK_SIGN)
    if check is None:
        if text := doubt(rows.found):
            yield table.at(table.head).warning(f"{text}", "", _CHECK_COLUMN)
        return
    if check.suspicion:
        yield table.at(table.head, "efficiency").warning(
            f"J K_T / (2 pi K_Q) is {check.ratio:.3g} times the efficiency column: "
            f"{check.suspicion}",
            "the same efficiency.",
            _CHECK_COLUMN,
        )
    if check.outliers:
        odd = rows.number[list(check.outliers)].tolist()
        what = f"the efficiency column does not follow from J, K_T and K_Q in {listed(odd)}."
        yield table.at(odd[0], "efficiency").warning(what)


_CHECK_SIGN = (
    "Correct the units, or state in vehicle.yaml the column, its unit and its sign:\n  columns:\n"
    '    open_water:\n      thrust: {header: "...", unit: ..., sign: -1}'
)
_CHECK_COLUMN = (
    "Correct the header, or state the column in vehicle.yaml under columns: open_water "
    "(a torque_coefficient whose header starts with 10 is divided by 10)."
)


def _summary(_table: Table, points: Sequence[OpenWaterPoint]) -> str:
    ratios = [point.advance_ratio for point in points]
    parts = [counted(len(points), "point"), f"J {min(ratios):.3g} to {max(ratios):.3g}"]
    for name, values in (
        ("K_T", [point.thrust_coefficient for point in points]),
        ("K_Q", [point.torque_coefficient for point in points]),
    ):
        numbers = [value for value in values if value is not None]
        parts.append(
            f"{name} {max(numbers):.3g} to {min(numbers):.3g}" if numbers else f"no {name}"
        )
    static = sum(ratio == 0.0 for ratio in ratios)
    if static:
        parts.append(f"{static} at rest")
    marked = sum(bool(point.marks) for point in points)
    if marked:
        parts.append(f"{marked} left out")
    return ", ".join(parts)


def _curves_of(points: Sequence[OpenWaterPoint]) -> dict[Hashable, dict[float, float]]:
    both = [(one.advance_ratio, one.thrust_coefficient) for one in points]
    return {"": {ratio: k_t for ratio, k_t in both if k_t is not None}}


_KIND = Kind(
    Wanted(
        "open_water",
        (("advance_ratio", "speed"), ("thrust_coefficient", *TORQUE_FACTORS, "thrust", "torque")),
    ),
    "table of K_T or K_Q against J, or of thrust or torque against speed and shaft speed",
    points=_points,
    summary=_summary,
    compared=("K_T", _curves_of),
)
