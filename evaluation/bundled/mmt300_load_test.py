"""The two load-test workbooks of `mmt300`, in the manner of an M-Test export."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from evaluation.bundled.mmt300_bench import WARM_UP_READINGS, BenchReading, sweep
from evaluation.bundled.mmt300_truth import BENCH_CODES
from evaluation.bundled.noise import Noise
from pipeline.bundled.new_vehicle import Cell, SheetContents, workbook_bytes
from pipeline.units import STANDARD_GRAVITY_MPS2

#: Torque of each exemplar over that of the family: symmetric about the truth.
TORQUE_SCALE = {"drive-01": 1.004, "drive-02": 0.996}
NM_PER_KGF_CM = STANDARD_GRAVITY_MPS2 / 100.0

Row = list[Cell]


@dataclass(frozen=True)
class Defects:
    """What is wrong on one sheet; indices count the readings after the warm-up from 0.

    `outliers` maps a reading to the factor on its torque; `duplicated` is written twice;
    `broken` has a word for its torque; `commented` has "#" before its number.
    """

    outliers: Mapping[int, float]
    duplicated: int | None = None
    broken: int | None = None
    commented: int | None = None


_NONE = Defects({})
DEFECTS: Mapping[tuple[str, int], Defects] = {
    ("drive-01", 50): Defects({}, duplicated=17),
    ("drive-01", 80): Defects({}, broken=38),
    ("drive-01", 100): Defects({12: 1.15}),
    ("drive-01", 110): Defects({}, commented=30),
    ("drive-02", 30): Defects({}, duplicated=41),
    ("drive-02", 60): Defects({}, commented=8),
    ("drive-02", 70): Defects({33: 0.85}),
}
#: What the operator typed where the brake's coupling slipped.
BROKEN = "обрыв"


def load_test_files() -> dict[str, bytes]:
    """File name -> contents of both workbooks."""
    return {"drive-01.xlsx": _drive_01(), "drive-02.xlsx": _drive_02()}


def _readings(drive: str, code: int) -> list[BenchReading]:
    noise = Noise(f"mmt300 load test {drive} code {code}")
    return sweep(code, torque_scale=TORQUE_SCALE[drive], noise=noise)


def _with_defects(rows: Sequence[Row], defects: Defects, *, torque: int) -> list[Row]:
    """Spoil rows: column `torque` holds the torque, column 0 the number of the reading."""
    spoiled: list[Row] = []
    for index, row in enumerate(rows, start=-WARM_UP_READINGS):
        cells = list(row)
        if index == defects.broken:
            cells[torque] = BROKEN
        if index == defects.commented:
            cells[0] = f"# {cells[0]}"
        spoiled.append(cells)
        if index == defects.duplicated:
            spoiled.append(list(cells))
    return spoiled


def _factor(defects: Defects, index: int) -> float:
    return defects.outliers.get(index - WARM_UP_READINGS, 1.0)


def _drive_01() -> bytes:
    """Torque in kgf cm, units in a row of their own, numbers as numbers, codes rising."""
    return workbook_bytes([_sheet_01(code) for code in BENCH_CODES])


def _sheet_01(code: int) -> SheetContents:
    header: list[Row] = [
        ["M-Test. Нагрузочные испытания электропривода AT-Drive 50x14, образец 01"],
        ["Код управления:", None, f"+{code}", None, "Нагрузка: гистерезисный тормоз"],
        [],
        ["№", "Время", "Механические величины", None, "Питание", None, "Энергетика"],
        [
            *(None, None, "Частота вращения", "Момент"),
            *("Ток", "Напряжение", "Потребляемая мощность", "Мощность на валу"),
        ],
        [None, "с", "об/мин", "кгс·см", "А", "В", "Вт", "Вт"],
    ]
    defects = DEFECTS.get(("drive-01", code), _NONE)
    rows: list[Row] = []
    for index, reading in enumerate(_readings("drive-01", code)):
        torque = reading.torque_nm * _factor(defects, index) / NM_PER_KGF_CM
        rows.append(
            [
                index + 1,
                round(reading.time_s, 1),
                round(reading.shaft_speed_rpm),
                # On one sheet the torque went through a text editor.
                _comma(torque, 3) if code == 70 else round(torque, 3),
                round(reading.current_a, 3),
                round(reading.voltage_v, 2),
                round(reading.input_power_w, 2),
                round(reading.output_power_w, 2),
            ]
        )
    return SheetContents(
        f"Код {code}",
        [*header, *_with_defects(rows, defects, torque=3)],
        merged=("A1:H1", "C4:D4", "E4:F4", "G4:H4", "A4:A6", "B4:B5"),
        widths=(8, 8, 18, 12, 10, 14, 24, 18),
    )


def _drive_02() -> bytes:
    """Torque in N m, units in the header, every number a text with decimal comma, codes falling."""
    return workbook_bytes([_sheet_02(code) for code in reversed(BENCH_CODES)])


def _sheet_02(code: int) -> SheetContents:
    header: list[Row] = [
        [f"Привод AT-Drive 50x14, образец 02. Код управления {code}"],
        ["№", "Время, с", "Вал", None, None, "Цепь питания 48 В"],
        [
            *(None, None, "Обороты, об/мин", "Крутящий момент, Н·м"),
            *("Мощность на валу, Вт", "Напряжение, В", "Ток, А"),
        ],
    ]
    defects = DEFECTS.get(("drive-02", code), _NONE)
    rows: list[Row] = []
    for index, reading in enumerate(_readings("drive-02", code)):
        rows.append(
            [
                str(index + 1),
                _comma(reading.time_s, 1),
                _comma(reading.shaft_speed_rpm, 1),
                _comma(reading.torque_nm * _factor(defects, index), 4),
                _comma(reading.output_power_w, 2),
                _comma(reading.voltage_v, 2),
                _comma(reading.current_a, 3),
            ]
        )
    return SheetContents(
        f"Код {code}",
        [*header, *_with_defects(rows, defects, torque=3)],
        merged=("A1:G1", "C2:E2", "F2:G2", "A2:A3", "B2:B3"),
        widths=(8, 10, 18, 22, 22, 16, 10),
    )


def _comma(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".replace(".", ",")
