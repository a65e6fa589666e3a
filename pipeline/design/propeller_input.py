"""Input of ``rig2sea design propeller``."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.design.printed import PublishedFigures
from pipeline.design.propeller_series import AREA_RATIOS, PITCH_RATIOS
from pipeline.vehicle.attachment_schema import ModelSection as Section
from pipeline.vehicle.schema import Name

Speed = Annotated[float, Field(ge=0, le=30)]
Diameter = Annotated[float, Field(gt=0.005, lt=10)]
Pitch = Annotated[float, Field(ge=PITCH_RATIOS[0], le=PITCH_RATIOS[1])]
Area = Annotated[float, Field(ge=AREA_RATIOS[0], le=AREA_RATIOS[1])]
Rpm = Annotated[float, Field(gt=0, le=50000)]
BladeCount = Annotated[int, Field(ge=2, le=7)]


class Required(Section):
    """What the propeller must do; the speed of advance is speed (1 - wake fraction)."""

    thrust_n: Annotated[float, Field(gt=0, le=1e7)]
    speed_mps: Speed
    wake_fraction: Annotated[float, Field(ge=-0.5, lt=1)] = 0.0


class DrivePoint(Section):
    """One working point of the drive: shaft power at a shaft speed."""

    kind: Literal["point"]
    power_w: Annotated[float, Field(gt=0, le=1e8)]
    shaft_speed_rpm: Rpm


class DriveCurve(Section):
    """The drive's mechanical characteristic at one code: largest torque against shaft speed."""

    kind: Literal["curve"]
    shaft_speed_rpm: tuple[Rpm, ...] = Field(min_length=2, max_length=200)
    torque_nm: tuple[Annotated[float, Field(ge=0, le=1e6)], ...] = Field(
        min_length=2, max_length=200
    )

    @model_validator(mode="after")
    def _pairs(self) -> Self:
        if len(self.torque_nm) != len(self.shaft_speed_rpm):
            raise ValueError(
                f"torque_nm has {len(self.torque_nm)} entries, shaft_speed_rpm "
                f"{len(self.shaft_speed_rpm)}"
            )
        pairs = zip(self.shaft_speed_rpm, self.shaft_speed_rpm[1:], strict=False)
        if any(a >= b for a, b in pairs):
            raise ValueError("shaft_speed_rpm must rise")
        return self


class DriveOfVehicle(Section):
    """The measured mechanical characteristic of a vehicle's drive, from its load tests."""

    kind: Literal["vehicle"]
    vehicle: Annotated[str, Field(max_length=300)]
    code: Annotated[float, Field(gt=0, le=32767)]


class WaterInput(Section):
    """The water; viscosity and vapour pressure default to 15 deg C."""

    density_kgpm3: Annotated[float, Field(gt=500, lt=1500)]
    gravity_mps2: Annotated[float, Field(gt=9.7, lt=9.9)] = 9.81
    shaft_depth_m: Annotated[float, Field(ge=0, le=12000)]
    vapour_pressure_pa: Annotated[float, Field(ge=0, le=20000)] = 1706.0
    kinematic_viscosity_m2ps: Annotated[float, Field(gt=1e-7, lt=1e-5)] = 1.14e-6


class Bounds(Section):
    """Where to look. Without `area_ratio` each number of blades stays where it was tested."""

    diameter_m: tuple[Diameter, Diameter]
    pitch_ratio: tuple[Pitch, Pitch] = PITCH_RATIOS
    area_ratio: tuple[Area, Area] | None = None
    blades: tuple[BladeCount, ...] = Field(default=(2, 3, 4, 5, 6, 7), min_length=1, max_length=6)

    @model_validator(mode="after")
    def _rise(self) -> Self:
        for name in ("diameter_m", "pitch_ratio", "area_ratio"):
            pair = getattr(self, name)
            if pair is not None and pair[0] > pair[1]:
                raise ValueError(f"{name} must be smallest, largest")
        if len(set(self.blades)) != len(self.blades):
            raise ValueError("blades has a number twice")
        return self


class CandidatePropeller(Section):
    """A propeller to look at beside those that are found."""

    label: Annotated[str, Field(max_length=80)]
    blades: BladeCount
    diameter_m: Diameter
    pitch_ratio: Pitch
    area_ratio: Area
    shaft_speed_rpm: Rpm | None = None
    """Without it: that of the drive's point, or that which gives the required thrust."""


class PropellerInput(Section):
    """The whole file."""

    name: Name
    title: Annotated[str, Field(max_length=200)]
    source: Annotated[str, Field(max_length=1000)] = ""
    required: Required
    drive: Annotated[DrivePoint | DriveCurve | DriveOfVehicle, Field(discriminator="kind")]
    water: WaterInput
    bounds: Bounds
    reynolds_correction: bool = False
    enforce_cavitation: bool = True
    keller_margin: Annotated[float, Field(ge=0, le=0.5)] = 0.2
    """k of Keller's formula: 0 for fast craft, 0.1 for two screws, 0.2 for one."""
    candidate: CandidatePropeller | None = None
    published: PublishedFigures | None = None
