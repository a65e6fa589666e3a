"""The two mooring workbooks of `mmt300`, from the printed cubics of Table 3."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from evaluation.bundled.mmt300_electric import electric
from evaluation.bundled.mmt300_truth import (
    DENSITY_KGPM3,
    DIAMETER_M,
    KM,
    KT,
    mooring_thrust,
)
from evaluation.bundled.noise import Noise
from pipeline.bundled.new_vehicle import Cell, SheetContents, workbook_bytes
from pipeline.units import STANDARD_GRAVITY_MPS2

#: Sizes of the codes on a rising sweep; 15 lies at the edge of the dead zone.
CODES = (10, 15, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127)
#: Standard deviation of a thrust reading. [N]
THRUST_NOISE_N = 0.1
#: A falling sweep reads this share of the thrust more than a rising one, and this much. [-], [N]
HYSTERESIS = (0.006, 0.06)
#: Reverse thrust of the propeller at a shaft speed, over its forward thrust: invented.
REVERSE_THRUST_SHARE = 0.95


@dataclass(frozen=True)
class MooringReading:
    """One row of a mooring test, before it is written in the file's units."""

    code: int
    thrust_n: float
    shaft_speed_rpm: float
    voltage_v: float
    current_a: float


def sequence() -> list[int]:
    """Codes in the order of the test: 0, up, down, 0, then the same backwards, 0.

    >>> codes = sequence()
    >>> codes[:3], codes.count(0), codes.count(-127), codes[-2:]
    ([0, 10, 15], 3, 1, [-10, 0])
    """
    once = [*CODES, *CODES[-2::-1]]
    return [0, *once, 0, *(-code for code in once), 0]


def readings(*, drift_n: float, noise: Noise) -> list[MooringReading]:
    """Take the readings of one test whose zero drifts evenly from 0 to `drift_n` [N]."""
    codes = sequence()
    found = []
    for index, code in enumerate(codes):
        thrust_n = mooring_thrust(code)
        shaft_rpm, torque_nm = _at_rest(thrust_n)
        meters = electric(abs(shaft_rpm), torque_nm)
        falling = index > 0 and abs(code) < abs(codes[index - 1])
        if thrust_n != 0.0:
            share, offset = HYSTERESIS
            lag = 0.5 * (share * abs(thrust_n) + offset) * (1.0 if falling else -1.0)
            thrust_n += lag if thrust_n > 0.0 else -lag
        found.append(
            MooringReading(
                code=code,
                thrust_n=thrust_n
                + drift_n * index / (len(codes) - 1)
                + noise.normal(THRUST_NOISE_N if code else 0.02),
                shaft_speed_rpm=shaft_rpm + noise.normal(3.0) if shaft_rpm else 0.0,
                voltage_v=meters.voltage_v + noise.normal(0.02),
                current_a=meters.current_a + noise.normal(0.01),
            )
        )
    return found


def _at_rest(thrust_n: float) -> tuple[float, float]:
    """Signed shaft speed [rpm] and torque [N m] behind a thrust at J = 0."""
    k_t = KT[0] * (1.0 if thrust_n >= 0.0 else REVERSE_THRUST_SHARE)
    rps = math.sqrt(abs(thrust_n) / (k_t * DENSITY_KGPM3 * DIAMETER_M**4))
    torque_nm = KM[0] * DENSITY_KGPM3 * rps**2 * DIAMETER_M**5
    return math.copysign(rps * 60.0, thrust_n), torque_nm


def mooring_files() -> dict[str, bytes]:
    """File name -> contents of both workbooks."""
    first = readings(drift_n=0.18, noise=Noise("mmt300 mooring 01"))
    second = readings(drift_n=-0.12, noise=Noise("mmt300 mooring 02"))
    return {
        "bollard-01.xlsx": _russian(first),
        "bollard-02.xlsx": _english(second),
    }


def _russian(rows: Sequence[MooringReading]) -> bytes:
    """Thrust in kgf, signed speed, units in a row of their own."""
    header: list[list[Cell]] = [
        ["Швартовные испытания маршевого движителя в бассейне, протокол 1"],
        ["Код управления", "Тяга", "Частота вращения", "Напряжение", "Ток"],
        [None, "кгс", "об/мин", "В", "А"],
    ]
    body: list[list[Cell]] = [
        [
            row.code,
            round(row.thrust_n / STANDARD_GRAVITY_MPS2, 3),
            round(row.shaft_speed_rpm),
            round(row.voltage_v, 2),
            round(row.current_a, 2),
        ]
        for row in rows
    ]
    return _workbook("Швартовы", header, body, merged=("A1:E1", "A2:A3"))


def _english(rows: Sequence[MooringReading]) -> bytes:
    """Thrust in newtons, a tachometer without sign, a remark column, one reading left out."""
    header: list[list[Cell]] = [
        ["Bollard pull, stern thruster, basin, run 2"],
        ["Code", "Thrust, N", "Shaft speed, rpm", "Voltage, V", "Current, A", "Remarks"],
    ]
    body: list[list[Cell]] = []
    for index, row in enumerate(rows):
        cells: list[Cell] = [
            row.code,
            round(row.thrust_n, 2),
            round(abs(row.shaft_speed_rpm)),
            round(row.voltage_v, 2),
            round(row.current_a, 2),
            None,
        ]
        if index == 21:
            cells[0], cells[1] = f"# {row.code}", round(0.6 * row.thrust_n, 2)
            cells[5] = "line caught on the ladder, not valid"
        elif row.code == 0:
            cells[5] = "zero"
        body.append(cells)
    return _workbook("Bollard", header, body, merged=("A1:F1",))


def _workbook(
    title: str, header: list[list[Cell]], body: list[list[Cell]], *, merged: Sequence[str]
) -> bytes:
    return workbook_bytes(
        [SheetContents(title, [*header, *body], merged=merged, widths=(18,) * len(header[1]))]
    )
