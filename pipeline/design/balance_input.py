"""Input of ``rig2sea design balance``. Angles of attack positive nose up, forces up positive."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from pipeline.design.printed import PublishedFigures
from pipeline.vehicle.attachment_schema import ModelSection as Section
from pipeline.vehicle.schema import Name

Force = Annotated[float, Field(gt=0, le=1e6)]
Slope = Annotated[float, Field(ge=-1e7, le=1e7)]
# forces are scaled with the square of a ratio of speeds, which must stay a number
Speed = Annotated[float, Field(ge=1e-3, le=20)]
Buoyancy = Annotated[float, Field(ge=-1e5, le=1e5)]
Angle = Annotated[float, Field(gt=0, lt=80)]
Arm = Annotated[float, Field(gt=0, le=50)]
Efficiency = Annotated[float, Field(gt=0, le=1)]
Points = Annotated[int, Field(ge=2, le=25)]


class BalanceHullInput(Section):
    """Forces of the water on the hull at one speed; they scale with speed squared.

    `drag_n` R_x(0), `lift_n_per_rad` K_alpha^y, `righting_nm_per_rad` K_alpha^z (positive rights),
    `drag_rise_n_per_rad2` what R_x gains with the square of the angle of attack.
    """

    at_speed_mps: Speed
    drag_n: Force
    lift_n_per_rad: Slope
    righting_nm_per_rad: Slope
    drag_rise_n_per_rad2: Annotated[float, Field(ge=0, le=1e7)] = 0.0


class ThrustersInput(Section):
    """Four stern thrusters on the axis, two in each plane, at an angle to it (eq. 5)."""

    angle_deg: Angle
    pitch_arm_m: Arm
    heading_arm_m: Arm


class LimitInput(Section):
    """What a thruster can give; without thrust or power, the tables of the vehicle, if any."""

    propeller_efficiency: Efficiency | None = None
    power_max_w: Annotated[float, Field(gt=0, le=1e6)] | None = None
    thrust_max_n: Force | None = None
    diameter_m: Annotated[float, Field(gt=0.005, lt=10)] | None = None
    """For the preliminary shaft speed, eq. (11), at an advance ratio of 1."""

    @model_validator(mode="after")
    def _power_needs_the_efficiency(self) -> Self:
        if self.power_max_w is not None and self.propeller_efficiency is None:
            raise ValueError("power_max_w needs propeller_efficiency")
        return self


class InputSpan(Section):
    """Values from `first` to `last`, evenly spaced."""

    first: Annotated[float, Field(ge=-1e5, le=1e5)]
    last: Annotated[float, Field(ge=-1e5, le=1e5)]
    points: Points = 13

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.first >= self.last:
            raise ValueError("first must be below last")
        return self


class EnvelopeInput(Section):
    """The region to look at."""

    speed_mps: InputSpan
    residual_buoyancy_n: InputSpan
    angle_deg: InputSpan

    @model_validator(mode="after")
    def _in_range(self) -> Self:
        if self.speed_mps.first <= 0 or self.speed_mps.last > 20:
            raise ValueError("envelope speeds must lie above 0 and not above 20 m/s")
        if self.angle_deg.first <= 0 or self.angle_deg.last >= 80:
            raise ValueError("envelope angles must lie above 0 and below 80 deg")
        return self


class BalanceInput(Section):
    """The whole file.

    Either `hull` with `metacentric_nm_per_rad`, `thrusters` and `residual_buoyancy_n`, or
    `vehicle`: a vehicle whose file has a model and an allocator; what is stated here goes before
    what its file says.
    """

    name: Name
    title: Annotated[str, Field(max_length=200)]
    source: Annotated[str, Field(max_length=1000)] = ""
    vehicle: Annotated[str, Field(max_length=300)] | None = None
    speed_mps: Speed
    residual_buoyancy_n: Buoyancy | None = None
    heading_moment_nm: Annotated[float, Field(ge=-1e5, le=1e5)] = 0.0
    metacentric_nm_per_rad: Annotated[float, Field(ge=0, le=1e6)] | None = None
    hull: BalanceHullInput | None = None
    thrusters: ThrustersInput | None = None
    limit: LimitInput = LimitInput()
    envelope: EnvelopeInput
    published: PublishedFigures | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.vehicle is None:
            needed = (
                "hull",
                "thrusters",
                "residual_buoyancy_n",
                "metacentric_nm_per_rad",
            )
            missing = [key for key in needed if getattr(self, key) is None]
            if missing:
                raise ValueError(f"without vehicle: the file must state {', '.join(missing)}")
        elif (self.hull is None) != (self.metacentric_nm_per_rad is None):
            raise ValueError("state hull and metacentric_nm_per_rad together or leave both out")
        return self
