"""Open-water tests: K_T and K_Q (the papers' K_M) against the advance ratio."""

import contextlib
import math
import re
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.errors import Problem
from pipeline.ingest.bench_file import BenchFile
from pipeline.ingest.bench_kind import Kind, read_files
from pipeline.ingest.bench_table import Reading, Table
from pipeline.ingest.cells import shorten
from pipeline.ingest.open_water_coefficients import (
    TORQUE_FACTORS,
    Coefficients,
    EfficiencyCheck,
    NoCoefficientError,
    check_efficiency,
    coefficients,
    doubt,
    efficiency,
    far_from_pitch,
    impossible,
    over_pi,
)
from pipeline.ingest.row_directions import column_that_parts
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.vocabulary import plain
from pipeline.records.base import Source
from pipeline.records.measurements import OpenWaterPoint, OpenWaterRecord
from pipeline.vehicle.schema import Vehicle

_TEN_TIMES = re.compile(r"^\s*10\s*[·*×x]?\s*[A-Za-zА-Яа-я]|[·*×x]\s*10\s*$")
#: Outside of it an advance ratio is a mistake of units or of columns.
_LARGEST_ADVANCE_RATIO = 3.0
#: Share of the rows.
_MOST_LARGE = 0.2
#: Evidence in nats for V / (pi n D) in place of J: told of above, refused above.
_DOUBTED, _REFUSED = -0.7, 0.5
#: Scatter of K_T about one curve, a share of the largest; fewer readings are no two curves.
_MOST_SCATTER, _LEAST_OF_TWO = 0.04, 8
#: A coefficient that differs by more from its thrust is of another one.
_MOST_APART = 0.1


def read_open_water(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> OpenWaterRecord:
    """Read all open-water tests of a vehicle; sources are named relative to `raw_root`.

    Density of the water and diameter of the propeller are those of the vehicle file. A file that
    cannot be read is a problem of severity "error", and the others are read.
    """
    read = read_files(_KIND, paths, vehicle, raw_root)
    return OpenWaterRecord(points=read.points, sheets=read.sheets, problems=read.problems)


def _points(file: BenchFile) -> list[tuple[OpenWaterPoint, ...]]:
    return [tuple(_of_table(table)) for table in file.tables]


def _of_table(table: Table) -> list[OpenWaterPoint]:
    block, vehicle, problems = table.block, table.vehicle, table.problems
    problems += _notes(table)
    torque = block.columns.get("torque_coefficient")
    tenfold = torque is not None and _TEN_TIMES.search(torque.header) is not None
    rows: list[tuple[Reading, Coefficients]] = []
    without: list[tuple[int, str]] = []
    for reading in table.readings:
        values = dict(reading.values)
        if tenfold and "torque_coefficient" in values:
            # vehicle.yaml names a column "10KQ" as the torque coefficient.
            values["torque_coefficient_x10"] = values.pop("torque_coefficient")
        try:
            found = coefficients(values, vehicle.water.density_kgpm3, vehicle.propeller.diameter_m)
        except NoCoefficientError as error:
            without.append((reading.row, str(error)))
        else:
            rows.append((reading, found))
    if without:
        numbers = [row for row, _ in without]
        what = f"{without[0][1]}; left out: {listed(numbers)}."
        problems.append(block.place(numbers[0]).warning(what))
    marks = _marks(table, rows)
    good = [row for row, own in zip(rows, marks, strict=True) if not own]
    problems += _cross_check(table, good)
    unclear = _impossible(table, good) or _two_curves(table, good) or _advance_unclear(table, good)
    problems += unclear
    if any(one.severity == "error" for one in unclear):
        return []
    return [
        OpenWaterPoint(
            source=Source(file=block.sheet.file, sheet=block.sheet.name, row=reading.row),
            advance_ratio=found.advance_ratio,
            thrust_coefficient=found.thrust_coefficient,
            torque_coefficient=found.torque_coefficient,
            marks=own,
        )
        for (reading, found), own in zip(rows, marks, strict=True)
    ]


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


def _marks(table: Table, rows: Sequence[tuple[Reading, Coefficients]]) -> list[tuple[str, ...]]:
    """Mark impossible coefficients and advance ratios."""
    large = [reading.row for reading, found in rows if found.is_impossible]
    # where many are, the column is another quantity, and what is small of it is no better
    none_is_sound = len(large) > _MOST_LARGE * len(rows)
    far = [abs(found.advance_ratio) > _LARGEST_ADVANCE_RATIO for _, found in rows]
    beyond = [reading.row for (reading, _), is_far in zip(rows, far, strict=True) if is_far]
    marks = [
        (*reading.marks, "advance ratio beyond any propeller")
        if is_far
        else (*reading.marks, "coefficient beyond any propeller")
        if none_is_sound or found.is_impossible
        else reading.marks
        for (reading, found), is_far in zip(rows, far, strict=True)
    ]
    if large:
        what = f"K_T or K_Q beyond any propeller in {listed(large)}; left out."
        if none_is_sound:
            what = f"K_T or K_Q beyond any propeller in {listed(large)}; the table was left out."
        expected = "K_T = T / (rho n^2 D^4), K_Q = Q / (rho n^2 D^5); no thrust loading C_Th."
        table.problems.append(table.at(large[0]).warning(what, expected, _CHECK_COLUMN))
    if beyond:
        what = f"advance ratio above {_LARGEST_ADVANCE_RATIO:g} in {listed(beyond)}; left out."
        remedy = "Check the units of speed and shaft speed, and the diameter in vehicle.yaml."
        table.problems.append(table.at(beyond[0]).warning(what, "", remedy))
    return marks


def _against_raw(table: Table, used: Sequence[tuple[Reading, Coefficients]]) -> Iterator[Problem]:
    """Compare coefficients that the table states with those of its thrust, torque and speed."""
    water, propeller = table.vehicle.water, table.vehicle.propeller
    for name, raw, stated_by in (
        ("advance_ratio", "speed", frozenset({"advance_ratio"})),
        ("thrust_coefficient", "thrust", frozenset({"thrust_coefficient"})),
        ("torque_coefficient", "torque", frozenset(TORQUE_FACTORS)),
    ):
        ratios = []
        for reading, found in used:
            bare = {key: one for key, one in reading.values.items() if key not in stated_by}
            stated = getattr(found, name)
            if stated and raw in bare and not stated_by.isdisjoint(reading.values):
                with contextlib.suppress(NoCoefficientError, ZeroDivisionError):
                    own = coefficients(bare, water.density_kgpm3, propeller.diameter_m)
                    computed = getattr(own, name)
                    ratios += [] if computed is None else [computed / stated]
        ratio = float(np.median(ratios)) if ratios else 1.0
        if abs(ratio - 1.0) > _MOST_APART:
            what = f"the {raw} gives {ratio:.3g} times the {name.replace('_', ' ')} that is stated."
            expected = "thrust, torque and coefficients of one propeller in one water."
            yield table.at(table.head).warning(what, expected, _CHECK_COLUMN)


def _advance_unclear(table: Table, used: Sequence[tuple[Reading, Coefficients]]) -> list[Problem]:
    """Refuse an advance coefficient that may be V / (pi n D), unless vehicle.yaml has its scale."""
    column = table.block.columns.get("advance_ratio")
    stated = table.vehicle.columns.open_water.advance_ratio
    if column is None or (stated is not None and "scale" in stated.model_fields_set):
        return []
    words = set(plain(column.header).split())
    name = "lambda" if words & {"λ", "lambda"} else "J" if words & {"j", "jv"} else ""
    check = _efficiency_check(used)
    points = [one for _, one in used]
    if doubt(points):  # then its efficiency says nothing
        points = [replace(one, torque_coefficient=None) for one in points]
    score = over_pi(points, name, None if check is None else check.ratio)
    if score is None:  # the letter alone
        score = _DOUBTED if name == "lambda" else -math.inf
    if score < _DOUBTED:
        return []
    largest = max(abs(one.advance_ratio) for _, one in used) if used else 0.0
    what = (
        f'"{shorten(column.header)}" may be J = V / (n D), to {largest:.3g} here, or lambda = V / '
        f"(pi n D), which makes J to {math.pi * largest:.3g}"
    )
    line = f'advance_ratio: {{header: "{shorten(column.header)}", scale: 3.14159}}'
    remedy = (
        f"State it in vehicle.yaml (scale: 1 for J):\n  columns:\n    open_water:\n      {line}"
    )
    place = table.at(table.head, "advance_ratio")
    if score < _REFUSED:
        return [place.warning(f"{what}; J is taken.", "J = V / (n D).", remedy)]
    why = "K_T is zero so early, and the efficiency so small, as of no screw"
    said = f"{what}: {why}. So the table was left out."
    return [place.error(said, "an advance coefficient that is known.", remedy)]


def _impossible(table: Table, used: Sequence[tuple[Reading, Coefficients]]) -> list[Problem]:
    why = impossible([found for _, found in used])
    what, expected = f"{why}. So the table was left out.", "readings of a turning propeller."
    return [table.at(table.head).error(what, expected, _CHECK_SIGN)] if why else []


def _two_curves(table: Table, used: Sequence[tuple[Reading, Coefficients]]) -> list[Problem]:
    """Refuse a table whose readings lie to both sides of one curve, as a column parts them."""
    both = [(one.row, it.advance_ratio, it.thrust_coefficient) for one, it in used]
    known = np.array([one for one in both if one[2] is not None], float)
    if len(known) < _LEAST_OF_TWO:
        return []
    row, ratio, k_t = known.T
    off = k_t - np.polyval(np.polyfit(ratio, k_t, min(3, len(np.unique(ratio)) - 1)), ratio)
    scatter, largest = float(off.std()), float(np.abs(k_t).max())
    sides = (row[off < -scatter].astype(int).tolist(), row[off > scatter].astype(int).tolist())
    head = column_that_parts(table.block, *sides) if scatter > _MOST_SCATTER * largest else ""
    if not head:
        return []
    return [
        table.at(table.head).error(
            f'column "{head}" parts the rows, and K_T lies on curves '
            f"{200.0 * scatter / largest:.0f} % apart. So the table was left out.",
            "one characteristic in a table.",
            "State in vehicle.yaml which rows are meant:\n  columns:\n    open_water:\n"
            f'      only: {{"{head}": ...}}',
        )
    ]


def _cross_check(table: Table, used: Sequence[tuple[Reading, Coefficients]]) -> Iterator[Problem]:
    """Compare with the efficiency column; without one, look for what cannot be true."""
    yield from _against_raw(table, used)
    points = [found for _, found in used]
    check = _efficiency_check(used)
    pitch = far_from_pitch(points, table.vehicle.propeller.pitch_ratio)
    if pitch:
        what = (
            f"{pitch}: the speed or the shaft speed is in another unit, or the propeller another."
        )
        yield table.at(table.head).warning(what, "", _CHECK_SIGN)
    if check is None:
        text = doubt(points)
        if text:
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
        odd = [used[index][0].row for index in check.outliers]
        what = f"the efficiency column does not follow from J, K_T and K_Q in {listed(odd)}."
        yield table.at(odd[0], "efficiency").warning(what)


def _efficiency_check(used: Sequence[tuple[Reading, Coefficients]]) -> EfficiencyCheck | None:
    stated = [reading.values.get("efficiency", math.nan) for reading, _ in used]
    computed = [
        efficiency(found.advance_ratio, found.thrust_coefficient, found.torque_coefficient)
        if found.thrust_coefficient is not None and found.torque_coefficient is not None
        else math.nan
        for _, found in used
    ]
    return check_efficiency(computed, stated)


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
    name="open_water",
    looked_for=(
        "table of K_T or K_Q against J, or of thrust or torque against speed and shaft speed"
    ),
    required=(
        ("advance_ratio", "speed"),
        (
            *("thrust_coefficient", "torque_coefficient", "torque_coefficient_x10"),
            *("power_coefficient", "thrust", "torque"),
        ),
    ),
    points=_points,
    summary=_summary,
    compared=("K_T", _curves_of),
)
