"""What a person wrote of a pool run: ``<run>.yaml`` beside the log."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from pipeline.records.base import Record

Text = Annotated[str, Field(max_length=2_000)]
Name = Annotated[str, Field(min_length=1, max_length=200)]
Vector3 = tuple[float, float, float]


class BallastItem(Record):
    """Something put onto the vehicle, or taken off, that the vehicle file does not count.

    `mass_kg` in air, negative for what was taken off; `displaced_kg` is the mass of the water that
    it displaces. `position_m` in body axes: x forward, y starboard, z down.
    """

    what: Name
    mass_kg: Annotated[float, Field(ge=-10_000.0, le=10_000.0)]
    displaced_kg: Annotated[float, Field(ge=-10_000.0, le=10_000.0)] | None = None
    position_m: Vector3 | None = None


class WaterNotes(Record):
    """The water on the day."""

    kind: Literal["fresh", "salt", "brackish", "pool"] | None = None
    density_kgpm3: Annotated[float, Field(gt=900.0, lt=1200.0)] | None = None
    temperature_c: Annotated[float, Field(gt=-5.0, lt=60.0)] | None = None
    salinity_psu: Annotated[float, Field(ge=0.0, lt=100.0)] | None = None
    depth_m: Annotated[float, Field(gt=0.0, le=12_000.0)] | None = None
    """From surface to bottom."""
    current_mps: Annotated[float, Field(ge=0.0, le=10.0)] | None = None
    waves: Text = ""


class TetherNotes(Record):
    """The tether on the day."""

    attached: bool
    paid_out_m: Annotated[float, Field(ge=0.0, le=20_000.0)] | None = None
    diameter_mm: Annotated[float, Field(gt=0.0, le=500.0)] | None = None
    note: Text = ""


class RunNotes(Record):
    """Notes of one run. Nothing in them changes a number: they are shown, and compared."""

    what: Text = ""
    """The purpose, in one line."""
    who: tuple[Name, ...] = Field(default=(), max_length=50)
    when: Name | None = None
    """Date, as written."""
    where: Text = ""
    battery_v: Annotated[float, Field(gt=0.0, le=2_000.0)] | None = None
    """Supply at the start."""
    healthy: bool | None = None
    """The vehicle was as the vehicle file says, to the best knowledge of who wrote it."""
    ballast: tuple[BallastItem, ...] = Field(default=(), max_length=100)
    water: WaterNotes | None = None
    tether: TetherNotes | None = None
    changed: tuple[Name, ...] = Field(default=(), max_length=100)
    """What differs from the vehicle file or the run before."""
    text: Annotated[str, Field(max_length=20_000)] = ""
    """Anything else."""
    file: str = ""
    """Where they stand; not to be written."""

    @field_validator("who", "changed", mode="before")
    @classmethod
    def _one_is_a_list_of_one(cls, value: object) -> object:
        # a tuple, because the file is checked strictly and a list is none
        if isinstance(value, str):
            return (value,)
        return tuple(value) if isinstance(value, list) else value
