"""Further types of thruster of a vehicle: each has bench files, tables and a page of its own."""

from collections.abc import Iterable
from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.plan import NAME_EXPECTED, VEHICLE_FILE, VehicleFolder, is_vehicle_name
from pipeline.vehicle.load import load_vehicle


def with_types(vehicles: Iterable[VehicleFolder], out: Path) -> tuple[VehicleFolder, ...]:
    """Return the vehicles, behind each one its types of thruster that `tables.types` names.

    A vehicle file that cannot be read names none here; whoever runs the vehicle says why.

    Raises
    ------
    InputError
        When the results of a type would lie where those of another vehicle do.
    """
    found: list[VehicleFolder] = []
    for one in vehicles:
        found += (one, *(_typed(one, name, out) for name in types_of(out / one.vehicle_file)))
    return tuple(found)


def types_of(vehicle_file: Path) -> tuple[str, ...]:
    """Return the further types that a vehicle file names; none of one that cannot be read."""
    try:
        return tuple(load_vehicle(vehicle_file).tables.types)
    except InputError:
        return ()


def _typed(vehicle: VehicleFolder, thruster_type: str, out: Path) -> VehicleFolder:
    typed = vehicle.of_type(thruster_type)
    namesake = (out / vehicle.folder).parent / typed.name / VEHICLE_FILE
    if namesake.exists():
        what = f"results of thruster type {thruster_type} would be those of {namesake.parent}."
    elif not is_vehicle_name(typed.name):
        what = f"results of thruster type {thruster_type} cannot be kept as {typed.name}."
    else:
        return typed
    place = Place(str(out / vehicle.vehicle_file))
    raise InputError.at(place, what, expected=NAME_EXPECTED, remedy="Name the type otherwise.")
