"""Mooring (bollard) tables: thrust at rest against code or pulse width."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_file import (
    COMMENTED,
    Reading,
    mapped_columns,
    read_bench_file,
    source_name,
    without_copies,
)
from pipeline.ingest.blocks import Block, heading_text
from pipeline.ingest.code_units import fractional_codes, percent_scale
from pipeline.ingest.column_kinds import FIRST_RANK, NOT_MEASURED, NOT_OF_SHAFT, SECOND_RANK
from pipeline.ingest.copied_tables import TablesSeen
from pipeline.ingest.headers import Wanted
from pipeline.ingest.mooring_points import MooringTable, points_of_file
from pipeline.ingest.mooring_sweeps import Sweep, hysteresis, voltage_groups
from pipeline.ingest.rows import counted
from pipeline.ingest.unit_text import is_percent
from pipeline.ingest.usable import with_cause
from pipeline.ingest.vocabulary import Vocabulary, Words, plain
from pipeline.records.measurements import MooringPoint, MooringRecord, SheetRead
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.supply_voltage import is_at_supply

__all__ = ["COMMENTED", "VOCABULARY", "read_mooring_tables"]

VOCABULARY: Vocabulary = {
    "code": Words(
        None,
        (
            *("control code", "command code", "code", "command", "throttle", "duty cycle", "duty"),
            *("код управления", "код", "управление", "команда", "газ", "дроссель", "скважность"),
            *("stellgrad", "consigne", "commande"),
        ),
        symbols=("N", "u", "U_code"),
        never=("pwm", "шим", "voltage", "напряжение"),
    ),
    "pwm": Words(
        "pulse_width",
        (
            *("pwm", "pulse width", "pulse", "esc signal", "esc", "servo"),
            *("шим", "длительность импульса", "ширина импульса", "импульс"),
        ),
        default_unit="us",
        by_unit=True,
    ),
    "thrust": Words(
        "force",
        (
            *("thrust", "bollard pull", "force", "pull", "load cell"),
            *("упор*", "тяга", "сила", "усилие", "schub", "schubkraft", "zugkraft", "poussee"),
        ),
        symbols=("T", "F", "Т", "P"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(
            *NOT_MEASURED,
            *("efficiency", "coefficient", "specific", "current"),
            *("коэффициент*", "эффективность"),
        ),
        with_unit=("load", "reading", "scale", "показания", "нагрузка", "весы"),
        by_unit=True,
    ),
    "shaft_speed": Words(
        "shaft_speed",
        (
            "shaft speed",
            "rotational speed",
            "rotation speed",
            "motor speed",
            "revolutions",
            "rpm",
            "частота вращения",
            "скорость вращения",
            "обороты",
            "частота",
        ),
        symbols=("n", "ω", "omega"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(*NOT_MEASURED, *NOT_OF_SHAFT),
        with_unit=("speed", "скорость"),
        default_unit="rpm",
        unit_words={"rpm": "rpm"},
    ),
    "voltage": Words(
        "voltage", ("voltage", "supply", "напряжение", "питание"), symbols=("U", "V"),
        prefer=FIRST_RANK, less=SECOND_RANK, never=NOT_MEASURED, default_unit="V",
    ),
    "current": Words(
        "current", ("current", "ток", "сила тока"), symbols=("I", "Current"),
        prefer=FIRST_RANK, less=SECOND_RANK, never=NOT_MEASURED, default_unit="A",
    ),
}  # fmt: skip
_UP = ("up", "rising", "increasing", "ascending", "вверх", "рост", "возрастание", "увеличение")
_DOWN = ("down", "falling", "decreasing", "descending", "вниз", "спад", "убывание", "уменьшение")
#: What is done to a rig, and says nothing of the order of codes.
_OF_THE_RIG = re.compile(
    r"\b(set|warm\w*|power\w*|start\w*|back|close|mock|wake) up\b"
    r"|\b(cool\w*|power\w*|shut|break|tear|strip|wind) down\b"
)
_REVERSE = ("reverse", "astern", "backward", "backwards", "назад", "реверс", "задний", "обратный")
_FORWARD = ("forward", "ahead", "вперед", "передний", "прямой")
_LOOKED_FOR = "table of thrust against code or pulse width (PWM)"
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
    columns = vehicle.columns.mooring
    wanted = Wanted(
        VOCABULARY,
        required=(("code", "pwm"), ("thrust",)),
        kind="mooring",
        mapping=mapped_columns(columns),
        only=columns.only,
        shared=frozenset({"code", "pwm"}),
        split_words=(*_UP, *_DOWN, *_REVERSE, *_FORWARD),
    )
    points: list[MooringPoint] = []
    sheets: list[SheetRead] = []
    drifts: list[float] = []
    kept, problems = without_copies(paths, raw_root)
    seen = TablesSeen()
    for path in kept:
        shown_as = source_name(path, raw_root)
        found = read_bench_file(path, shown_as, wanted, columns, _LOOKED_FOR)
        said = list(found.problems)
        tables = [_table(block, readings, vehicle, said) for block, readings in found.tables]
        tables = [_without_copy(table, seen, said) for table in tables]
        file = points_of_file(tables, vehicle.drive, columns.pwm_range)
        said += file.problems
        drifts += [] if file.tare_drift_n is None else [file.tare_drift_n]
        for (block, readings), own in zip(found.tables, file.points, strict=True):
            points += own
            sheets.append(_sheet_read(block, readings, own))
        if any("code" not in block.columns for block, _ in found.tables):
            said.append(_pwm_note(shown_as, vehicle))
        marks = [point.marks for own in file.points for point in own]
        problems += said if found.is_blank else with_cause(said, shown_as, marks, "mooring")
    fitted = [point for point in points if not point.marks]
    if fitted:
        folder = Place(source_name(min(paths).parent, raw_root))
        problems += _over_all(fitted, folder, vehicle)
    return MooringRecord(
        points=tuple(points),
        sheets=tuple(sheets),
        problems=tuple(problems),
        hysteresis_n=hysteresis(
            [point.code for point in fitted],
            [point.thrust_n for point in fitted],
            [point.sweep for point in fitted],
            [point.voltage_v for point in fitted],
        ),
        tare_drift_n=max(drifts, default=None),
    )


def _table(
    block: Block, readings: tuple[Reading, ...], vehicle: Vehicle, problems: list[Problem]
) -> MooringTable:
    """Add to the readings what the headings tell: voltage, sweep, direction, per cent."""
    thrust = block.columns["thrust"]
    own = f"{thrust.header} {thrust.group}"
    texts = (own, block.sheet.name or "", heading_text(block.above))
    place = block.place()
    code = block.columns.get("code")
    if code is not None:
        live = [one for one in readings if "code" in one.values and not one.marks]
        numbers = [(one.row, one.values["code"]) for one in live]
        codes = [number for _, number in numbers]
        readings = _scaled(readings, percent_scale(block, codes, vehicle.drive.code_max, problems))
        if not is_percent(code.unit):
            problems += fractional_codes(numbers, lambda row: block.place(row, "code"), "mooring")
    neutral = vehicle.columns.mooring.pwm_range.neutral_us
    only_positive = all(
        reading.values.get("code", reading.values.get("pwm", neutral) - neutral) >= 0.0
        for reading in readings
    )
    if only_positive and "code" in block.columns and _told(texts, _REVERSE, _FORWARD):
        readings = _scaled(readings, -1.0)
        what = "the heading says reverse and no code is negative: codes were given a minus sign."
        problems.append(Problem("note", place, what))
    sense: Sweep | None = None
    if _told(texts, _DOWN, _UP):
        sense = "down"
    elif _told(texts, _UP, _DOWN):
        sense = "up"
    voltage = None if "voltage" in block.columns else _stated_voltage(texts)
    return MooringTable(place, readings, voltage, sense)


def _without_copy(table: MooringTable, seen: TablesSeen, problems: list[Problem]) -> MooringTable:
    told = table.nominal_voltage_v, table.sense
    return replace(table, readings=seen.marked(table.place, table.readings, problems, *told))


def _scaled(readings: tuple[Reading, ...], factor: float) -> tuple[Reading, ...]:
    return tuple(
        replace(one, values={**one.values, "code": one.values["code"] * factor})
        if "code" in one.values
        else one
        for one in readings
    )


def _told(texts: Sequence[str], words: Sequence[str], opposite: Sequence[str]) -> bool:
    """Tell whether the first text that has a word of either list has one of `words` alone.

    >>> _told(["Power up"], _UP, _DOWN), _told(["Set-up 2, codes up"], _UP, _DOWN)
    (False, True)
    """
    for text in texts:
        found = set(_OF_THE_RIG.sub(" ", plain(text)).split())
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


def _sheet_read(
    block: Block, readings: tuple[Reading, ...], points: Sequence[MooringPoint]
) -> SheetRead:
    return SheetRead(
        file=block.sheet.file,
        sheet=block.sheet.name,
        rows=len(readings),
        columns=tuple(column.as_record() for column in block.columns.values()),
        summary=_summary(points),
    )


def _summary(points: Sequence[MooringPoint]) -> str:
    if not points:
        return "left out"
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
    marked = sum(bool(set(point.marks) - {"zero reading"}) for point in points)
    if marked:
        parts.append(f"{marked} left out")
    return ", ".join(parts)


def _pwm_note(file: str, vehicle: Vehicle) -> Problem:
    pwm = vehicle.columns.mooring.pwm_range
    stated = {"neutral_us", "half_range_us"} <= pwm.model_fields_set
    what = (
        f"pulse width becomes a code by (pwm - {pwm.neutral_us:g} us) / {pwm.half_range_us:g} us "
        f"* {vehicle.drive.code_max}{'' if stated else ', which is assumed'}."
    )
    remedy = "" if stated else "State columns: mooring: pwm_range in vehicle.yaml."
    return Problem("note", Place(file), what, "", remedy)


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
        if not any(is_at_supply(voltage_v, wanted) for voltage_v in known):
            what = (
                f"no point at the supply voltage of the tables, {wanted:g} V; there is {named} V."
            )
            remedy = "Correct tables: supply_voltage_v in vehicle.yaml, or measure at it."
            problems.append(Problem("warning", folder, what, "", remedy))
    return problems
