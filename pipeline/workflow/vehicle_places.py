"""Where each vehicle lay: one whose raw folder was deleted is not listed in the index for ever.

Its results and pages are nobody's to delete but the user's. What goes is the receipt by which the
index knows a vehicle; it comes back with the vehicle. A vehicle may be run from any folder, so
where each was is remembered (`KnownFiles.places`); two of one name in one place of results are
told of.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.plan import (
    NAME_EXPECTED,
    VEHICLE_FILE,
    VehicleFolder,
    is_vehicle_name,
    processed_file,
)
from pipeline.provenance import code_digest, file_digest
from pipeline.vehicle.load import load_vehicle
from pipeline.workflow.engine_jobs import INDEX


def index_digest(vehicles: Sequence[str], others: Sequence[str], out: Path) -> str:
    """Digest of the index and of all that it was made from.

    Of the vehicles of this execution, and of `others` with results from before. It is kept after
    an execution that did everything: where nothing else is to do either, the engine, which takes
    seconds to start, is not asked.
    """
    receipts = [(name, out / processed_file(name, "vehicle_page")) for name in (*vehicles, *others)]
    lines = [code_digest("pipeline.stages.index_page"), file_digest(out / INDEX)]
    lines += [f"{name} {file_digest(path)}" for name, path in receipts]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def with_types(vehicles: Iterable[VehicleFolder], out: Path) -> tuple[VehicleFolder, ...]:
    """Return the vehicles, behind each one its types of thruster that `tables.types` names.

    A vehicle file that cannot be read names none here; whoever runs the vehicle says why.
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


def forget_gone(
    places: dict[str, str], out: Path, here: Sequence[VehicleFolder]
) -> tuple[str, ...]:
    """Remove the receipts of vehicles that are not where they were, and the index that lists them.

    Returns the names of the vehicles that went. `places` are the remembered folders of vehicles;
    those of the vehicles `here`, in this execution, are kept in mind.
    """
    places |= {one.name: one.folder for one in here}
    gone = tuple(
        sorted(n for n, folder in places.items() if not _is_there(out / folder / VEHICLE_FILE))
    )
    for name in gone:
        del places[name]
        (out / processed_file(name, "vehicle_page")).unlink(missing_ok=True)
    if gone:
        (out / INDEX).unlink(missing_ok=True)
    return gone


def taken_over(
    places: Mapping[str, str], out: Path, here: Sequence[VehicleFolder]
) -> tuple[tuple[str, str], ...]:
    """Vehicles whose results are those of a namesake in another raw folder, which is still there.

    Each with the folder whose results are there. To be asked before `forget_gone`, which remembers
    the new places. A folder that was moved or renamed is no namesake.
    """
    return tuple(
        (one.name, places[one.name])
        for one in here
        if one.name in places
        and _is_there(out / places[one.name] / VEHICLE_FILE)
        and (out / one.folder).resolve() != (out / places[one.name]).resolve()
        and (out / "processed" / one.name).exists()
    )


def _is_there(path: Path) -> bool:
    """Tell whether a file exists; one behind a folder that may not be read counts as there."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError:
        return True
    return True
