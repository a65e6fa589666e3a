"""What a vehicle carries: ballast, payload modules with their latches, a tether with its winch.

A part of the ``model:`` section; axes as there.
"""

import math
from typing import Annotated, ClassVar

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from pipeline.vehicle.model_checks import inertia_fault

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector3 = tuple[float, float, float]
NotNegative3 = tuple[NotNegative, NotNegative, NotNegative]


class ModelSection(BaseModel):
    """A part of the model: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Ballast(ModelSection):
    """Something put onto the dry body, or taken off: a lump at a place. Negative is taken off."""

    inertia_kgm2: ClassVar[Vector3] = (0.0, 0.0, 0.0)

    what: Annotated[str, Field(min_length=1, max_length=200)]
    mass_kg: float
    """In air."""
    volume_m3: float = 0.0
    """Water that it displaces; 0 inside the hull."""
    position_m: Vector3
    source: str = ""


class LatchSection(ModelSection):
    """The gripper's latch that holds a module: where, and what it can carry."""

    position_m: Vector3 | None = None
    """Where it holds, body axes; the module's centre of mass without it."""
    strength_n: Positive
    strength_nm: Positive
    closing_s: Positive = 0.1
    """Time in which it closes on a module."""
    source: str = ""


class Payload(ModelSection):
    """A module that can be attached and released in flight."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,47}$")]
    mass_kg: Positive
    volume_m3: Positive
    position_m: Vector3
    inertia_kgm2: NotNegative3 = (0.0, 0.0, 0.0)
    """About its own centre of mass; zero for a point."""
    attached: bool = True
    latch: LatchSection | None = None
    source: str = ""

    @field_validator("inertia_kgm2")
    @classmethod
    def _a_body_can_have_it(cls, inertia_kgm2: Vector3) -> Vector3:
        fault = inertia_fault((*inertia_kgm2, 0.0, 0.0, 0.0)) if any(inertia_kgm2) else None
        if fault:
            raise ValueError(fault)
        return inertia_kgm2


class WinchSection(ModelSection):
    """The drum at the tether's upper end; torques and inertia are those at the drum."""

    drum_radius_m: Positive
    inertia_kgm2: Positive
    stall_torque_nm: Positive
    """At full command and no speed."""
    no_load_radps: Positive
    """At full command and no torque."""
    viscous_nms: NotNegative = 0.0
    dry_friction_nm: NotNegative = 0.0
    brake_nm: NotNegative = 0.0
    """What the brake holds at command 0, on top of the friction."""
    shortest_m: Positive = 1.0
    """Paid-out length at which it stops hauling in."""
    longest_m: Positive = 1000.0
    """Paid-out length at which it stops paying out."""
    source: str = ""

    @field_validator("longest_m")
    @classmethod
    def _above_the_shortest(cls, longest_m: float, info: ValidationInfo) -> float:
        shortest_m = info.data.get("shortest_m")
        if shortest_m is not None and longest_m <= shortest_m:
            raise ValueError(f"{longest_m:g} m is not above shortest_m, {shortest_m:g} m")
        return longest_m


class Tether(ModelSection):
    """A cable from a fixed upper end (or a ship) to the vehicle, which starts at the NED origin."""

    attachment_m: Vector3
    anchor_ned_m: Vector3 = (0.0, 0.0, 0.0)
    length_m: Positive
    diameter_m: Positive
    mass_kgpm: Positive
    """Mass in air per metre."""
    normal_drag: Positive = 1.2
    tangential_drag: NotNegative = 0.01
    axial_stiffness_n: Positive = 1e5
    segments: Annotated[int, Field(ge=2, le=200)] = 20
    in_nominal: bool = False
    winch: WinchSection | None = None
    source: str = ""

    @field_validator("length_m")
    @classmethod
    def _reaches_the_vehicle(cls, length_m: float, info: ValidationInfo) -> float:
        attachment_m, anchor_m = (info.data.get(key) for key in ("attachment_m", "anchor_ned_m"))
        if attachment_m is not None and anchor_m is not None:
            # the anchor is NED: the attachment is compared in SNAME axes, level and heading north
            x, y, z = attachment_m
            turned = {"paper": (x, z, -y), "ros": (x, -y, -z)}
            attachment_m = turned.get(str((info.context or {}).get("frame")), attachment_m)
            distance_m = math.dist(attachment_m, anchor_m)
            if length_m < distance_m:
                raise ValueError(
                    f"{length_m:g} m is too short: from the anchor to the attachment it is "
                    f"{distance_m:.3f} m with the vehicle at the NED origin, where runs start"
                )
        return length_m

    @field_validator("winch")
    @classmethod
    def _the_winch_fits(
        cls, winch: WinchSection | None, info: ValidationInfo
    ) -> WinchSection | None:
        length_m, segments = (info.data.get(key) for key in ("length_m", "segments"))
        if winch is None or length_m is None or segments is None:
            return winch
        if not winch.shortest_m <= length_m <= winch.longest_m:
            raise ValueError(
                f"length_m {length_m:g} is paid out at the start, outside of shortest_m "
                f"{winch.shortest_m:g} to longest_m {winch.longest_m:g}"
            )
        if winch.shortest_m < 2 * length_m / segments:
            raise ValueError(
                f"shortest_m {winch.shortest_m:g} is less than two of the {segments} segments of "
                f"{length_m / segments:g} m; state more segments, or a longer shortest_m"
            )
        return winch
