"""What goes wrong between a rig and its file: thirty-odd ways, each with what may be read of it."""

from collections.abc import Callable

import numpy as np

from evaluation.bench_files.table import KGF, Column, Written
from evaluation.bench_files.truth import Truth
from pipeline.types import FloatArray

#: Changes a table in place; False where it does not apply to it.
Corruption = Callable[[Written, Truth, np.random.Generator], bool]


def _numbers(column: Column) -> FloatArray:
    return np.array([one if isinstance(one, float) else np.nan for one in column.cells])


def _rows(written: Written) -> int:
    return len(written.columns[0].cells)


def _is_whole(written: Written, truth: Truth) -> bool:
    """Tell whether the table still has a row for each reading."""
    return _rows(written) == next(iter(truth.columns.values())).size


def _main(written: Written, truth: Truth) -> Column | None:
    return written.column("torque" if truth.kind == "load_test" else "thrust")


def _as_text_of_thousands(written: Written, truth: Truth, sign: str) -> bool:
    """Write a column of large numbers with a sign for thousands."""
    columns = [one for one in written.columns if np.nanmax(np.abs(_numbers(one)), initial=0) > 1500]
    if written.is_workbook or not columns or written.delimiter == sign:
        return False
    written.decimal = "," if sign == "." else "."
    if written.delimiter == written.decimal:
        written.delimiter = ";"
    for one in columns:
        one.cells = [
            f"{round(cell):,}".replace(",", sign) if isinstance(cell, float) else cell
            for cell in one.cells
        ]
    return True


def thousands_points(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """1.324 for 1324."""
    return _as_text_of_thousands(written, truth, ".")


def thousands_commas(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """1,324 for 1324."""
    return _as_text_of_thousands(written, truth, ",")


def thousands_lost(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """1.324, a number, among 612 and 987: a program took the sign for a decimal one."""
    column = written.column("thrust")
    if truth.kind != "mooring" or column is None:
        return False
    numbers = _numbers(column)
    large = np.abs(numbers) >= 1000.0
    if not 2 <= large.sum() <= 0.8 * numbers.size:
        return False
    column.cells = [float(one) for one in np.where(large, numbers / 1000.0, np.round(numbers))]
    return True


def kgf_called_newton(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Numbers of kgf under N, with the shaft speed beside them."""
    column, speed = written.column("thrust"), written.column("shaft_speed")
    if truth.kind != "mooring" or column is None or speed is None or not _is_whole(written, truth):
        return False
    column.cells = [float(one) for one in truth.columns["thrust"] / KGF]
    column.unit = "Н" if any("а" <= s <= "я" for s in column.name.lower()) else "N"
    return True


def grams_called_kg(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Numbers of grams under kg."""
    column = written.column("thrust")
    if truth.kind != "mooring" or column is None or not _is_whole(written, truth):
        return False
    column.cells = [float(one) for one in truth.columns["thrust"] / KGF * 1000.0]
    column.unit = "кг" if any("а" <= s <= "я" for s in column.name.lower()) else "kg"
    return True


def unit_missing(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """No unit of what was measured."""
    column = _main(written, truth)
    if column is None or isinstance(column.cells[0], str):
        return False
    column.unit = ""
    return True


def unit_row_contradicts(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Another unit in the row under the names."""
    column = _main(written, truth)
    if column is None or written.head == "row" or truth.kind == "open_water" or not column.unit:
        return False
    other = {"mooring": ("kgf", "lbf"), "load_test": ("N m", "N cm")}[truth.kind]
    unit = other[0] if column.unit != other[0] else other[1]
    for one in written.columns:
        one.cells.insert(0, unit if one is column else None)
    return True


def direction_column(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Sizes of the codes, and a column of words for their direction."""
    words = rng.choice([["FWD", "REV"], ["вперед", "назад"], ["+", "-"], ["CW", "CCW"], ["A", "B"]])
    return _without_signs(written, truth, [str(one) for one in words])


def direction_lost(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Sizes of the codes and of the thrust, and nothing for their direction."""
    return truth.kind == "mooring" and _without_signs(written, truth, [])


def _without_signs(written: Written, truth: Truth, words: list[str]) -> bool:
    code = truth.columns.get("code")
    column = written.column("code")
    low = None if column is None else np.nanmin(_numbers(column))
    if code is None or column is None or low is None or not _is_whole(written, truth):
        return False
    if low >= 0.0 or not (code < 0).any():
        return False
    for one in written.columns:
        if one.quantity in ("code", "thrust", "torque", "shaft_speed"):
            one.cells = [abs(cell) if isinstance(cell, float) else cell for cell in one.cells]
    if words:
        cells: list[str | float | None] = [words[1] if one < 0 else words[0] for one in code]
        written.columns.insert(1, Column("", "Direction", "", cells))
    return True


def row_number_n(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A column N that counts the rows."""
    written.columns.insert(0, Column("", "N", "", [float(at + 1) for at in range(_rows(written))]))
    return True


def idle_servos(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Two more pulse widths that never change."""
    if truth.kind == "open_water":
        return False
    for at in (1, 2):
        cells: list[str | float | None] = [1500.0] * _rows(written)
        written.columns.insert(0, Column("", f"Servo {at}", "us", cells))
    return True


def blank_column(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A column of the same name without a number."""
    column = _main(written, truth)
    if column is None:
        return False
    other = Column("", f"{column.name} 2", column.unit, [None] * _rows(written))
    written.columns.append(other)
    return True


def electrical_speed(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """The speed of the motor's field in place of the shaft's."""
    column = written.column("shaft_speed")
    if column is None or truth.kind == "open_water":
        return False
    column.name = str(rng.choice(["ERPM", "Electrical speed", "E-RPM", "Электрическая частота"]))
    pairs = float(rng.choice([2.0, 7.0, 11.0]))
    column.cells = [one * pairs if isinstance(one, float) else one for one in column.cells]
    return True


def two_load_cells(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Two sensors that share the load."""
    return _parts(written, truth, rng, total=False)


def two_load_cells_and_sum(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Two sensors that share the load, and their sum."""
    return _parts(written, truth, rng, total=True)


def _parts(written: Written, truth: Truth, rng: np.random.Generator, *, total: bool) -> bool:
    column = _main(written, truth)
    if column is None or truth.kind != "mooring":
        return False
    share = float(rng.uniform(0.4, 0.6))
    numbers = _numbers(column)
    at = written.columns.index(column)
    parts = [
        Column("", f"{column.name} {side}", column.unit, [float(x) for x in numbers * part])
        for side, part in zip(
            rng.choice([["left", "right"], ["1", "2"], ["A", "B"]]), (share, 1 - share), strict=True
        )
    ]
    if total:
        column.name = f"Total {column.name}"
    else:
        del written.columns[at]
    written.columns[at:at] = parts
    return True


def lever(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A lever between thruster and sensor, told in the title."""
    column = written.column("thrust")
    if truth.kind != "mooring" or column is None:
        return False
    written.title = str(rng.choice(["Lever arm ratio 2:1", "Рычаг 1:2", "lever 0.5"]))
    column.cells = [one / 2.0 if isinstance(one, float) else one for one in column.cells]
    return True


def one_way_pulses(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A controller that rests at the shortest pulse."""
    return _pulses(written, truth, one_way=True)


def wide_pulses(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Pulses of 1000 to 2000 us, which vehicle.yaml does not say."""
    return _pulses(written, truth, one_way=False)


def _pulses(written: Written, truth: Truth, *, one_way: bool) -> bool:
    column = written.column("code")
    if column is None or truth.kind != "mooring" or not _is_whole(written, truth):
        return False
    share = truth.columns["code"] / truth.vehicle.drive.code_max
    keep = share >= 0.0 if one_way else np.ones(share.size, bool)
    pulses = 1000.0 + 1000.0 * share if one_way else 1500.0 + 500.0 * share
    column.name, column.unit = "PWM", "us"
    for one in written.columns:
        cells = [float(x) for x in pulses] if one is column else one.cells
        one.cells = [cell for cell, there in zip(cells, keep, strict=True) if there]
    return True


def settling(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A log at 10 Hz with the settling of each step."""
    if truth.kind != "mooring":
        return False
    rows, count = _rows(written), 14
    rise = 1.0 - np.exp(-np.arange(count) / 2.0)
    for one in written.columns:
        follows = one.quantity in ("thrust", "shaft_speed", "current")
        one.cells = [
            cell * float(part) if follows and isinstance(cell, float) else cell
            for cell in one.cells
            for part in rise
        ]
    times: list[str | float | None] = [round(0.1 * at, 1) for at in range(rows * count)]
    written.columns.insert(0, Column("", "Time", "s", times, 8))
    return True


def ramp(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A log at 10 Hz of a command that never rests, the thrust a second behind."""
    column = written.column("code")
    if truth.kind != "mooring" or column is None:
        return False
    grid = np.linspace(0, _rows(written) - 1, 300)
    for one in written.columns:
        numbers = _numbers(one)
        if np.isfinite(numbers).all():
            late = np.clip(grid - 1.0, 0, None) if one is not column else grid
            one.cells = [float(x) for x in np.interp(late, np.arange(numbers.size), numbers)]
        else:
            one.cells = [None] * grid.size
    times: list[str | float | None] = [round(0.1 * at, 1) for at in range(grid.size)]
    written.columns.insert(0, Column("", "Time", "s", times, 8))
    return True


def rows_with_stars(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A third of the rows with a star behind each number."""
    if written.is_workbook:
        return False
    rows = set(range(0, _rows(written), 3))
    for one in written.columns:
        one.cells = [
            f"{cell:.6g}*".replace(".", written.decimal)
            if at in rows and isinstance(cell, float)
            else cell
            for at, cell in enumerate(one.cells)
        ]
    return True


def sensor_turned(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """The sensor the other way round."""
    column = _main(written, truth)
    if column is None or truth.kind == "open_water":
        return False
    column.cells = [-cell if isinstance(cell, float) else cell for cell in column.cells]
    return True


def unsigned(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Sizes of what was measured, signs at the codes."""
    column = _main(written, truth)
    if column is None or truth.kind == "open_water":
        return False
    for one in (column, written.column("shaft_speed")):
        if one is not None:
            one.cells = [abs(cell) if isinstance(cell, float) else cell for cell in one.cells]
    return True


def mean_rows(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A mean and a spread under the table."""
    for label, of in (("Mean", np.mean), ("Std", np.std)):
        row = [
            f"{of(_numbers(one)):.5g}" if np.isfinite(_numbers(one)).all() else ""
            for one in written.columns
        ]
        row[0] = label
        written.tail.append(row)
    return truth.kind != "open_water"


def set_point_column(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """What should have come of it, beside what came."""
    return _beside(written, truth, "Target {}", 1.1)


def calculated_column(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """What was calculated, beside what was measured."""
    return _beside(written, truth, "{} calculated", 0.9)


def spread_column(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """The spread of each reading beside it."""
    return _beside(written, truth, "{} std", 0.01)


def _beside(written: Written, truth: Truth, name: str, factor: float) -> bool:
    column = _main(written, truth)
    if column is None:
        return False
    cells: list[str | float | None] = [float(x) for x in factor * _numbers(column)]
    at = written.columns.index(column)
    written.columns.insert(at, Column("", name.format(column.name), column.unit, cells))
    return True


def second_unit(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """The reading once more in another unit."""
    column = _main(written, truth)
    if column is None or truth.kind == "open_water" or not _is_whole(written, truth):
        return False
    unit, worth = ("lbf", 4.4482216) if truth.kind == "mooring" else ("lb in", 0.112985)
    values = truth.columns[column.quantity] / worth
    if column.unit == unit:
        return False
    cells: list[str | float | None] = [float(x) for x in values]
    written.columns.append(Column("", column.name, unit, cells))
    return True


def in_a_flow(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """The same sweep once more in a flow, with less thrust."""
    if truth.kind != "mooring":
        return False
    rows = _rows(written)
    for one in written.columns:
        part = 0.7 if one.quantity == "thrust" else 1.0
        again = [cell * part if isinstance(cell, float) else cell for cell in one.cells]
        one.cells = [*one.cells, *again]
    flow: list[str | float | None] = [*[0.0] * rows, *[0.8] * rows]
    written.columns.insert(0, Column("", "Flow speed", "m/s", flow))
    return True


def copied_rows(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """The whole table pasted twice, one under the other."""
    for one in written.columns:
        one.cells = [*one.cells, *one.cells]
    return True


def blank_cells(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A tenth of the readings missing."""
    column = _main(written, truth)
    if column is None:
        return False
    for at in range(1, len(column.cells), 10):
        column.cells[at] = None
    return True


def zeros_for_blanks(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A zero where there was no reading."""
    column = _main(written, truth)
    if column is None or truth.kind == "open_water":
        return False
    for at in range(2, len(column.cells), 6):
        column.cells[at] = 0.0
    return True


def sections(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """Sizes alone, and a line of its own over each direction."""
    words = rng.choice([["Forward", "Reverse"], ["Ahead", "Astern"], ["Вперед", "Назад"]])
    code = truth.columns.get("code")
    if code is None or truth.kind != "mooring" or not _without_signs(written, truth, []):
        return False
    begins = int(np.flatnonzero(code < 0)[0])
    for at, one in enumerate(written.columns):
        one.cells.insert(begins, str(words[1]) if at == 0 else None)
        one.cells.insert(0, str(words[0]) if at == 0 else None)
    return True


def weak_thruster(written: Written, truth: Truth, rng: np.random.Generator) -> bool:
    """A second thruster under the first one, weaker, and a column that names them."""
    column = _main(written, truth)
    if column is None or truth.kind != "mooring" or not _is_whole(written, truth):
        return False
    rows = _rows(written)
    for one in written.columns:
        part = 0.7 if one is column else 1.0
        again = [cell * part if isinstance(cell, float) else cell for cell in one.cells]
        one.cells = [*one.cells, *again]
    written.columns.insert(0, Column("", "Thruster", "", [*["T1"] * rows, *["T2"] * rows]))
    return True


CORRUPTIONS: tuple[Corruption, ...] = (
    *(thousands_points, thousands_commas, thousands_lost, kgf_called_newton, grams_called_kg),
    *(unit_missing, unit_row_contradicts, direction_column, direction_lost, row_number_n),
    *(idle_servos, blank_column, electrical_speed, two_load_cells, two_load_cells_and_sum, lever),
    *(one_way_pulses, wide_pulses, settling, ramp, rows_with_stars, sensor_turned, unsigned),
    *(mean_rows, set_point_column, calculated_column, spread_column, second_unit, in_a_flow),
    *(copied_rows, blank_cells, zeros_for_blanks, sections, weak_thruster),
)
