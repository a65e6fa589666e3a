"""``vehicle.yaml`` as frozen models. Units SI, axes SNAME unless the file names another frame."""

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pipeline.records.pool_schema import PoolColumns, unknown_thruster
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.sensor_schema import Sensors

Positive = Annotated[float, Field(gt=0)]
Fraction = Annotated[float, Field(gt=0, le=1)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,47}$")]
Vector3 = tuple[float, float, float]
Day = Annotated[str, Field(pattern=r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$")]
#: A thruster with less of its thrust than this gives none.
LEAST_GAIN = 0.05
Gain = Annotated[float, Field(ge=0, le=20)]
Frame = Literal["sname", "paper", "ros"]
"""Body axes of the file's positions; `pipeline.vehicle.frames` has them."""


def _fault_at(text: str, *path: str | int) -> PydanticCustomError:
    """Build an error that tells the reader of the file which of its lines is meant."""
    return PydanticCustomError("vehicle", "{text}", {"text": text, "path": path})


class Section(BaseModel):
    """A part of the vehicle file: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Water(Section):
    """The water that the tables are computed for."""

    density_kgpm3: Annotated[float, Field(gt=500, lt=1500)]
    gravity_mps2: Annotated[float, Field(gt=9.7, lt=9.9)]


class Propeller(Section):
    """Geometry of a screw propeller."""

    diameter_m: Annotated[float, Field(gt=0.005, lt=10)]
    pitch_ratio: Positive | None = None
    area_ratio: Fraction | None = None
    blades: Annotated[int, Field(ge=1, le=12)] | None = None
    source: str = ""


class Drive(Section):
    """A motor with its controller, commanded by a code."""

    code_min: Annotated[int, Field(ge=-32767, le=0)]
    code_max: Annotated[int, Field(gt=0, le=32767)]
    source: str = ""


class Thruster(Section):
    """One thruster; `direction` is where it pushes the vehicle at positive code."""

    name: Name
    propeller: Name
    drive: Name
    position_m: Vector3
    direction: Vector3
    gain_ahead: Gain = 1.0
    """Thrust of this one over that of the characteristic, at positive codes; 0: a dead one."""
    gain_reverse: Gain = 1.0
    dead_zone_code: Annotated[float, Field(ge=0)] = 0.0
    """Codes that it loses at either side of zero, on top of the characteristic's dead zone."""
    lag_s: Annotated[float, Field(ge=0, le=60)] | None = None
    """Its own time constant in place of that of its drive."""

    @field_validator("gain_ahead", "gain_reverse")
    @classmethod
    def _dead_or_alive(cls, gain: float) -> float:
        if 0.0 < gain < LEAST_GAIN:
            raise ValueError(f"{gain:g} is expected to be at least {LEAST_GAIN}, or 0: no thrust")
        return gain

    @model_validator(mode="after")
    def _direction_is_a_unit_vector(self) -> Self:
        length = sum(part * part for part in self.direction) ** 0.5
        if abs(length - 1.0) > 1e-3:
            raise ValueError(f"direction has length {length:.4f}, a unit vector is expected")
        return self


class Portions(Section):
    """The largest share of T_max that each control channel may use (Kostenko 2023, eq. 6)."""

    surge: Fraction
    heading: Fraction
    pitch: Fraction

    @model_validator(mode="after")
    def _channels_that_share_a_thruster_fit_into_it(self) -> Self:
        for channel, share in (("heading", self.heading), ("pitch", self.pitch)):
            if self.surge + share > 1.0 + 1e-9:
                raise ValueError(
                    f"surge + {channel} = {self.surge + share:.3g}, at most 1 is expected: "
                    "they share the same thrusters"
                )
        return self


class Allocator(Section):
    """Four inclined stern thrusters and an optional bow one (Kostenko 2023, fig. 8, eq. 5).

    `delta_deg` is the angle of the stern thrusters to the longitudinal axis, `stern_arm_m` L_s,
    `bow_arm_m` L_b. `upper`, `lower`, `left`, `right`, `bow` name the thrusters.
    """

    delta_deg: Annotated[float, Field(gt=0, lt=90)]
    stern_arm_m: Positive
    bow_arm_m: Positive | None = None
    upper: Name
    lower: Name
    left: Name
    right: Name
    bow: Name | None = None
    portions: Portions
    form: Literal["limit", "scaled"] = "limit"


class Tables(Section):
    """Which thruster the tables are for and where they are tabulated."""

    propeller: Name
    drive: Name
    speed_mps: tuple[Annotated[float, Field(ge=0, le=20)], ...] = (0.0, 0.5, 1.0, 1.5, 2.0)
    thrust_dead_n: Positive = 0.5
    supply_voltage_v: Positive | None = None
    """Of a mooring file taken at several voltages, the one that the tables are for."""

    @model_validator(mode="after")
    def _speeds_rise_from_zero(self) -> Self:
        pairs = zip(self.speed_mps, self.speed_mps[1:], strict=False)
        if not self.speed_mps or self.speed_mps[0] != 0.0 or any(a >= b for a, b in pairs):
            raise ValueError("speed_mps must start at 0 and rise")
        return self


Gate = Literal["thrust_rises", "neighbours", "neutral", "outliers", "signs"]
"""A check that stops the firmware while it fails and `accept` does not name it."""


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
    only: dict[str, str] = {}


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


def _check_dead_zone(dead: float, drive: Drive, path: tuple[str, ...]) -> None:
    """Raise unless codes of each sign that the drive has reach beyond the dead zone."""
    text = ""
    if dead >= drive.code_max:
        text = f"it must be below code_max of the drive, {drive.code_max}"
    elif 0 < -drive.code_min <= dead:
        text = (
            f"code_min of the drive, {drive.code_min}, lies inside it, so that no code turns the "
            "drive backwards; a drive that does not turn backwards has code_min: 0"
        )
    if text:
        raise _fault_at(text, *path, "characteristic", "dead_zone_code")


class Vehicle(Section):
    """The whole vehicle file."""

    name: Name
    title: str
    data_note: str = ""
    """Shown at the top of the report: where the raw files are from."""
    frame: Frame = "sname"
    """How the file states positions; a vehicle that `load_vehicle` returns has them in SNAME."""
    water: Water
    propellers: dict[Name, Propeller]
    drives: dict[Name, Drive]
    thrusters: tuple[Thruster, ...] = Field(default=(), max_length=12)
    allocator: Allocator | None = None
    model: Model | None = None
    sensors: Sensors | None = None
    tables: Tables
    columns: Columns = Columns()
    pool: PoolColumns = PoolColumns()
    accepted_days: tuple[Day, ...] = Field(default=(), max_length=1000)
    """Trial days on which the vehicle was well; their runs are what it is compared with later."""
    diagnose: bool = True
    """Whether every pool day is diagnosed by `rig2sea run`."""
    published: Published | None = None
    accept: dict[Gate, Annotated[str, Field(min_length=10, max_length=400)]] = {}
    """Failed checks that the firmware is written in spite of, each with the reason."""

    @model_validator(mode="after")
    def _names_exist(self) -> Self:
        names = [thruster.name for thruster in self.thrusters]
        for index, name in enumerate(names):
            if name in names[:index]:
                raise _fault_at(f'thruster "{name}" is there twice', "thrusters", index, "name")
        used: list[tuple[tuple[str | int, ...], Tables | Thruster]] = [(("tables",), self.tables)]
        used += [(("thrusters", index), one) for index, one in enumerate(self.thrusters)]
        for path, user in used:
            for kind, name, known in (
                ("propeller", user.propeller, tuple(self.propellers)),
                ("drive", user.drive, tuple(self.drives)),
            ):
                if name not in known:
                    among = ", ".join(known) or "none"
                    text = f'there is no {kind} "{name}"; {kind}s has {among}'
                    raise _fault_at(text, *path, kind)
        if self.allocator is not None:
            for part in ("upper", "lower", "left", "right", "bow"):
                name = getattr(self.allocator, part)
                if name is not None and name not in names:
                    among = ", ".join(names) or "none"
                    text = f'there is no thruster "{name}"; thrusters has {among}'
                    raise _fault_at(text, "allocator", part)
        unknown = unknown_thruster(self.pool, tuple(names))
        if unknown is not None:
            among = ", ".join(names) or "none"
            text = f'there is no thruster "{unknown[1]}"; thrusters has {among}'
            raise _fault_at(text, "pool", "channels", unknown[0], "thrusters")
        return self

    @model_validator(mode="after")
    def _the_model_knows_every_drive(self) -> Self:
        if self.model is None:
            return self
        known = ", ".join(self.drives) or "none"
        for drive, behaviour in self.model.thrusters.items():
            path = ("model", "thrusters", drive)
            if drive not in self.drives:
                text = f'there is no drive "{drive}"; drives has {known}'
                raise _fault_at(text, *path)
            kind = behaviour.characteristic.kind
            if kind in {"tables", "mooring"} and drive != self.tables.drive:
                text = (
                    f'"kind: {kind}" is for the drive of the tables, '
                    f'which is "{self.tables.drive}"; give this one a bollard characteristic'
                )
                raise _fault_at(text, *path, "characteristic")
            if behaviour.balance_in_time and behaviour.characteristic.kind != "tables":
                text = (
                    "the balance takes propeller and drive from the bench, so it needs "
                    '"kind: tables"; with a bollard characteristic give lag_s'
                )
                raise _fault_at(text, *path, "balance_in_time")
            if behaviour.characteristic.kind == "bollard":
                _check_dead_zone(behaviour.characteristic.dead_zone_code, self.drives[drive], path)
        for thruster in self.thrusters:
            if thruster.drive not in self.model.thrusters:
                text = (
                    f'it lacks the drive "{thruster.drive}", which thruster "{thruster.name}" has'
                )
                raise _fault_at(text, "model", "thrusters")
        return self

    @model_validator(mode="after")
    def _the_keys_of_thrusters_fit(self) -> Self:
        for index, one in enumerate(self.thrusters):
            if one.dead_zone_code >= (largest := self.drives[one.drive].code_max):
                text = f"it must be below code_max of the drive, {largest}"
                raise _fault_at(text, "thrusters", index, "dead_zone_code")
        names = [thruster.name for thruster in self.thrusters]
        for key in ("wake_fraction", "thrust_deduction"):
            section = getattr(self.model, key, None)
            for name in section.thrusters if section is not None else ():
                if name not in names:
                    among = ", ".join(names) or "none"
                    text = f'there is no thruster "{name}"; thrusters has {among}'
                    raise _fault_at(text, "model", key, "thrusters", name)
        return self

    @property
    def propeller(self) -> Propeller:
        """The propeller that the tables are for."""
        return self.propellers[self.tables.propeller]

    @property
    def drive(self) -> Drive:
        """The drive that the tables are for."""
        return self.drives[self.tables.drive]
