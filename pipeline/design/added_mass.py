"""Added mass of a vehicle from the shapes of its parts: input and sum.

Each part has its added mass by a formula (`pipeline.physics.added_mass_shapes`, `strip_theory`)
about its own point, and is moved to the vehicle's origin. Parts do not feel
each other, as in the papers.
"""

from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pipeline.errors import CannotComputeError
from pipeline.physics.added_mass_sections import rectangle_section
from pipeline.physics.added_mass_shapes import (
    disc_added_mass,
    ellipsoid_added_mass,
    moved_added_mass,
    potapov_galyaev,
)
from pipeline.physics.strip_theory import (
    equivalent_spheroid,
    slender_hull_added_mass,
)
from pipeline.types import FloatArray
from pipeline.vehicle.attachment_schema import ModelSection as Section
from pipeline.vehicle.schema import Name, Vector3

Length = Annotated[float, Field(gt=0, le=1000)]
#: An entry of the matrix below this share of the root of its two diagonal ones is none.
_NONE = 1e-3


class PartInput(Section):
    """Where a part is; its axes are the vehicle's (x forward, y starboard, z down) turned by."""

    name: Name
    position_m: Vector3 = (0.0, 0.0, 0.0)
    rotation_deg: Vector3 = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw."""


class Ellipsoid(PartInput):
    """Lamb's ellipsoid: semi-axes along x, y, z."""

    kind: Literal["ellipsoid"]
    semi_axes_m: tuple[Length, Length, Length]


class Disc(PartInput):
    """A thin disc across its z axis."""

    kind: Literal["disc"]
    radius_m: Length


class HullPart(PartInput):
    """A hull of circular sections along x: strips with the end factors of Lamb's spheroid."""

    kind: Literal["hull"]
    station_m: tuple[float, ...] = Field(min_length=2, max_length=200)
    radius_m: tuple[Annotated[float, Field(ge=0, le=100)], ...]

    @model_validator(mode="after")
    def _one_radius_a_station(self) -> Self:
        if len(self.station_m) != len(self.radius_m):
            raise ValueError("station_m and radius_m must be of one length")
        if len(set(self.station_m)) != len(self.station_m):
            raise ValueError("two of the stations coincide")
        return self


class BarPart(PartInput):
    """A bar of rectangular section along x: strips without end effects."""

    kind: Literal["bar"]
    length_m: Length
    width_m: Length
    height_m: Length


class CylinderInFrame(PartInput):
    """A flat cylinder in a square frame across its z axis (Potapov and Galyaev)."""

    kind: Literal["cylinder_in_frame"]
    radius_m: Length
    height_m: Length
    outer_side_m: Length
    inner_side_m: Length


Part = Annotated[
    Ellipsoid | Disc | HullPart | BarPart | CylinderInFrame, Field(discriminator="kind")
]


class AddedMassInput(Section):
    """The input file."""

    name: Name
    title: str
    source: str = ""
    density_kgpm3: Annotated[float, Field(gt=500, lt=1500)]
    parts: tuple[Part, ...] = Field(min_length=1, max_length=100)


def part_added_mass(part: Part, density_kgpm3: float) -> FloatArray:
    """Return the added mass (6, 6) of a part about its own point, in its own axes."""
    return _FORMULAS[part.kind](part, density_kgpm3)


def _ellipsoid(part: Ellipsoid, rho: float) -> FloatArray:
    return ellipsoid_added_mass(part.semi_axes_m, rho)


def _disc(part: Disc, rho: float) -> FloatArray:
    mass, inertia = disc_added_mass(part.radius_m, rho)
    return np.diag([0.0, 0.0, mass, inertia, inertia, 0.0])


def _hull(part: HullPart, rho: float) -> FloatArray:
    x, radius = np.array(part.station_m), np.array(part.radius_m)
    order = np.argsort(x)
    x, r = x[order], radius[order]
    # volume of the cones between stations
    volume = float(np.sum(np.diff(x) * np.pi * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2) / 3.0))
    like = equivalent_spheroid(float(np.ptp(x)), volume, rho)
    ends = np.sqrt([0, like.sway_factor, like.sway_factor, 0, like.yaw_factor, like.yaw_factor])
    found = slender_hull_added_mass(x, r, rho) * np.outer(ends, ends)
    found[0, 0] = like.surge_kg
    return np.asarray(found)


def _bar(part: BarPart, rho: float) -> FloatArray:
    section = rectangle_section(part.width_m, part.height_m, rho)
    # strips without end effects, all alike
    length, lever = part.length_m, part.length_m**2 / 12.0
    sway, heave = length * section.sway_kgpm, length * section.heave_kgpm
    return np.diag([0.0, sway, heave, length * section.roll_kgm, heave * lever, sway * lever])


def _cylinder_in_frame(part: CylinderInFrame, rho: float) -> FloatArray:
    if part.inner_side_m >= part.outer_side_m:
        raise CannotComputeError(f"part {part.name}: inner_side_m must be below outer_side_m.")
    found = potapov_galyaev(
        radius_m=part.radius_m,
        height_m=part.height_m,
        outer_side_m=part.outer_side_m,
        inner_side_m=part.inner_side_m,
        density_kgpm3=rho,
    )
    surge, tilt = found.surge_kg, found.tilt_kgm2
    return np.diag([surge, surge, found.heave_figure_kg, tilt, tilt, 0.0])


_FORMULAS: dict[str, Callable[[Any, float], FloatArray]] = {
    "ellipsoid": _ellipsoid,
    "disc": _disc,
    "hull": _hull,
    "bar": _bar,
    "cylinder_in_frame": _cylinder_in_frame,
}


def vehicle_added_mass(one: AddedMassInput) -> FloatArray:
    """Return the added mass (6, 6) of all parts about the vehicle's origin. [kg, kg m, kg m^2]."""
    from scipy.spatial.transform import Rotation

    whole = np.zeros((6, 6))
    for part in one.parts:
        turn = Rotation.from_euler("ZYX", part.rotation_deg[::-1], degrees=True).as_matrix()
        own = part_added_mass(part, one.density_kgpm3)
        whole += moved_added_mass(own, np.array(part.position_m), turn)
    size = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    return np.where(np.abs(whole) > _NONE * size, (whole + whole.T) / 2.0, 0.0)


def as_vehicle_section(matrix: FloatArray, source: str) -> str:
    """Return the section ``added_mass:`` of a vehicle file: its diagonal, or the whole matrix."""
    quoted = source.replace("\\", "\\\\").replace('"', '\\"')
    lines = ["added_mass:"]
    if np.count_nonzero(matrix - np.diag(np.diag(matrix))) == 0:
        lines.append(f"  diagonal: {_row(np.diag(matrix))}")
    else:
        lines += ["  matrix:", *(f"    - {_row(row)}" for row in matrix)]
    return "\n".join([*lines, f'  source: "{quoted}"', ""])


def _row(values: FloatArray) -> str:
    return "[" + ", ".join(f"{value + 0.0:.5f}" for value in values.tolist()) + "]"
