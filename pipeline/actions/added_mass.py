"""``rig2sea design added-mass``: read the parts, sum, and write the section of a vehicle file."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline import __version__
from pipeline.design.added_mass import (
    AddedMassInput,
    as_vehicle_section,
    part_added_mass,
    vehicle_added_mass,
)
from pipeline.plan import UsageError
from pipeline.provenance import write_atomically
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_checked

_AXES = "surge, sway, heave, roll, pitch, yaw"


@dataclass(frozen=True)
class AddedMassFound:
    """The input, the matrix about the vehicle's origin, and the section that states it."""

    given: AddedMassInput
    matrix: FloatArray
    section: str

    @property
    def text(self) -> str:
        """What is printed: each part's diagonal, then the section."""
        lines = [f"{self.given.title}; kg and kg m^2 on {_AXES}:"]
        for part in self.given.parts:
            own = part_added_mass(part, self.given.density_kgpm3).diagonal()
            lines.append(f"  {part.name}: {', '.join(f'{value:.3f}' for value in own)}")
        return "\n".join(lines)

    def body(self) -> dict[str, Any]:
        """One JSON object."""
        return {
            "schema": "rig2sea/design-added-mass/1",
            "rig2sea_version": __version__,
            "name": self.given.name,
            "matrix": self.matrix.tolist(),
            "parts": {
                part.name: part_added_mass(part, self.given.density_kgpm3).tolist()
                for part in self.given.parts
            },
            "section": self.section,
        }


def design_added_mass(file: Path) -> AddedMassFound:
    """Read the parts and sum their added masses.

    Raises
    ------
    UsageError, InputError, CannotComputeError
        For a file that is not there or cannot be used, or a shape that no formula holds for.
    """
    remedy = "`rig2sea design added-mass --example` prints one to start from."
    if not file.exists():
        raise UsageError(f"{file} does not exist.\n{remedy}")
    given = load_checked(
        file, AddedMassInput, expected="a YAML file with the parts of the vehicle.", remedy=remedy
    )
    matrix = vehicle_added_mass(given)
    kinds = ", ".join(f"{part.name} ({part.kind})" for part in given.parts)
    source = f"rig2sea design added-mass {file.name}: {kinds}"
    if given.source:
        source += f"; {given.source}"
    return AddedMassFound(given, matrix, as_vehicle_section(matrix, source))


def write_added_mass(found: AddedMassFound, to: Path) -> tuple[Path, Path]:
    """Write the section and the JSON file."""
    stem = to / f"{found.given.name}-added-mass"
    section, data = stem.with_suffix(".yaml"), stem.with_suffix(".json")
    write_atomically(section, found.section)
    write_atomically(data, json.dumps(found.body(), indent=1) + "\n")
    return section, data
