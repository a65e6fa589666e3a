"""Input of ``rig2sea design tether``. Axes of the paper: X ahead, Y up, Z to starboard."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.design.printed import PublishedFigures
from pipeline.vehicle.attachment_schema import ModelSection as Section
from pipeline.vehicle.schema import Name

Length = Annotated[float, Field(gt=0, le=20000)]
Velocity = Annotated[float, Field(ge=-10, le=10)]
Velocities = tuple[Velocity, Velocity, Velocity]
Coefficient = Annotated[float, Field(gt=0, le=10)]
Efficiency = Annotated[float, Field(gt=0, le=1)]
Number = Annotated[float, Field(ge=-1e6, le=1e6)]
PrintedRow = tuple[Number, Number, Number, Number, Number, Number, Number, Number, Number]


class CableInput(Section):
    """The cable; both drag coefficients are referred to the diameter."""

    length_m: Length
    diameter_m: Annotated[float, Field(gt=1e-4, lt=1)]
    normal_drag: Coefficient
    tangential_drag: Annotated[float, Field(ge=0, le=1)]
    wet_weight_npm: Annotated[float, Field(ge=-1000, le=1000)] = 0.0
    """Weight less buoyancy of a metre; 0 is a neutral cable."""


class PlaceInput(Section):
    """The footprint: a circle about the garage's vertical; `height_m` negative below the garage."""

    radius_m: Annotated[float, Field(gt=0, le=20000)]
    height_m: Annotated[float, Field(ge=-12000, le=12000)]
    step_deg: Literal[10, 15, 20, 30, 45, 60, 90] = 30


class HullInput(Section):
    """Drag of the hull, eq. (4), and the residual buoyancy (up positive).

    `drag_coefficients` are ahead, up and to starboard of the vehicle: along X, Y, Z at heading 0.
    """

    displacement_m3: Annotated[float, Field(gt=0, le=1000)]
    drag_coefficients: tuple[Coefficient, Coefficient, Coefficient]
    residual_buoyancy_n: Annotated[float, Field(ge=-1e5, le=1e5)]


class DriveInput(Section):
    """Efficiencies, eq. (6)."""

    propeller_efficiency: Efficiency
    drive_efficiency: Efficiency


class HeldInput(Section):
    """The vehicle whose identified thrusters must hold the footprint.

    It heads `heading_deg` from X towards Z; the cable pulls at `attachment_m` (body axes, x ahead,
    y starboard, z down). Forces and the yawing moment are held; roll and pitch are left to its
    weight and buoyancy.
    """

    vehicle: Annotated[str, Field(max_length=300)]
    heading_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    attachment_m: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    largest_radius_m: Length | None = None
    """As far as the cable reaches without it."""


class PublishedTether(PublishedFigures):
    """Printed tables. Rows: angle; T_x, T_y, T_z, |T| at the garage; the same at the vehicle."""

    footprint: tuple[PrintedRow, ...] = Field(default=(), max_length=72)
    footprint_table: str = ""
    footprint_reason: Annotated[str, Field(max_length=1000)] = ""
    largest_pull_n: tuple[Number, Number, Number, Number] | None = None
    """|T_x|, |T_y|, |T_z|, |T| as printed; forces and powers are also computed from these."""


class TetherInput(Section):
    """The whole file."""

    name: Name
    title: Annotated[str, Field(max_length=200)]
    source: Annotated[str, Field(max_length=1000)] = ""
    cable: CableInput
    footprint: PlaceInput
    vehicle_velocity_mps: Velocities
    current_mps: Velocities
    density_kgpm3: Annotated[float, Field(gt=500, lt=1500)]
    flow: Literal["paper", "uniform", "vector"] = "uniform"
    """How the vehicle's own velocity falls off along the cable; all with a solution are shown."""
    current_from_any_side: bool = True
    """Whether the current may come along Z too: X and Z then take the larger of both pulls."""
    hull: HullInput | None = None
    drive: DriveInput
    held: HeldInput | None = None
    published: PublishedTether | None = None

    @model_validator(mode="after")
    def _a_hull(self) -> Self:
        if self.hull is None and self.held is None:
            raise ValueError("state hull, or held with a vehicle whose file has a model")
        return self
