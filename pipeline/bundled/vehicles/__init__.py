"""Vehicles that come with the package, without rig files: their folders with ``vehicle.yaml``."""

from pathlib import Path

from pipeline.errors import InputError, Place

_HERE = Path(__file__).parent
#: Name that people know -> the bundled vehicle of that kind.
_KNOWN_AS = {"bluerov2_heavy": "rov8"}


def bundled_vehicles() -> tuple[str, ...]:
    """Names of the bundled vehicles, in alphabetical order.

    >>> bundled_vehicles()
    ('bluerov2', 'bluerov2_heavy', 'cargo_carrier', 'remus100', 'rov8')
    """
    return tuple(sorted([*_KNOWN_AS, *(file.parent.name for file in _HERE.glob("*/vehicle.yaml"))]))


def bundled_vehicle(name: str) -> Path:
    """Return the folder of a bundled vehicle, as `pipeline.vehicle.load.load_vehicle` takes it.

    >>> bundled_vehicle("rov8").name
    'rov8'
    """
    if name not in bundled_vehicles():
        raise InputError.at(
            Place(name),
            "no bundled vehicle has this name.",
            expected=f"one of {', '.join(bundled_vehicles())}, or a folder with vehicle.yaml.",
        )
    return _HERE / _KNOWN_AS.get(name, name)
