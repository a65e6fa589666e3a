"""Where a vehicle that was asked for lies: under the raw folder, at a path, or in the package."""

import difflib
from pathlib import Path

from pipeline.bundled.vehicles import bundled_vehicle, bundled_vehicles
from pipeline.errors import InputError
from pipeline.plan import VEHICLE_FILE, UsageError, choose


def find_vehicle(text: str, raw: Path, out: Path) -> tuple[str, Path]:
    """Return name and vehicle file: under the raw folder, a path, or a bundled vehicle.

    Raises
    ------
    UsageError
        When there is none.
    InputError
        When the folder's name cannot be that of a vehicle.
    """
    try:
        chosen, refused = choose((text,), raw, out)
    except UsageError as error:
        if text in bundled_vehicles():
            return text, bundled_vehicle(text) / VEHICLE_FILE
        near = difflib.get_close_matches(text, bundled_vehicles(), n=1)
        hint = f' Did you mean "{near[0]}"?' if near else ""
        raise UsageError(f"{error} Bundled: {', '.join(bundled_vehicles())}.{hint}") from None
    if not chosen:
        raise InputError(refused[0])
    return chosen[0].name, out / chosen[0].vehicle_file
