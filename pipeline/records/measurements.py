"""What was measured on the bench: one checked record for each kind of raw file."""

from typing import Literal

from pipeline.errors import Problem
from pipeline.records.base import Record, Source


class ColumnRead(Record):
    """How one column of a raw file was understood."""

    quantity: str
    header: str
    column: str
    unit: str
    unit_from: Literal["header", "unit row", "mapping", "assumed"]


class ColumnNotUsed(Record):
    """A column of a table that nothing was read from, and why."""

    header: str
    column: str
    reason: str


class SheetRead(Record):
    """What was found on one sheet (or the one table of a CSV file)."""

    file: str
    sheet: str | None
    rows: int
    columns: tuple[ColumnRead, ...]
    summary: str
    """One line for a person, e.g. ``code 90 (sheet name), 84 points, 1324-1607 rpm``."""
    not_used: tuple[ColumnNotUsed, ...] = ()
    stated_as: tuple[tuple[str, str], ...] = ()
    """What vehicle.yaml would state for the table to be read so: key and its value as YAML."""


class LoadTestPoint(Record):
    """One steady point of a drive on the load bench, in the motoring quadrant of its code.

    A sweep in reverse (code, speed and torque negative) is stored with all three signs as
    measured; `code` is None where the file does not say it. `marks` says why a point is not fitted
    ("warm-up", "duplicate", "commented out", "negative torque" ...); an empty tuple means that it
    is. A row whose speed or torque is no number is no point: a problem of the record names it.
    """

    source: Source
    code: float | None
    shaft_speed_rpm: float
    torque_nm: float
    current_a: float | None = None
    voltage_v: float | None = None
    input_power_w: float | None = None
    output_power_w: float | None = None
    branch: Literal["loading", "unloading"]
    marks: tuple[str, ...] = ()


class LoadTestRecord(Record):
    """All load-test files of one vehicle."""

    points: tuple[LoadTestPoint, ...]
    sheets: tuple[SheetRead, ...]
    problems: tuple[Problem, ...]

    def points_to_fit(self) -> tuple[LoadTestPoint, ...]:
        """Points with a code and without marks; at code 0 nobody knows which side they are of."""
        return tuple(p for p in self.points if not p.marks and p.code)


#: Mark of a mooring reading in a flow, by which tests at rest leave it out.
IN_A_FLOW = "not at rest"


class MooringPoint(Record):
    """Thrust for one code, at rest unless marked; both carry the sign, the tare is removed.

    `tare_n` is what was subtracted; `sweep` tells rising |code| from falling.
    """

    source: Source
    code: float
    thrust_n: float
    tare_n: float = 0.0
    speed_mps: float = 0.0
    """Of the water, along the thrust of a positive code."""
    shaft_speed_rpm: float | None = None
    voltage_v: float | None = None
    current_a: float | None = None
    thruster: str | None = None
    """Name of its column, where a file holds several thrusters."""
    sweep: Literal["up", "down"]
    marks: tuple[str, ...] = ()


class MooringRecord(Record):
    """All mooring (bollard) tables of one vehicle.

    `hysteresis_n`: mean thrust of the falling sweeps less the rising ones at equal code, None when
    only one was flown. `tare_drift_n`: largest change of the reading at code 0 within a file.
    """

    points: tuple[MooringPoint, ...]
    sheets: tuple[SheetRead, ...]
    problems: tuple[Problem, ...]
    hysteresis_n: float | None = None
    tare_drift_n: float | None = None


class OpenWaterPoint(Record):
    """One point of the propeller's open-water curves."""

    source: Source
    advance_ratio: float
    thrust_coefficient: float | None = None
    torque_coefficient: float | None = None
    marks: tuple[str, ...] = ()


class OpenWaterRecord(Record):
    """All open-water files of one vehicle."""

    points: tuple[OpenWaterPoint, ...]
    sheets: tuple[SheetRead, ...]
    problems: tuple[Problem, ...]
