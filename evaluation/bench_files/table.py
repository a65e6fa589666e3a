"""A rig's habits: language, units, order, numbers and layout of what somebody writes down."""

import csv
import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from openpyxl import Workbook  # type: ignore[import-untyped]  # it has no stubs

from evaluation.bench_files.truth import Truth
from pipeline.types import FloatArray

KGF, LBF = 9.80665, 4.4482216152605
#: Quantity -> unit as written -> what one of it is in the unit of the truth.
UNITS: dict[str, dict[str, float]] = {
    "thrust": {"N": 1.0, "kgf": KGF, "gf": KGF / 1000.0, "lbf": LBF, "g": KGF / 1000.0},
    "torque": {
        "N m": 1.0,
        "N cm": 0.01,
        "N mm": 1e-3,
        "mN m": 1e-3,
        "kgf cm": KGF / 100.0,
        "g cm": KGF / 1e5,
        "oz in": 0.00706155,
        "lb in": 0.112985,
        "oz ft": 0.0847386,
    },
    "shaft_speed": {"rpm": 1.0, "1/min": 1.0, "rad/s": 60.0 / (2.0 * np.pi), "rps": 60.0},
    "voltage": {"V": 1.0},
    "current": {"A": 1.0, "mA": 1e-3},
    "speed": {"m/s": 1.0, "cm/s": 0.01},
}
RUSSIAN = {
    "N": "Н",
    "kgf": "кгс",
    "gf": "гс",
    "g": "г",
    "lbf": "lbf",
    "N m": "Н·м",
    "N cm": "Н·см",
    "N mm": "Н·мм",
    "mN m": "мН·м",
    "kgf cm": "кгс·см",
    "g cm": "г·см",
    "rpm": "об/мин",
    "1/min": "1/мин",
    "rad/s": "рад/с",
    "rps": "об/с",
    "V": "В",
    "A": "А",
    "mA": "мА",
    "m/s": "м/с",
    "cm/s": "см/с",
    "us": "мкс",
    "%": "%",
}
NAMES: dict[str, dict[str, tuple[str, ...]]] = {
    "en": {
        "code": ("Code", "Control code", "Command"),
        "thrust": ("Thrust", "Force", "Bollard pull", "Load cell"),
        "torque": ("Torque", "Shaft torque", "Output torque"),
        "shaft_speed": ("Speed", "Shaft speed", "Rotational speed"),
        "voltage": ("Voltage", "Supply voltage"),
        "current": ("Current", "Supply current"),
        "speed": ("Carriage speed", "Advance speed", "Velocity"),
        "pwm": ("PWM", "Pulse width", "ESC signal"),
        "throttle": ("Throttle",),
    },
    "ru": {
        "code": ("Код", "Код управления", "Команда"),
        "thrust": ("Упор", "Тяга", "Усилие"),
        "torque": ("Момент", "Крутящий момент"),
        "shaft_speed": ("Частота вращения", "Скорость вращения"),
        "voltage": ("Напряжение", "Напряжение питания"),
        "current": ("Ток", "Ток потребления"),
        "speed": ("Скорость потока", "Скорость хода"),
        "pwm": ("ШИМ", "Длительность импульса"),
        "throttle": ("Газ",),
    },
}


@dataclass
class Column:
    """A column as written: name, unit, cells. `quantity` is what it holds, empty for any other."""

    quantity: str
    name: str
    unit: str
    cells: list[str | float | None]
    digits: int = 4


@dataclass
class Written:
    """A table as written, and how it goes into a file."""

    columns: list[Column]
    head: str = "brackets"
    title: str = ""
    decimal: str = "."
    delimiter: str = ","
    is_workbook: bool = False
    tail: list[list[str]] = field(default_factory=list)

    def column(self, quantity: str) -> Column | None:
        """Return the first column of a quantity."""
        return next((one for one in self.columns if one.quantity == quantity), None)


def write_down(truth: Truth, rng: np.random.Generator) -> Written:
    """Write the readings as some rig's people would."""
    language = str(rng.choice(["en", "en", "ru"]))
    columns: list[Column] = []
    for quantity, values in truth.columns.items():
        optional = quantity in ("voltage", "current") or (
            truth.kind == "mooring" and quantity == "shaft_speed"
        )
        if optional and rng.random() < 0.3:
            continue
        if quantity == "code":
            columns.append(_command(truth, values, language, rng))
            continue
        unit = str(rng.choice(list(UNITS[quantity])))
        numbers = values / UNITS[quantity][unit]
        if truth.kind == "mooring" and quantity == "shaft_speed" and rng.random() < 0.5:
            numbers = np.abs(numbers)  # most tachometers have no sign
        shown = RUSSIAN.get(unit, unit) if language == "ru" else unit
        name = str(rng.choice(NAMES[language][quantity]))
        columns.append(Column(quantity, name, shown, _cells(numbers), 5))
    order = rng.permutation(len(columns)) if rng.random() < 0.4 else range(len(columns))
    written = Written([columns[int(at)] for at in order])
    if rng.random() < 0.25:
        label = "№" if language == "ru" else "No."
        count = list(range(1, len(columns[0].cells) + 1))
        written.columns.insert(0, Column("", label, "", [float(one) for one in count]))
    if rng.random() < 0.2:
        remark = "Примечание" if language == "ru" else "Remark"
        written.columns.append(Column("", remark, "", [None] * len(columns[0].cells)))
    written.head = str(rng.choice(["brackets", "square", "comma", "row"]))
    written.is_workbook = bool(rng.random() < 0.4)
    written.decimal = str(rng.choice([",", "."])) if language == "ru" else "."
    written.delimiter = ";" if written.decimal == "," else str(rng.choice([",", ";", "\t"]))
    if written.head == "comma" and written.delimiter == ",":
        written.head = "brackets"
    if rng.random() < 0.3:
        written.title = "Испытание 3" if language == "ru" else "Test 3"
    return written


def _command(truth: Truth, code: FloatArray, language: str, rng: np.random.Generator) -> Column:
    """Write the command as a code, a pulse width, per cent or a share."""
    code_max = truth.vehicle.drive.code_max
    form = str(rng.choice(["code", "code", "pwm", "percent", "share"]))
    if form == "code" or (truth.kind == "load_test" and form == "share"):
        return Column("code", str(rng.choice(NAMES[language]["code"])), "", _cells(code), 12)
    if form == "pwm":
        unit = RUSSIAN["us"] if language == "ru" else "us"
        pulses = np.round(1500.0 + 400.0 * code / code_max)
        truth.columns["code"] = (pulses - 1500.0) * code_max / 400.0
        return Column("code", str(rng.choice(NAMES[language]["pwm"])), unit, _cells(pulses), 12)
    name = str(rng.choice(NAMES[language]["throttle"]))
    share = code / code_max
    if form == "percent":
        return Column("code", name, "%", _cells(100.0 * share), 12)
    return Column("code", name, "", _cells(share), 12)


def _cells(values: FloatArray) -> list[str | float | None]:
    return [float(one) for one in values]


def as_texts(written: Written) -> list[list[str | float | None]]:
    """Return the rows of the file: title, names, units, numbers, tail."""
    names, units = [], []
    for one in written.columns:
        form = {"brackets": "{} ({})", "square": "{} [{}]", "comma": "{}, {}"}.get(written.head)
        names.append(form.format(one.name, one.unit) if form and one.unit else one.name)
        units.append(one.unit)
    rows: list[list[str | float | None]] = []
    if written.title:
        rows += [[written.title], []]
    rows.append([*names])
    if written.head == "row":
        rows.append([*units])
    for at in range(max(len(one.cells) for one in written.columns)):
        rows.append([_shown(one, at, written) for one in written.columns])
    rows += [[*row] for row in written.tail]
    return rows


def _shown(column: Column, at: int, written: Written) -> str | float | None:
    cell = column.cells[at] if at < len(column.cells) else None
    if not isinstance(cell, float):
        return cell
    number = float(f"{cell:.{column.digits}g}") + 0.0
    return number if written.is_workbook else f"{number:.10g}".replace(".", written.decimal)


def save(written: Written, folder: Path, name: str) -> Path:
    """Write the file as a workbook or as text."""
    rows = as_texts(written)
    if written.is_workbook:
        path = folder / f"{name}.xlsx"
        book = Workbook()
        sheet = book.worksheets[0]
        for row in rows:
            sheet.append(row)
        book.save(path)
        return path
    path = folder / f"{name}.csv"
    text = io.StringIO()
    csv.writer(text, delimiter=written.delimiter, lineterminator="\n").writerows(rows)
    path.write_text(text.getvalue(), encoding="utf-8")
    return path
