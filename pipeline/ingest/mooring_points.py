"""From the readings of one mooring file to points: code, sign, tare, sweep, and what is odd."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.mooring_signs import signed_shaft_speed, signed_thrust
from pipeline.ingest.mooring_sweeps import Sweep, sweeps, tare
from pipeline.ingest.repeats import BenchTable, pasted_rows
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint
from pipeline.types import BoolArray, FloatArray

#: Share of the largest thrust above which a tare, or its change, is worth a word.
_LARGE_TARE_SHARE = 0.05


def points_of_file(
    tables: Sequence[BenchTable], problems: list[Problem]
) -> list[tuple[MooringPoint, ...]]:
    """Turn the tables of one file into points, none of a table that cannot be used.

    The order of the tables in a workbook is taken for the order of measurement.

    Notes
    -----
    Tare: the readings at code 0 of the table itself, interpolated linearly over the order of rows
    and constant outside; a table without one uses those of the whole file; a file without one is
    left as it is, with a note. A reading at code 0 is marked: its residual is zero by construction.
    """
    zeros: list[tuple[FloatArray, FloatArray]] = []
    start = 0
    for table in tables:
        at = [number for number, one in enumerate(table.readings) if one.is_zero]
        thrust_n = [table.readings[number].values["thrust"] for number in at]
        zeros.append((np.array(at, float) + start, np.array(thrust_n, float)))
        start += len(table.readings)
    everywhere = (
        np.concatenate([np.zeros(0), *(positions for positions, _ in zeros)]),
        np.concatenate([np.zeros(0), *(readings for _, readings in zeros)]),
    )
    if any(not one.marks for table in tables for one in table.readings) and not everywhere[0].size:
        what = "there is no reading at code 0: the tare of the force sensor is not removed."
        remedy = "Take one before and one after each sweep."
        problems.append(Problem("note", Place(tables[0].place.file), what, "", remedy))
    points: list[tuple[MooringPoint, ...]] = []
    start = 0
    for table, own in zip(tables, zeros, strict=True):
        position = np.arange(start, start + len(table.readings), dtype=float)
        start += len(table.readings)
        tares = own if own[0].size else everywhere
        points.append(_points(table, position, tares, problems) if table.readings else ())
    return points


def _points(
    table: BenchTable,
    position: FloatArray,
    zeros: tuple[FloatArray, FloatArray],
    problems: list[Problem],
) -> tuple[MooringPoint, ...]:
    codes, thrust_n = (
        np.array([one.values[name] for one in table.readings]) for name in ("code", "thrust")
    )
    used = np.array([not one.marks for one in table.readings])
    tare_n = tare(position, *zeros)
    raw_n = thrust_n - tare_n
    _report_tare(table.place, zeros[1], raw_n[used], problems)
    rows = [reading.row for reading in table.readings]
    at_rest = float(np.median(zeros[1])) if len(zeros[1]) else 0.0
    signs = signed_thrust(table.place, codes, raw_n, used, rows, tare_n=at_rest)
    problems += signs.problems
    if signs.thrust_n is None:
        return ()
    speeds = [reading.values.get("shaft_speed") for reading in table.readings]
    shaft_speed_rpm, notes = signed_shaft_speed(table.place, codes, speeds)
    problems += notes
    senses = _senses(codes, used, table.sense)
    copies = pasted_rows(table.place, table.readings, problems)
    points = []
    for index, reading in enumerate(table.readings):
        marks = list(reading.marks)
        if reading.row in copies:
            marks.append("duplicate")
        if index in signs.against:
            marks.append("thrust against the code")
        if codes[index] == 0.0 and not marks:
            marks.append("zero reading")
        points.append(
            MooringPoint(
                source=Source(file=table.place.file, sheet=table.place.sheet, row=reading.row),
                code=float(codes[index]),
                thrust_n=float(signs.thrust_n[index]),
                tare_n=float(tare_n[index]) * signs.tare_signs[index] + 0.0,  # no -0.0
                speed_mps=reading.values.get("speed", 0.0),
                shaft_speed_rpm=shaft_speed_rpm[index],
                voltage_v=reading.values.get("voltage", table.nominal_voltage_v),
                current_a=reading.values.get("current"),
                sweep=senses[index],
                marks=tuple(marks),
            )
        )
    return tuple(points)


def _report_tare(
    place: Place, zero_n: FloatArray, thrust_n: FloatArray, problems: list[Problem]
) -> None:
    """Warn where the tare, or its change, is not small against the thrust of the rows used."""
    if len(zero_n) == 0 or not thrust_n.size:
        return
    largest_n = float(np.max(np.abs(thrust_n)))
    tare_n, drift_n = float(np.max(np.abs(zero_n))), float(np.ptp(zero_n))
    if largest_n > 0.0 and max(tare_n, drift_n) > _LARGE_TARE_SHARE * largest_n:
        what = (
            f"the reading at code 0 is up to {tare_n:.3g} N and changes by {drift_n:.3g} N, "
            f"the largest thrust is {largest_n:.3g} N; it was removed by interpolation."
        )
        expected = "a tare that is small against the thrust."
        remedy = "Zero the force sensor and let it warm up."
        problems.append(Problem("warning", place, what, expected, remedy))


def _senses(codes: FloatArray, used: BoolArray, stated: Sweep | None) -> tuple[Sweep, ...]:
    """Tell the sweeps from the rows that are used; the others take that of the row before."""
    if stated is not None:
        return (stated,) * len(codes)
    senses = iter(sweeps(codes[used].tolist()))
    found: list[Sweep] = []
    for is_used in used:
        found.append(next(senses) if is_used else (found[-1] if found else "up"))
    return tuple(found)
