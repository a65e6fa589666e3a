"""Where a vehicle that was asked for lies, and what the bench left of it."""

import difflib
from pathlib import Path
from typing import TypeVar

from pipeline.bundled.vehicles import bundled_vehicle, bundled_vehicles
from pipeline.errors import InputError
from pipeline.plan import VEHICLE_FILE, UsageError, choose, is_vehicle_name, processed_file
from pipeline.provenance import read_envelope
from pipeline.records.base import Record
from pipeline.vehicle.load import load_vehicle


def find_vehicle(text: str, raw: Path, out: Path) -> tuple[str, Path]:
    """Return name and vehicle file: under the raw folder, a path, or a bundled vehicle.

    A vehicle is called what its folder is called. Where a path leads to one of another kind of name
    ("001"), it is called what its file says: no result is filed under the folder's name here.
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
        file = _vehicle_file_at(Path(text))
        if file is not None:
            return load_vehicle(file).name, file
        raise InputError(refused[0])
    return chosen[0].name, out / chosen[0].vehicle_file


def _vehicle_file_at(path: Path) -> Path | None:
    """Vehicle file at a path whose folder is not named as vehicles are; None where that is not."""
    file = path if path.name == VEHICLE_FILE else path / VEHICLE_FILE
    misnamed = not is_vehicle_name(file.absolute().parent.name)
    return file if misnamed and file.is_file() else None


R = TypeVar("R", bound=Record)


def result_of(
    name: str, out: Path, stage: str, kind: type[R]
) -> tuple[R | None, dict[str, str], str]:
    """Return the record of a stage, the digests of what it was made from, and why there is none.

    `name` is the vehicle, or a type of thruster as `typed_name` has it; `out` the folder that holds
    ``processed/``.
    """
    path = out / processed_file(name, stage)
    if not path.is_file():
        return None, {}, f"{path} does not exist."
    envelope = read_envelope(path, stage, kind)
    return envelope.record, dict(envelope.inputs), envelope.why_not or ""
