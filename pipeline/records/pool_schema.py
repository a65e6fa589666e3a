"""The ``pool:`` section of the vehicle file: which topic of a pool-run log carries which quantity.

Everything here is optional: standard messages have defaults. A channel that is stated replaces the
default for its quantity.
"""

import math
import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from pipeline.units import STANDARD_GRAVITY_MPS2

Quantity = Literal[
    "thruster_command",
    "shaft_speed",
    "voltage",
    "current",
    "angular_velocity",
    "specific_force",
    "attitude_quaternion",
    "attitude_euler",
    "velocity",
    "velocity_earth",
    "position",
    "depth",
    "pressure",
    "thrust",
    "cable_tension",
]
BodyAxes = Literal["frd", "flu", "fur"]
EarthAxes = Literal["ned", "enu", "nwu"]

_DEGREE = 3.141592653589793 / 180.0
_TURN_PER_MINUTE = 2.0 * 3.141592653589793 / 60.0
_METRE = {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}
_FORCE = {"N": 1.0, "kN": 1e3, "kgf": STANDARD_GRAVITY_MPS2, "gf": 1e-3 * STANDARD_GRAVITY_MPS2,
          "lbf": 4.4482216152605}  # fmt: skip
_SPEED = {"m/s": 1.0, "dm/s": 0.1, "cm/s": 1e-2, "mm/s": 1e-3, "kn": 1852.0 / 3600.0,
          "km/h": 1.0 / 3.6, "ft/s": 0.3048}  # fmt: skip
#: Quantity -> how many components it has (None: one a thruster), and its units.
_QUANTITIES: dict[str, tuple[int | None, Mapping[str, float]]] = {
    "thruster_command": (None, {"code": 1.0, "us": 1.0, "ratio": 1.0, "%": 1.0}),
    "shaft_speed": (
        None,
        {"rpm": 1.0, "rad/s": 1.0 / _TURN_PER_MINUTE, "rps": 60.0, "Hz": 60.0, "deg/s": 1.0 / 6.0},
    ),
    "voltage": (1, {"V": 1.0, "mV": 1e-3, "kV": 1e3}),
    "current": (1, {"A": 1.0, "mA": 1e-3, "cA": 1e-2}),
    "angular_velocity": (
        3,
        {
            "rad/s": 1.0,
            "mrad/s": 1e-3,
            "deg/s": _DEGREE,
            "mdeg/s": 1e-3 * _DEGREE,
            "rpm": _TURN_PER_MINUTE,
        },
    ),
    "specific_force": (
        3,
        {
            "m/s2": 1.0,
            "cm/s2": 1e-2,
            "mm/s2": 1e-3,
            "g": STANDARD_GRAVITY_MPS2,
            "mg": 1e-3 * STANDARD_GRAVITY_MPS2,
        },
    ),
    "attitude_quaternion": (4, {"1": 1.0}),
    "attitude_euler": (3, {"rad": 1.0, "deg": _DEGREE, "mrad": 1e-3}),
    "velocity": (3, _SPEED),
    "velocity_earth": (3, _SPEED),
    "position": (3, _METRE),
    "depth": (1, _METRE),
    "pressure": (
        1,
        {
            "Pa": 1.0,
            "hPa": 100.0,
            "mbar": 100.0,
            "kPa": 1e3,
            "bar": 1e5,
            "MPa": 1e6,
            "dbar": 1e4,
            "psi": 6894.757293168,
        },
    ),
    "thrust": (None, _FORCE),
    "cable_tension": (1, _FORCE),
}
#: Quantity -> unit as it is written in the vehicle file -> what one of it is worth in the unit of
#: the records, which stands first. Commands are converted by drive, so theirs are worth nothing.
UNITS = MappingProxyType({name: units for name, (_, units) in _QUANTITIES.items()})
#: How many components a quantity has; None: one a thruster.
COMPONENTS = MappingProxyType({name: count for name, (count, _) in _QUANTITIES.items()})
#: What one tick of a board's clock is worth. [ns]
CLOCK_UNITS_NS: Mapping[str, int] = MappingProxyType(
    {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
)
_PART = r"[A-Za-z_][A-Za-z0-9_]*(\[[0-9]{1,6}(:[0-9]{1,6})?\])?"
_RANGE = re.compile(r"\[([0-9]+):([0-9]+)\]")
_MOST_ELEMENTS = 10_000
_FIELD = re.compile(rf"^{_PART}(\.{_PART}){{0,19}}$")
FieldPath = Annotated[str, Field(min_length=1, max_length=400)]
Sign = Literal[1, -1]


class PoolChannel(BaseModel):
    """Where one quantity stands in the log.

    `field` is the path of a number, of an array, of a part of it (``data[1:4]``) or of a message
    whose numbers are meant (``twist.linear``); a list of paths puts the components together.
    `index` picks elements of what `field` gives, counted from 0. `sign` turns components before
    the axes are. A quaternion is x, y, z, w unless `order` says otherwise; Euler angles are roll,
    pitch, yaw (rotations Z Y X).
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    quantity: Quantity
    topic: Annotated[str, Field(min_length=1, max_length=400)]
    field: tuple[FieldPath, ...] | None = None
    index: tuple[Annotated[int, Field(ge=0, lt=1_000_000)], ...] | None = None
    unit: str | None = None
    sign: tuple[Sign, ...] = (1,)
    """One for all components, or one each."""
    order: Literal["xyzw", "wxyz"] = "xyzw"
    thrusters: tuple[str, ...] | None = None
    """Names of the elements, in their order; default: all thrusters in the order of the file."""
    neutral: Annotated[float, Field(ge=0.0, le=1e5)] | None = None
    """Command at rest, in `unit`: 0.5 where 0 to 1 is full reverse to full ahead."""
    body_axes: BodyAxes | None = None
    earth_axes: EarthAxes | None = None
    clock: Literal["header", "log"] | None = None
    clock_field: FieldPath | None = None
    """Field with the time that the board which made the reading counts, in `clock_unit`."""
    clock_unit: Literal["s", "ms", "us", "ns"] | None = None
    delay_s: Annotated[float, Field(ge=-10.0, le=60.0)] | None = None
    """Age of a reading at the time that the clock gives."""
    surface_pressure_pa: float | None = None
    """What a pressure sensor reads at the surface; 0 for one that reads from there."""
    lowest: float | None = None
    """Lowest and highest reading that the sensor can give, in the unit of the records."""
    highest: float | None = None
    source: str = ""

    @field_validator("field", "index", "sign", mode="before")
    @classmethod
    def _one_is_a_list_of_one(cls, value: object) -> object:
        # a tuple, because the file is checked strictly and a list is none
        if isinstance(value, str | int):
            return (value,)
        return tuple(value) if isinstance(value, list) else value

    @field_validator("field", "clock_field")
    @classmethod
    def _paths_can_be_read(
        cls, value: tuple[str, ...] | str | None
    ) -> tuple[str, ...] | str | None:
        for path in (value,) if isinstance(value, str) else value or ():
            if not _FIELD.fullmatch(path):
                raise ValueError(
                    f'"{path}" is not the path of a field; names parted by dots are expected, '
                    "elements as data[0] or data[1:4]"
                )
            counts = [int(last) - int(first) for first, last in _RANGE.findall(path)]
            if min(counts, default=1) < 1:
                raise ValueError(f'"{path}" names no element: a range such as data[1:4] must rise')
            if math.prod(counts) > _MOST_ELEMENTS:
                raise ValueError(f'"{path}" names more than {_MOST_ELEMENTS} elements')
        return value

    @field_validator("clock_field")
    @classmethod
    def _a_time_is_one_number(cls, value: str | None) -> str | None:
        if value is not None and _RANGE.search(value):
            raise ValueError(f'"{value}" names several elements; a time is one number')
        return value

    @model_validator(mode="after")
    def _unit_and_signs_fit(self) -> Self:
        if self.unit is not None and self.unit not in UNITS[self.quantity]:
            raise ValueError(
                f'"{self.unit}" is not a unit of {self.quantity}; it has '
                f"{', '.join(UNITS[self.quantity])}"
            )
        count = COMPONENTS[self.quantity]
        if count is not None and len(self.sign) not in (1, count):
            raise ValueError(f"sign has {len(self.sign)} entries, {self.quantity} has {count}")
        if self.thrusters is not None and count is not None:
            raise ValueError(f"{self.quantity} does not belong to thrusters")
        if self.neutral is not None and (
            self.quantity != "thruster_command"
            or self.unit not in {"ratio", "%", "code"}
            or self.neutral >= {"ratio": 1.0, "%": 100.0}.get(self.unit, math.inf)
        ):
            raise ValueError(
                "neutral is that of thruster_command in ratio, % or code, below full command; of "
                "pulse widths it is pwm_range: neutral_us"
            )
        if (self.clock_field is None) != (self.clock_unit is None):
            raise ValueError("clock_field and clock_unit go together")
        if self.clock_field is not None and self.clock is not None:
            raise ValueError("give either clock or clock_field")
        if self.lowest is not None and self.highest is not None and self.lowest >= self.highest:
            raise ValueError("lowest must be below highest")
        return self


class PulseWidth(BaseModel):
    """How pulse width becomes a code: code = (pwm - neutral) / half_range * code_max."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    neutral_us: Annotated[float, Field(gt=0)] = 1500.0
    half_range_us: Annotated[float, Field(gt=0)] = 400.0


class PoolColumns(BaseModel):
    """Mapping of the channels of pool-run logs."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    defaults: bool = True
    """Look for quantities that are not stated in standard messages."""
    channels: tuple[PoolChannel, ...] = Field(default=(), max_length=200)
    ignore_topics: tuple[str, ...] = ()
    """Topics that the defaults leave alone."""
    pwm_range: PulseWidth = PulseWidth()


def unknown_thruster(columns: PoolColumns, names: tuple[str, ...]) -> tuple[int, str] | None:
    """Return the first channel (index) that names a thruster (text) that is not in `names`.

    >>> channel = PoolChannel(quantity="shaft_speed", topic="/rpm", thrusters=("bow",))
    >>> unknown_thruster(PoolColumns(channels=(channel,)), ("stern",))
    (0, 'bow')
    """
    for index, channel in enumerate(columns.channels):
        for name in channel.thrusters or ():
            if name not in names:
                return index, name
    return None
