"""Sections of the vehicle file about bench files: where columns stand, what somebody printed."""

from collections.abc import Iterable
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.vehicle.attachment_schema import ModelSection as Section
from pipeline.vehicle.attachment_schema import Positive

#: Readings within this share of the wanted voltage belong to it.
VOLTAGE_TOLERANCE = 0.05
#: Voltages further apart than this belong to different tests; a supply sags less between codes.
_VOLTAGE_GAP_V = 0.8

#: Stands in a heading of every form that ``rig2sea new`` writes.
FORM_MARK = "form of rig2sea new"


def is_at_supply(voltage_v: float | None, wanted_v: float | None) -> bool:
    """Tell whether a reading at a voltage [V] belongs to the tables; unknown ones do.

    >>> [is_at_supply(volts, 16.0) for volts in (15.9, 14.0, None)], is_at_supply(12.0, None)
    ([True, False, True], True)
    """
    if voltage_v is None or wanted_v is None:
        return True
    return abs(voltage_v - wanted_v) <= VOLTAGE_TOLERANCE * wanted_v


def voltage_groups(voltages_v: Iterable[float]) -> tuple[tuple[float, float], ...]:
    """Part voltages into tests: lowest and highest of each group, groups rising.

    >>> voltage_groups([16.0, 15.6, 15.2, 12.1, 12.0])
    ((12.0, 12.1), (15.2, 16.0))
    """
    groups: list[tuple[float, float]] = []
    for voltage in sorted(voltages_v):
        if groups and voltage - groups[-1][1] <= _VOLTAGE_GAP_V:
            groups[-1] = (groups[-1][0], voltage)
        else:
            groups.append((voltage, voltage))
    return tuple(groups)


class Column(Section):
    """Where a quantity stands when the reader cannot tell by itself.

    Its numbers are multiplied by `scale` (a lever, say), and divided by `pole_pairs` where they are
    the electrical speed of a motor; those of the columns `plus` are added.
    """

    header: str
    unit: str | None = None
    sign: Literal[1, -1] = 1
    scale: Positive = 1.0
    pole_pairs: Annotated[int, Field(ge=1, le=100)] | None = None
    plus: tuple[str, ...] = ()


class Direction(Section):
    """A column of words: rows with one of `reverse` were taken in reverse, the others forward."""

    header: str
    reverse: tuple[str, ...]


class BenchColumns(Section):
    """Mapping of columns for one kind of raw file.

    `sheets` restricts reading to these sheets; `only` keeps the rows whose column has this text.
    """

    sheets: tuple[str, ...] | None = None
    only: dict[str, str] = Field(default_factory=dict)


class LoadTestColumns(BenchColumns):
    """Columns of a load test; `pwm` becomes a code as in a mooring test."""

    code: Column | None = None
    pwm: Column | None = None
    shaft_speed: Column | None = None
    torque: Column | None = None
    current: Column | None = None
    voltage: Column | None = None
    input_power: Column | None = None
    output_power: Column | None = None
    direction: Direction | None = None
    warm_up_s: Annotated[float, Field(ge=0)] | None = None


class Pwm(Section):
    """How pulse width becomes a code: code = (pwm - neutral) / half_range * code_max."""

    neutral_us: Positive = 1500.0
    half_range_us: Positive = 400.0


class MooringColumns(BenchColumns):
    """Columns of a mooring table."""

    code: Column | None = None
    pwm: Column | None = None
    thrust: Column | None = None
    shaft_speed: Column | None = None
    voltage: Column | None = None
    current: Column | None = None
    speed: Column | None = None
    time: Column | None = None
    direction: Direction | None = None
    pwm_range: Pwm = Pwm()


class OpenWaterColumns(BenchColumns):
    """Columns of an open-water test."""

    advance_ratio: Column | None = None
    thrust_coefficient: Column | None = None
    torque_coefficient: Column | None = None
    power_coefficient: Column | None = None
    thrust: Column | None = None
    torque: Column | None = None
    shaft_speed: Column | None = None
    speed: Column | None = None


class Columns(Section):
    """Column mappings by kind of raw file."""

    load_test: LoadTestColumns = LoadTestColumns()
    mooring: MooringColumns = MooringColumns()
    open_water: OpenWaterColumns = OpenWaterColumns()


def _check_lengths(section: Section, speed_mps: tuple[float, ...], *rows: str) -> None:
    """Each row of a table by speed has one entry a speed."""
    for row in rows:
        found = len(getattr(section, row))
        if found != len(speed_mps):
            raise ValueError(f"{row} has {found} entries, speed_mps has {len(speed_mps)}")


class PublishedTable2(Section):
    """Printed coefficients of T(N) by speed."""

    speed_mps: tuple[float, ...]
    KF0: tuple[float, ...]
    KF1: tuple[float, ...]
    KF2: tuple[float, ...]

    @model_validator(mode="after")
    def _one_entry_a_speed(self) -> Self:
        _check_lengths(self, self.speed_mps, "KF0", "KF1", "KF2")
        return self


class PublishedTable3(Section):
    """Printed coefficients of N(T) at rest; `negative` takes the signed thrust."""

    positive: tuple[float, float, float, float]
    negative: tuple[float, float, float, float]


class PublishedTable4(Section):
    """Printed coefficients of N(T, V) by speed."""

    speed_mps: tuple[float, ...]
    T_max_n: tuple[float, ...]
    KN0: tuple[float, ...]
    KN1: tuple[float, ...]
    KN2: tuple[float, ...]
    KN3: tuple[float, ...]

    @model_validator(mode="after")
    def _one_entry_a_speed(self) -> Self:
        _check_lengths(self, self.speed_mps, "T_max_n", "KN0", "KN1", "KN2", "KN3")
        return self


class PublishedTable1(Section):
    """Printed coefficients of K_T(J) and K_M(J), ascending."""

    KT: tuple[float, ...]
    KM: tuple[float, ...]


class Published(Section):
    """Tables somebody printed, to compare with; never used in a fit."""

    source: str
    table1: PublishedTable1 | None = None
    table2: PublishedTable2 | None = None
    table3: PublishedTable3 | None = None
    table4: PublishedTable4 | None = None
