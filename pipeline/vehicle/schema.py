"""``vehicle.yaml`` as frozen models. Units SI, axes SNAME unless the file names another frame."""

from collections.abc import Iterable
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from pipeline.records.pool_schema import PoolColumns, unknown_thruster
from pipeline.vehicle.attachment_schema import ModelSection as Section
from pipeline.vehicle.bench_schema import Columns, Published
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


def _unknown(what: str, name: str, known: Iterable[str], *path: str | int) -> PydanticCustomError:
    """Build the error for a name that is not among those of a section, `what` with an s."""
    among = ", ".join(known) or "none"
    return _fault_at(f'there is no {what} "{name}"; {what}s has {among}', *path)


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
    """A motor with its controller, commanded by a code; `code_min` 0: it never turns backwards."""

    code_min: Annotated[int, Field(ge=-32767, le=0)]
    code_max: Annotated[int, Field(gt=0, le=32767)]
    source: str = ""


class Thruster(Section):
    """One thruster; `direction` (a unit vector) is where it pushes the vehicle at positive code."""

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
    """A portion only limits its channel, or scales it (eq. 6 as printed)."""


class TypeTables(Section):
    """Which thruster tables are for and where; the code is 0 up to `thrust_dead_n`."""

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

    @property
    def kind(self) -> tuple[str, str]:
        """Drive and propeller."""
        return self.drive, self.propeller


class FurtherTables(TypeTables):
    """One more type of thruster; its bench files lie in folders of its name."""

    columns: Columns | None = None
    """Where its files have other columns than those of `columns:`."""


class Tables(TypeTables):
    """The type of thruster whose bench files lie in the tests' folders, and further `types`."""

    types: dict[Name, FurtherTables] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _each_thruster_has_one_type(self) -> Self:
        seen = {self.kind: "tables"}
        for name, one in self.types.items():
            if one.kind in seen:
                raise ValueError(
                    f"types.{name} has drive {one.drive} and propeller {one.propeller}, as "
                    f"{seen[one.kind]} has; each type of thruster has its own"
                )
            seen[one.kind] = f"types.{name}"
        return self


Gate = Literal["thrust_rises", "neighbours", "neutral", "outliers", "signs"]
"""A check that stops the firmware while it fails and `accept` does not name it."""


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
    battery_minutes: Annotated[float, Field(gt=0.0, le=10_000.0)] | None = None
    """How long one charge lasts in the pool: no plan asks for more. [min]"""
    published: Published | None = None
    accept: dict[Gate, Annotated[str, Field(min_length=10, max_length=400)]] = Field(
        default_factory=dict
    )
    """Failed checks that the firmware is written in spite of, each with the reason."""

    @model_validator(mode="after")
    def _names_exist(self) -> Self:
        names = [thruster.name for thruster in self.thrusters]
        for index, name in enumerate(names):
            if name in names[:index]:
                raise _fault_at(f'thruster "{name}" is there twice', "thrusters", index, "name")
        used: list[tuple[tuple[str | int, ...], TypeTables | Thruster]]
        used = [(("tables",), self.tables)]
        used += [(("tables", "types", name), one) for name, one in self.tables.types.items()]
        used += [(("thrusters", index), one) for index, one in enumerate(self.thrusters)]
        for path, user in used:
            for kind, name, known in (
                ("propeller", user.propeller, self.propellers),
                ("drive", user.drive, self.drives),
            ):
                if name not in known:
                    raise _unknown(kind, name, known, *path, kind)
        if self.allocator is not None:
            for part in ("upper", "lower", "left", "right", "bow"):
                name = getattr(self.allocator, part)
                if name is not None and name not in names:
                    raise _unknown("thruster", name, names, "allocator", part)
        unknown = unknown_thruster(self.pool, tuple(names))
        if unknown is not None:
            raise _unknown(
                "thruster", unknown[1], names, "pool", "channels", unknown[0], "thrusters"
            )
        return self

    @model_validator(mode="after")
    def _the_model_knows_every_drive(self) -> Self:
        if self.model is None:
            return self
        for drive, behaviour in self.model.thrusters.items():
            path = ("model", "thrusters", drive)
            if drive not in self.drives:
                raise _unknown("drive", drive, self.drives, *path)
            kind, with_tables = behaviour.characteristic.kind, [one[0] for one in self.kinds]
            if kind in {"tables", "mooring"} and drive not in with_tables:
                text = (
                    f'"kind: {kind}" is for the drives of tables, which are '
                    f"{', '.join(with_tables)}; give this one a bollard characteristic, or a type "
                    "of its own in tables.types"
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
                    raise _unknown("thruster", name, names, "model", key, "thrusters", name)
        return self

    @property
    def kinds(self) -> dict[tuple[str, str], str]:
        """Types of thruster by drive and propeller: "" that of `tables`, names of `types`."""
        return {self.tables.kind: "", **{one.kind: name for name, one in self.tables.types.items()}}

    def type_of(self, thruster: Thruster) -> str | None:
        """Return the type of a thruster; None of one that no tables are for."""
        return self.kinds.get((thruster.drive, thruster.propeller))

    @property
    def used_types(self) -> tuple[str, ...]:
        """Types of the thrusters that it has, that of `tables` first and always."""
        used = {self.type_of(one) for one in self.thrusters}
        return ("", *(name for name in self.tables.types if name in used))

    def of_type(self, thruster_type: str) -> "Vehicle":
        """Return what the bench of one type of thruster needs: its tables, and nothing that flies.

        Raises
        ------
        KeyError
            When `tables.types` has no such type.
        """
        if not thruster_type:
            return self
        one = self.tables.types[thruster_type]
        stated = {name: getattr(one, name) for name in TypeTables.model_fields}
        changes: dict[str, object] = {
            "name": f"{self.name}-{thruster_type}",
            "title": f"{self.title}, thruster type {thruster_type}",
            "tables": Tables.model_construct(**stated),
            "columns": one.columns or self.columns,
            "thrusters": (),
            "allocator": None,
            "model": None,
            "published": None,
        }
        return self.model_copy(update=changes)

    @property
    def propeller(self) -> Propeller:
        """The propeller that the tables are for."""
        return self.propellers[self.tables.propeller]

    @property
    def drive(self) -> Drive:
        """The drive that the tables are for."""
        return self.drives[self.tables.drive]
