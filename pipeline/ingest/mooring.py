"""Mooring (bollard) tables: thrust at rest against code or pulse width, from tables to points."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import BenchFile
from pipeline.ingest.bench_kind import Kind, read_files
from pipeline.ingest.bench_table import Step, Sweep, Table, numbers, stated_voltage
from pipeline.ingest.cells import Sheet, shorten
from pipeline.ingest.command_signs import signed_thrust
from pipeline.ingest.commands import (
    codes_in_range,
    command_in_codes,
    few_codes,
    pwm_note,
    pwm_problems,
)
from pipeline.ingest.header_rows import Wanted
from pipeline.ingest.log_files import is_log_anywhere
from pipeline.ingest.rig_factors import factor_unclear
from pipeline.ingest.row_directions import with_signed_codes
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.settled_steps import settle
from pipeline.ingest.thrust_checks import (
    curves_of,
    odd_sizes,
    saturated,
    shape_problem,
    thrust_problem,
)
from pipeline.ingest.vocabulary import pattern_of, plain, words_of
from pipeline.ingest.workbook import read_sheets
from pipeline.records.base import Source
from pipeline.records.measurements import IN_A_FLOW, MooringPoint, MooringRecord
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import is_at_supply, voltage_groups
from pipeline.vehicle.schema import Vehicle

#: Share of the largest thrust above which a tare, or its change, is worth a word.
_LARGE_TARE_SHARE = 0.05


def points_of_file(tables: Sequence[Table]) -> list[tuple[MooringPoint, ...]]:
    """Turn the tables of one file into points, none of a table that cannot be used.

    The order of the tables in a workbook is taken for the order of measurement.

    Notes
    -----
    Tare: the readings at code 0 of the table itself, interpolated linearly over the order of rows
    and constant outside; a table without one uses those of the whole file; a file without one is
    left as it is, with a note. A reading at code 0 is marked: its residual is zero by construction.
    """
    every = [(table, one) for table in tables for one in table.readings]
    thrust_n = numbers((one for _, one in every), "thrust")
    zero = np.array([one.is_zero for _, one in every], np.bool_)
    if any(table.live() for table in tables) and not zero.any():
        what = "there is no reading at code 0: the tare of the force sensor is not removed."
        remedy = "Take one before and one after each sweep."
        tables[0].problems.append(replace(tables[0].place, sheet=None).note(what, "", remedy))
    points: list[tuple[MooringPoint, ...]] = []
    for table in tables:
        own = np.array([one is table for one, _ in every], np.bool_)
        at = np.flatnonzero(zero & own if (zero & own).any() else zero)
        tares = at.astype(float), thrust_n[at]
        points.append(
            _points_of(table, np.flatnonzero(own).astype(float), tares) if own.any() else ()
        )
    return points


def _points_of(
    table: Table, position: FloatArray, zeros: tuple[FloatArray, FloatArray]
) -> tuple[MooringPoint, ...]:
    codes, thrust_n = numbers(table.readings, "code"), numbers(table.readings, "thrust")
    used = np.array([not one.marks for one in table.readings])
    tare_n = tare(position, *zeros)
    raw_n = thrust_n - tare_n
    _report_tare(table, zeros[1], raw_n[used])
    at_rest = float(np.median(zeros[1])) if len(zeros[1]) else 0.0
    turned = signed_thrust(table, codes, raw_n, used, at_rest)
    if turned is None:
        return ()
    signs, against = turned
    # at rest in the water a shaft turns as it is told, whatever the sign of its sensor
    speeds = np.abs(numbers(table.readings, "shaft_speed")) * np.where(codes < 0.0, -1.0, 1.0)
    told = iter(sweeps(codes[used].tolist()))
    sweep: Sweep = "up"
    points = []
    for at, one in enumerate(table.readings):
        # those that are not used take that of the row before
        sweep = next(told) if used[at] else sweep
        marks = (*one.marks, *("thrust against the code",) * bool(against[at]))
        points.append(
            MooringPoint(
                source=Source(file=table.place.file, sheet=table.place.sheet, row=one.row),
                code=float(codes[at]),
                thrust_n=float(raw_n[at] * signs[at]),
                tare_n=float(tare_n[at]) * float(signs[at]) + 0.0,  # no -0.0
                speed_mps=one.values.get("speed", 0.0),
                shaft_speed_rpm=None if np.isnan(speeds[at]) else float(speeds[at]) + 0.0,
                voltage_v=one.values.get("voltage", table.nominal_voltage_v),
                current_a=one.values.get("current"),
                thruster=table.block.thruster,
                sweep=table.sense or sweep,
                marks=marks or ("zero reading",) * bool(codes[at] == 0.0),
            )
        )
    return tuple(points)


def _report_tare(table: Table, zero_n: FloatArray, thrust_n: FloatArray) -> None:
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
        table.problems.append(table.place.warning(what, expected, remedy))


def sweeps(codes: Sequence[float]) -> tuple[Sweep, ...]:
    """Tell for each reading, in the order taken, whether the size of the code rose or fell.

    A reading at the same code as the one before belongs to the same sweep; the first one takes
    the sense of what follows; a change of sign passes zero, so what follows it rises.

    >>> sweeps([0, 40, 80, 80, 40, 0, -40])
    ('up', 'up', 'up', 'up', 'down', 'down', 'up')
    >>> sweeps([-80, -40, 0, 40])
    ('down', 'down', 'down', 'up')
    """
    found: list[Sweep | None] = []
    for index, code in enumerate(codes):
        before = codes[index - 1] if index else code
        if index == 0 or code == before:
            found.append(found[-1] if found else None)
        elif code * before < 0 or abs(code) > abs(before):
            found.append("up")
        else:
            found.append("down")
    first: Sweep = next((sense for sense in found if sense is not None), "up")
    return tuple(first if sense is None else sense for sense in found)


def tare(
    positions: FloatArray, zero_positions: FloatArray, zero_readings: FloatArray
) -> FloatArray:
    """Interpolate what was read at code 0 (k,) over the order of rows (n,), constant outside.

    >>> tare(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 2.0]), np.array([0.1, 0.3])).round(3)
    array([0.1, 0.2, 0.3, 0.3])
    """
    if not len(zero_positions):
        return np.zeros(len(positions))
    return np.interp(positions, zero_positions, zero_readings)


def hysteresis(points: Sequence[MooringPoint]) -> float | None:
    """Return the mean thrust of falling sweeps less that of rising ones. [N].

    At equal code and voltage, over the codes that were passed both ways; None if there are none.
    Thrust counts in the sense of the code, so that both directions add up.
    """
    groups = voltage_groups(point.voltage_v for point in points if point.voltage_v is not None)
    held: dict[tuple[float, float | None], dict[Sweep, list[float]]] = defaultdict(
        lambda: {"up": [], "down": []}
    )
    for point in points:
        volts = point.voltage_v
        if point.code != 0.0:
            within = (low for low, high in groups if volts is not None and low <= volts <= high)
            size = point.thrust_n if point.code > 0 else -point.thrust_n
            held[(round(point.code, 6), next(within, None))][point.sweep].append(size)
    differences = [
        float(np.mean(both["down"]) - np.mean(both["up"]))
        for both in held.values()
        if both["up"] and both["down"]
    ]
    return float(np.mean(differences)) if differences else None


_UP, _DOWN = words_of("directions", "up"), words_of("directions", "down")
#: Slower than this is rest. [m/s]
_AT_REST_MPS = 0.05


def read_mooring_tables(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> MooringRecord:
    """Read all mooring tables of a vehicle; sources are named relative to `raw_root`.

    A file that cannot be read is a problem of severity "error", and the others are read. Order of
    rows is taken for order of measurement: it tells rising sweeps from falling ones and carries the
    tare between its readings at code 0.
    """
    read = read_files(_KIND, paths, vehicle, raw_root)
    # what each table reads at code 0
    zeros = [
        [one.values["thrust"] for one in table.readings if one.is_zero] for table in read.tables
    ]
    return MooringRecord(
        points=read.points,
        sheets=read.sheets,
        problems=read.problems,
        hysteresis_n=hysteresis([point for point in read.points if not point.marks]),
        tare_drift_n=max((float(np.ptp(one)) for one in zeros if len(one) > 1), default=None),
    )


def _sheets(path: Path, shown_as: str, vehicle: Vehicle) -> tuple[Sheet, ...]:
    """Open a workbook, a text table, or a log in which thrust was measured."""
    if not is_log_anywhere(path.name):
        return read_sheets(path, shown_as)
    # the reader of logs takes a while to load
    from pipeline.ingest.thrust_log import read_thrust_log

    return read_thrust_log(path, shown_as, vehicle)


def _at_rest(table: Table) -> Iterator[Problem]:
    """Mark the readings that were taken in a flow."""
    title = table.texts[-1]
    if "speed" not in table.block.columns and pattern_of("flow").search(title):
        yield table.at(table.head).warning(
            f'"{shorten(title)}" states a speed, and there is no column of it: the thrust is taken '
            "for that at rest.",
            "thrust at rest, or the speed of the water beside it.",
            "If the water flowed, write a column of its speed.",
        )
    moving = [one.row for one in table.readings if abs(one.values.get("speed", 0.0)) > _AT_REST_MPS]
    if moving:
        table.mark(set(moving), IN_A_FLOW)
        yield table.at(moving[0], "speed").note(
            f"the water flowed at the thruster in {listed(moving)}: these rows are not at rest. "
            "They correct the thrust at speed, where code and speed have the same sign."
        )


def _voltage_and_sense(table: Table) -> tuple[Problem, ...]:
    """Tell the voltage and the sense of a sweep from the headings."""
    down, up = _told(table.texts, _DOWN, _UP), _told(table.texts, _UP, _DOWN)
    table.sense = "down" if down else "up" if up else None
    stated = stated_voltage(table.texts)
    table.nominal_voltage_v = None if "voltage" in table.block.columns else stated
    return ()


_STEPS: tuple[Step, ...] = (
    *(factor_unclear, pwm_problems, command_in_codes, settle, _at_rest, with_signed_codes),
    *(codes_in_range, _voltage_and_sense),
)


def _take_steps(file: BenchFile) -> None:
    for table in file.tables:
        table.take(_STEPS)


def _points(file: BenchFile) -> list[tuple[MooringPoint, ...]]:
    of_tables = points_of_file(file.tables)
    for at, table in enumerate(file.tables):
        found = [shape_problem(table, of_tables[at])]
        # a check of a file alone: no vehicle file says how large the propeller is
        if table.vehicle.name != "unknown":
            found.append(thrust_problem(table, of_tables[at]))
        said = [problem for problem in found if problem is not None]
        said += saturated(table, of_tables[at])
        said += () if found[0] else odd_sizes(table, of_tables[at])
        file.problems += said
        if any(problem.severity == "error" for problem in said):
            of_tables[at] = ()
    if any("code" not in table.block.columns for table in file.tables):
        file.problems.append(pwm_note(file.place, file.vehicle))
    return of_tables


def _told(texts: Sequence[str], words: Sequence[str], opposite: Sequence[str]) -> bool:
    """Tell whether the first text that has a word of either list has one of `words` alone.

    >>> _told(["Power up"], _UP, _DOWN), _told(["Set-up 2, codes up"], _UP, _DOWN)
    (False, True)
    """
    for text in texts:
        found = set(pattern_of("of_the_rig").sub(" ", plain(text)).split())
        here, there = found & {plain(w) for w in words}, found & {plain(w) for w in opposite}
        if here or there:
            return bool(here) and not there
    return False


def _summary(_table: Table, points: Sequence[MooringPoint]) -> str:
    codes = [point.code for point in points]
    thrust = [point.thrust_n for point in points]
    parts = [
        counted(len(points), "point"),
        f"codes {min(codes):g} to {max(codes):g}",
        f"{min(thrust):.3g} to {max(thrust):.3g} N",
    ]
    groups = voltage_groups(point.voltage_v for point in points if point.voltage_v is not None)
    parts += [f"{low:g} V" if low == high else f"{low:.3g}-{high:.3g} V" for low, high in groups]
    senses = {point.sweep for point in points if not point.marks}
    if senses == {"up", "down"}:
        parts.append("rising and falling")
    flown = sum(point.marks == (IN_A_FLOW,) for point in points)
    if flown:
        parts.append(f"{flown} in a flow")
    marked = sum(bool(set(point.marks) - {"zero reading"}) for point in points) - flown
    if marked:
        parts.append(f"{marked} left out")
    return ", ".join(parts)


def _over_all(fitted: Sequence[MooringPoint], folder: Place, vehicle: Vehicle) -> Iterator[Problem]:
    """Say what only all files together show: supply voltages, too few codes."""
    yield from few_codes([point.code for point in fitted], folder, vehicle)
    groups = voltage_groups(point.voltage_v for point in fitted if point.voltage_v is not None)
    wanted = vehicle.tables.supply_voltage_v
    named = ", ".join(f"{(low + high) / 2:.3g}" for low, high in groups)
    if wanted is None and len(groups) > 1:
        what = f"taken at several supply voltages ({named} V), and none is stated for the tables."
        remedy = "State tables: supply_voltage_v in vehicle.yaml."
        yield folder.warning(what, "one supply voltage.", remedy)
    elif wanted is not None and groups:
        known = [point.voltage_v for point in fitted if point.voltage_v is not None]
        between = min(known) < wanted < max(known)
        if not between and not any(is_at_supply(voltage_v, wanted) for voltage_v in known):
            what = (
                f"no point at the supply voltage of the tables, {wanted:g} V; there is {named} V."
            )
            remedy = "Correct tables: supply_voltage_v in vehicle.yaml, or measure at it."
            yield folder.warning(what, "", remedy)


_KIND = Kind(
    Wanted(
        "mooring",
        (("code", "pwm"), ("thrust",)),
        shared=frozenset({"code", "pwm"}),
        split_words=tuple(
            word
            for name in ("up", "down", "reverse", "forward")
            for word in words_of("directions", name)
        ),
    ),
    "table of thrust against code or pulse width (PWM)",
    steps=_take_steps,
    sheets=_sheets,
    points=_points,
    summary=_summary,
    over_all=_over_all,
    compared=("thrust", curves_of),
)
