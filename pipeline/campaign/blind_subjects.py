"""The vehicles of the blind check, with what their bench gave."""

from pathlib import Path

from pipeline.blind.subject import BlindSubject, subject_from
from pipeline.errors import CannotComputeError
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import processed_file
from pipeline.provenance import read_envelope
from pipeline.records.fits import StaticCharacteristic
from pipeline.vehicle.load import load_vehicle

#: Vehicles of a campaign that names none.
USUAL = ("mmt300", "rov8", "cargo_carrier")


def load_subject(text: str, raw: Path, out: Path) -> BlindSubject:
    """Find a vehicle by name or path and read it, with the bench's family where it needs one.

    Raises
    ------
    UsageError
        When there is no such vehicle.
    InputError, CannotComputeError
        When it cannot be read, or its bench results are missing.
    """
    name, file = find_vehicle(text, raw, out)
    model = load_vehicle(file).model
    static: StaticCharacteristic | None = None
    if model is not None and any(
        one.characteristic.kind == "tables" for one in model.thrusters.values()
    ):
        path = out / processed_file(name, "static")
        if not path.is_file():
            raise CannotComputeError(
                f"{name} takes its thrust from its bench data, and {path} does not exist.\n"
                f"Run `rig2sea run {name}` first."
            )
        envelope = read_envelope(path, "static", StaticCharacteristic)
        if envelope.record is None:
            raise CannotComputeError(
                f"{name} takes its thrust from its bench data, and they gave none: "
                f"{envelope.why_not}"
            )
        static = envelope.record
    return subject_from(file, static)
