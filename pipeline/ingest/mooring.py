"""Mooring (bollard) tables: thrust at rest against code or pulse width."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import FoundTable
from pipeline.ingest.bench_kind import FileFound, Kind, read_files
from pipeline.ingest.blocks import Block, heading_text
from pipeline.ingest.cells import shorten
from pipeline.ingest.commands import codes_in_range, command_in_codes, pwm_note, pwm_problems
from pipeline.ingest.mooring_points import points_of_file
from pipeline.ingest.mooring_sweeps import Sweep, hysteresis
from pipeline.ingest.readings import COMMENTED, Reading
from pipeline.ingest.repeats import BenchTable
from pipeline.ingest.row_directions import OF_THE_RIG, with_signed_codes
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.settled_steps import settle
from pipeline.ingest.thrust_checks import shape_problem, thrust_problem
from pipeline.ingest.thrusters_apart import compare_thrusters
from pipeline.ingest.usable import is_refused
from pipeline.ingest.vocabulary import factor_in_name, plain, vocabulary_of, words_of
from pipeline.records.measurements import IN_A_FLOW, MooringPoint, MooringRecord
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.supply_voltage import is_at_supply, voltage_groups

__all__ = ["COMMENTED", "VOCABULARY", "read_mooring_tables"]

VOCABULARY = vocabulary_of("mooring")
_UP, _DOWN = words_of("directions", "up"), words_of("directions", "down")
#: A lever between thruster and sensor, or a factor: whether the numbers hold it people must say.
_LEVER = re.compile(
    r"\b(?:lever\w*|moment arm|arm ratio|arms?\b(?=.*\d)|pivot\w*|rocker|bell[ -]?crank|beam ratio"
    r"|рычаг\w*|плеч[оеа]\w*|коромысл\w*|балансир\w*|качалк\w*)\b"
    r"|\b(?:multipl\w*|divid\w*|умнож\w*|раздел[иеё]\w*|дел[ие]\w*|множител\w*)\b.{0,30}?\d",
    re.IGNORECASE,
)
#: Slower than this is rest. [m/s]
_AT_REST_MPS = 0.05
#: A small "в" that stands by itself is a preposition ("опыт 3 в бассейне"), and so is a large one
#: before a word in capitals.
_VOLTS = re.compile(
    r"(?<![^\W_])(?<![.,])(\d{1,3}(?:[.,]\d+)?)"
    r"(?:\s*(?:[Vv]|В(?!\s+[А-ЯЁ]{2})|(?i:volts?|вольт))|в)(?![^\W_])"
)


def read_mooring_tables(paths: Sequence[Path], vehicle: Vehicle, raw_root: Path) -> MooringRecord:
    """Read all mooring tables of a vehicle.

    Parameters
    ----------
    paths : sequence of Path
        Workbooks and text tables.
    vehicle : Vehicle
        Range of the codes, pulse widths, column mapping, supply voltage of the tables.
    raw_root : Path
        Sources are named relative to it.

    Returns
    -------
    MooringRecord
        Points of all files that could be read, in newtons, with every problem. A file that cannot
        be read is a problem of severity "error", and the others are read.

    Notes
    -----
    Order of rows is taken for order of measurement: it tells rising sweeps from falling ones and
    carries the tare between its readings at code 0.
    """
    read = read_files(_KIND, paths, vehicle, raw_root)
    fitted = [point for point in read.points if not point.marks]
    return MooringRecord(
        points=read.points,
        sheets=read.sheets,
        problems=read.problems,
        hysteresis_n=hysteresis(
            [point.code for point in fitted],
            [point.thrust_n for point in fitted],
            [point.sweep for point in fitted],
            [point.voltage_v for point in fitted],
        ),
        tare_drift_n=_tare_drift(read.tables),
    )


def _tare_drift(tables: Sequence[BenchTable]) -> float | None:
    """Return the largest change of what a table reads at code 0; None without two readings. [N]."""
    zeros = [[one.values["thrust"] for one in table.readings if one.is_zero] for table in tables]
    return max((float(np.ptp(one)) for one in zeros if len(one) > 1), default=None)


def _tables(file: FileFound) -> list[BenchTable]:
    return [_table(one, file.vehicle, file.problems) for one in file.tables]


def _table(found: FoundTable, vehicle: Vehicle, problems: list[Problem]) -> BenchTable:
    """Add to the readings what the headings tell: voltage, sweep, direction, per cent."""
    block, place = found.block, found.block.place()
    thrust = block.columns["thrust"]
    texts = (
        f"{thrust.header} {thrust.group}",
        block.sheet.name or "",
        heading_text(block.above),
    )
    wrong = _lever_unclear(block, vehicle) or pwm_problems(block, found.readings, vehicle, "thrust")
    problems += wrong
    if is_refused(wrong):
        return BenchTable(place, ())
    coded = command_in_codes(block, found.readings, vehicle, "mooring", problems)
    steps = settle(place, tuple(coded), "thrust")
    problems += steps.problems
    readings = _at_rest(block, steps.readings, problems)
    stated = vehicle.columns.mooring.direction
    signed = with_signed_codes(block, readings, stated, "mooring", problems)
    if signed is None or is_refused(steps.problems):
        return BenchTable(place, ())
    readings = tuple(codes_in_range(block, signed, vehicle.drive, problems))
    sense: Sweep | None = None
    if _told(texts, _DOWN, _UP):
        sense = "down"
    elif _told(texts, _UP, _DOWN):
        sense = "up"
    voltage = None if "voltage" in block.columns else _stated_voltage(texts)
    return BenchTable(place, readings, nominal_voltage_v=voltage, sense=sense)


def _points(file: FileFound, tables: Sequence[BenchTable]) -> list[tuple[MooringPoint, ...]]:
    of_tables = points_of_file(tables, file.problems)
    blocks = [one.block for one in file.tables]
    of_tables = compare_thrusters(
        [(block.place(), block.thruster) for block in blocks], of_tables, file.problems
    )
    possible = [
        _possible(block, points, file.vehicle, file.problems)
        for block, points in zip(blocks, of_tables, strict=True)
    ]
    if any("code" not in block.columns for block in blocks):
        file.problems.append(pwm_note(file.place.file, file.vehicle))
    return possible


def _lever_unclear(block: Block, vehicle: Vehicle) -> list[Problem]:
    """Refuse a table whose numbers need something that only people know."""
    thrust = block.columns["thrust"]
    stated = vehicle.columns.mooring.thrust
    title = heading_text(block.above)
    lever = next(
        (text for text in (thrust.header, thrust.group, title) if _LEVER.search(text)),
        title if factor_in_name(title, "thrust") else None,
    )
    if lever is not None and (stated is None or "scale" not in stated.model_fields_set):
        header = shorten(thrust.header)
        what = (
            f'"{shorten(lever)}" speaks of a lever or a factor; whether the numbers hold it is not '
            "known. So the table was left out."
        )
        expected = "the factor from the sensor's force to the thrust."
        remedy = (
            "State it in vehicle.yaml (1 where the numbers hold it already):\n  columns:\n"
            f'    mooring:\n      thrust: {{header: "{header}", unit: {thrust.unit or "..."}, '
            "scale: ...}"
        )
        place = block.place(block.header_row, "thrust")
        return [Problem("error", place, what, expected, remedy)]
    return []


def _at_rest(
    block: Block, readings: tuple[Reading, ...], problems: list[Problem]
) -> tuple[Reading, ...]:
    """Mark the readings that were taken in a flow."""
    moving = [one.row for one in readings if abs(one.values.get("speed", 0.0)) > _AT_REST_MPS]
    if not moving:
        return readings
    problems.append(
        Problem(
            "note",
            block.place(moving[0], "speed"),
            f"the water flowed at the thruster in {listed(moving)}: these rows are not at rest. "
            "They correct the thrust at speed, where code and speed have the same sign.",
        )
    )
    rows = set(moving)
    return tuple(one.marked(IN_A_FLOW) if one.row in rows else one for one in readings)


def _told(texts: Sequence[str], words: Sequence[str], opposite: Sequence[str]) -> bool:
    """Tell whether the first text that has a word of either list has one of `words` alone.

    >>> _told(["Power up"], _UP, _DOWN), _told(["Set-up 2, codes up"], _UP, _DOWN)
    (False, True)
    """
    for text in texts:
        found = set(OF_THE_RIG.sub(" ", plain(text)).split())
        here, there = found & {plain(w) for w in words}, found & {plain(w) for w in opposite}
        if here or there:
            return bool(here) and not there
    return False


def _stated_voltage(texts: Sequence[str]) -> float | None:
    """Return the one voltage that the first text with any states.

    >>> _stated_voltage(["Thrust, N", "16 V"]), _stated_voltage(["10 V to 20 V"])
    (16.0, None)
    >>> _stated_voltage(["Опыт 3 в бассейне", "12,6 В, реверс"])
    12.6
    """
    for text in texts:
        found = {float(one.replace(",", ".")) for one in _VOLTS.findall(text)}
        if found:
            return found.pop() if len(found) == 1 else None
    return None


def _possible(
    block: Block,
    points: tuple[MooringPoint, ...],
    vehicle: Vehicle,
    problems: list[Problem],
) -> tuple[MooringPoint, ...]:
    """Return the points of a table, none of one that cannot be."""
    found = [shape_problem(block.place(), points)]
    if not _is_stand_in(vehicle):
        found.append(thrust_problem(block.place(), points, vehicle, block.columns["thrust"]))
    said = [problem for problem in found if problem is not None]
    problems += said
    return () if is_refused(said) else points


def _is_stand_in(vehicle: Vehicle) -> bool:
    """Tell whether no vehicle file says how large the propeller is (a check of a file alone)."""
    return vehicle.name == "unknown"


def _summary(_table: BenchTable, points: Sequence[MooringPoint]) -> str:
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


def _over_all(fitted: Sequence[MooringPoint], folder: Place, vehicle: Vehicle) -> list[Problem]:
    """Say what only all files together show: supply voltages, too few codes."""
    problems: list[Problem] = []
    codes = {point.code for point in fitted}
    if len(codes) < 2:
        what = f"there is one code only ({codes.pop():g}): no characteristic follows from it."
        expected = f"several codes from {vehicle.drive.code_min} to {vehicle.drive.code_max}."
        remedy = "Add the records of other codes."
        problems.append(Problem("error", folder, what, expected, remedy))
    groups = voltage_groups(point.voltage_v for point in fitted if point.voltage_v is not None)
    wanted = vehicle.tables.supply_voltage_v
    named = ", ".join(f"{(low + high) / 2:.3g}" for low, high in groups)
    if wanted is None and len(groups) > 1:
        what = f"taken at several supply voltages ({named} V), and none is stated for the tables."
        remedy = "State tables: supply_voltage_v in vehicle.yaml."
        problems.append(Problem("warning", folder, what, "one supply voltage.", remedy))
    elif wanted is not None and groups:
        known = [point.voltage_v for point in fitted if point.voltage_v is not None]
        between = min(known) < wanted < max(known)
        if not between and not any(is_at_supply(voltage_v, wanted) for voltage_v in known):
            what = (
                f"no point at the supply voltage of the tables, {wanted:g} V; there is {named} V."
            )
            remedy = "Correct tables: supply_voltage_v in vehicle.yaml, or measure at it."
            problems.append(Problem("warning", folder, what, "", remedy))
    return problems


_KIND = Kind(
    name="mooring",
    noun="mooring",
    looked_for="table of thrust against code or pulse width (PWM)",
    vocabulary=VOCABULARY,
    required=(("code", "pwm"), ("thrust",)),
    tables=_tables,
    points=_points,
    summary=_summary,
    over_all=_over_all,
    shared=frozenset({"code", "pwm"}),
    split_words=tuple(
        word
        for name in ("up", "down", "reverse", "forward")
        for word in words_of("directions", name)
    ),
)
