"""From the readings of one mooring file to points: code, sign, tare, sweep, and what is odd."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.mooring_signs import signed_shaft_speed, signed_thrust
from pipeline.ingest.mooring_sweeps import Sweep, sweeps, tare
from pipeline.ingest.readings import Reading
from pipeline.ingest.rows import listed
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint
from pipeline.types import BoolArray, FloatArray

#: Share of the largest thrust above which a tare, or its change, is worth a word.
_LARGE_TARE_SHARE = 0.05


@dataclass(frozen=True)
class MooringTable:
    """The readings of one sheet, in the order of its rows.

    `nominal_voltage_v` is what the sheet is named after, `sense` what its heading says of the
    sweep, if anything.
    """

    place: Place
    readings: tuple[Reading, ...]
    nominal_voltage_v: float | None = None
    sense: Sweep | None = None
    thruster: str | None = None


@dataclass(frozen=True)
class MooringFile:
    """What became of one file.

    `points` has one entry a table, empty for one that could not be used. `tare_drift_n` is None
    without two zero readings in one table.
    """

    points: tuple[tuple[MooringPoint, ...], ...]
    problems: tuple[Problem, ...]
    tare_drift_n: float | None


@dataclass(frozen=True)
class _Coded:
    """A table whose readings have a code and a thrust, still with its tare."""

    place: Place
    readings: tuple[Reading, ...]
    codes: FloatArray
    thrust_n: FloatArray
    position: FloatArray
    nominal_voltage_v: float | None
    sense: Sweep | None

    @property
    def used(self) -> BoolArray:
        """Where nothing speaks against the reading."""
        return np.array([not reading.marks for reading in self.readings], bool)

    @property
    def is_zero(self) -> BoolArray:
        """Where the reading is one of the tare."""
        return np.asarray(self.used & (self.codes == 0.0))


def points_of_file(tables: Sequence[MooringTable]) -> MooringFile:
    """Turn the tables of one file into points.

    Parameters
    ----------
    tables : sequence of MooringTable
        In the order of the workbook, which is taken for the order of measurement.

    Returns
    -------
    MooringFile
        Points of the tables that could be used, and every problem.

    Notes
    -----
    Tare: the readings at code 0 of the table itself, interpolated linearly over the order of rows
    and constant outside; a table without one uses those of the whole file; a file without one is
    left as it is, with a note. A reading at code 0 is marked: its residual is zero by construction.
    """
    problems: list[Problem] = []
    all_coded: list[_Coded | None] = []
    start = 0
    for table in tables:
        all_coded.append(_with_codes(table, start))
        start += len(table.readings)
    coded = [one for one in all_coded if one is not None]
    zeros = [(one.position[one.is_zero], one.thrust_n[one.is_zero]) for one in coded]
    everywhere = (
        np.concatenate([np.zeros(0), *(positions for positions, _ in zeros)]),
        np.concatenate([np.zeros(0), *(readings for _, readings in zeros)]),
    )
    if any(one.used.any() for one in coded) and len(everywhere[0]) == 0:
        what = "there is no reading at code 0: the tare of the force sensor is not removed."
        remedy = "Take one before and one after each sweep."
        problems.append(Problem("note", Place(coded[0].place.file), what, "", remedy))
    points: list[tuple[MooringPoint, ...]] = []
    drifts = [float(np.ptp(readings)) for _, readings in zeros if len(readings) > 1]
    own = iter(zeros)
    for one in all_coded:
        if one is None:
            points.append(())
            continue
        zero = next(own)
        points.append(_points(one, zero if len(zero[0]) else everywhere, problems))
    return MooringFile(tuple(points), tuple(problems), max(drifts, default=None))


def _with_codes(table: MooringTable, start: int) -> _Coded | None:
    """Keep the readings with a code and a thrust; None where there are none."""
    kept: list[Reading] = []
    codes: list[float] = []
    position: list[int] = []
    for index, reading in enumerate(table.readings):
        values = reading.values
        if "code" not in values or "thrust" not in values:
            continue
        kept.append(reading)
        codes.append(values["code"])
        position.append(start + index)
    if not kept:
        return None
    return _Coded(
        table.place,
        tuple(kept),
        np.array(codes),
        np.array([reading.values["thrust"] for reading in kept]),
        np.array(position, float),
        table.nominal_voltage_v,
        table.sense,
    )


def _points(
    table: _Coded,
    zeros: tuple[FloatArray, FloatArray],
    problems: list[Problem],
) -> tuple[MooringPoint, ...]:
    tare_n = tare(table.position, *zeros)
    raw_n = table.thrust_n - tare_n
    used = table.used
    _report_tare(table, zeros[1], raw_n, used, problems)
    rows = [reading.row for reading in table.readings]
    at_rest = float(np.median(zeros[1])) if len(zeros[1]) else 0.0
    signs = signed_thrust(table.place, table.codes, raw_n, used, rows, tare_n=at_rest)
    problems += signs.problems
    if signs.thrust_n is None:
        return ()
    speeds = [reading.values.get("shaft_speed") for reading in table.readings]
    shaft_speed_rpm, notes = signed_shaft_speed(table.place, table.codes, speeds)
    problems += notes
    senses = _senses(table.codes, used, table.sense)
    copies = _copies(table)
    if copies:
        problems.append(
            Problem(
                "warning",
                _at(table.place, copies[0]),
                f"every value of the row above stands again in {listed(copies)}; left out.",
                remedy="Delete the copies.",
            )
        )
    points = []
    for index, reading in enumerate(table.readings):
        marks = list(reading.marks)
        if reading.row in copies:
            marks.append("duplicate")
        if index in signs.against:
            marks.append("thrust against the code")
        if table.codes[index] == 0.0 and not marks:
            marks.append("zero reading")
        points.append(
            MooringPoint(
                source=Source(file=table.place.file, sheet=table.place.sheet, row=reading.row),
                code=float(table.codes[index]),
                thrust_n=float(signs.thrust_n[index]),
                tare_n=float(tare_n[index]) * signs.tare_signs[index] + 0.0,  # no -0.0
                shaft_speed_rpm=shaft_speed_rpm[index],
                voltage_v=reading.values.get("voltage", table.nominal_voltage_v),
                current_a=reading.values.get("current"),
                sweep=senses[index],
                marks=tuple(marks),
            )
        )
    return tuple(points)


def _report_tare(
    table: _Coded,
    zero_n: FloatArray,
    thrust_n: FloatArray,
    used: BoolArray,
    problems: list[Problem],
) -> None:
    """Warn where the tare, or its change, is not small against the thrust."""
    if len(zero_n) == 0 or not used.any():
        return
    largest_n = float(np.max(np.abs(thrust_n[used])))
    tare_n, drift_n = float(np.max(np.abs(zero_n))), float(np.ptp(zero_n))
    if largest_n > 0.0 and max(tare_n, drift_n) > _LARGE_TARE_SHARE * largest_n:
        problems.append(
            Problem(
                "warning",
                table.place,
                f"the reading at code 0 is up to {tare_n:.3g} N and changes by {drift_n:.3g} N, "
                f"the largest thrust is {largest_n:.3g} N; it was removed by interpolation.",
                "a tare that is small against the thrust.",
                "Zero the force sensor and let it warm up.",
            )
        )


def _senses(codes: FloatArray, used: BoolArray, stated: Sweep | None) -> tuple[Sweep, ...]:
    """Tell the sweeps from the rows that are used; the others take that of the row before."""
    if stated is not None:
        return (stated,) * len(codes)
    senses = iter(sweeps(codes[used].tolist()))
    found: list[Sweep] = []
    for is_used in used:
        found.append(next(senses) if is_used else (found[-1] if found else "up"))
    return tuple(found)


def _copies(table: _Coded) -> list[int]:
    """Rows that repeat the one above in all values: pasted twice, not measured twice.

    Only where at least three quantities agree: thrust alone, read coarsely, may well repeat.
    """
    return [
        reading.row
        for before, reading, code in zip(
            table.readings, table.readings[1:], table.codes[1:], strict=False
        )
        if code != 0.0
        and len(reading.values) >= 3
        and not reading.marks
        and reading.values == before.values
    ]


def _at(place: Place, row: int) -> Place:
    return Place(place.file, place.sheet, row)
