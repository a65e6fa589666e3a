"""The vehicle that is to be simulated: found by name, read, and packed for the kernel."""

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from pipeline.errors import CannotComputeError
from pipeline.plan import TITLES, VEHICLE_FILE, processed_file
from pipeline.provenance import file_digest, read_envelope
from pipeline.records.base import Record
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
    ThrustFamily,
)
from pipeline.simulate.bench_model import BenchModel
from pipeline.simulate.context import model_of
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.stages.vehicle_place import find_vehicle
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.notes import opposed_thrusters, vehicle_notes
from pipeline.vehicle.schema import Vehicle

R = TypeVar("R", bound=Record)


@dataclass(frozen=True)
class SimulatedVehicle:
    """A vehicle ready to fly; `notes` is what the user should know of it."""

    name: str
    file: Path
    vehicle: Vehicle
    packed: PackedVehicle
    notes: tuple[str, ...]

    @property
    def file_digest(self) -> str:
        """SHA-256 of its vehicle file."""
        return file_digest(self.file)


def load_simulated(text: str, raw: Path, out: Path) -> SimulatedVehicle:
    """Find a vehicle, read it with what the bench gave, and pack it.

    Parameters
    ----------
    text : str
        A name under the raw folder, a path to a folder with ``vehicle.yaml``, or a bundled name.
    raw, out : Path
        The raw folder, and the folder that holds ``processed/``.

    Raises
    ------
    UsageError
        When there is no such vehicle.
    InputError, CannotComputeError
        When it cannot be read, has no model, its bench results are missing, or one of its
        thrusters pushes against what the allocator takes it for.
    """
    name, file = find_vehicle(text, raw, out)
    vehicle = load_vehicle(file)
    opposed = opposed_thrusters(vehicle)
    if opposed:
        raise CannotComputeError(
            f"{file}: thruster {', '.join(opposed)} pushes the other way than its role in "
            "allocator: says, so every loop that is closed over it would run away.\n"
            "Turn its direction round, or give it its right role."
        )
    bench, notes = _bench(vehicle, name, file, out)
    packed = pack_vehicle(vehicle, bench)
    notes += vehicle_notes(vehicle)
    return SimulatedVehicle(name, file, vehicle, packed, notes)


def load_packed(file: Path, name: str, out: Path) -> PackedVehicle:
    """Pack another file of a vehicle, one with identified values, with the vehicle's bench results.

    Raises
    ------
    InputError, CannotComputeError
        When it cannot be read, has no model, or bench results are missing.
    """
    vehicle = load_vehicle(file)
    return pack_vehicle(vehicle, _bench(vehicle, name, file, out)[0])


def load_inverse(name: str, out: Path) -> InverseCharacteristic:
    """Read a vehicle's inverse characteristic, which its allocator uses.

    Raises
    ------
    CannotComputeError
        When the bench gave none.
    """
    record, _ = _result(name, out, "inverse", InverseCharacteristic)
    return record


def _bench(
    vehicle: Vehicle, name: str, file: Path, out: Path
) -> tuple[BenchModel | None, tuple[str, ...]]:
    """Return what the bench says of the thrusters, where the model asks for it."""
    model = model_of(vehicle)
    used = [model.thrusters[drive] for drive in {one.drive for one in vehicle.thrusters}]
    in_time = any(drive.balance_in_time for drive in used)
    kinds = {drive.characteristic.kind for drive in used}
    if not in_time and kinds <= {"bollard"}:
        return None, ()
    static, family = None, None
    inputs: dict[str, str] = {}
    if in_time or "tables" in kinds:
        static, inputs = _result(name, out, "static", StaticCharacteristic)
    if "mooring" in kinds:
        inverse, inputs = _result(name, out, "inverse", InverseCharacteristic)
        family = measured(inverse)
    known = inputs.get(f"raw/{name}/{VEHICLE_FILE}")
    notes: tuple[str, ...] = ()
    if known != file_digest(file):
        changed = (
            f"{VEHICLE_FILE} was changed after the bench results were computed; if that touched "
            f"more than model: and sensors:, run `rig2sea run {name}` again."
        )
        notes = (changed,)
    if not in_time:
        return BenchModel(static, family=family), notes
    from pipeline.identify.static import thruster_model

    propeller, _ = _result(name, out, "propeller", PropellerFit)
    drive, _ = _result(name, out, "drive", DriveFit)
    fitted = thruster_model(propeller, drive, vehicle)
    return BenchModel(static, fitted.propeller, fitted.surface, family), notes


def measured(inverse: InverseCharacteristic) -> ThrustFamily:
    """Return the family in which a mooring test has a part.

    Raises
    ------
    CannotComputeError
        When nothing was measured at rest.
    """
    family = inverse.family
    if family is None or "measured" not in {family.positive.basis, family.negative.basis}:
        raise CannotComputeError(
            '"kind: mooring" takes the thrust from the mooring test, and there is none that could '
            "be used. " + " ".join(inverse.explanations)
        )
    return family


def _result(name: str, out: Path, stage: str, kind: type[R]) -> tuple[R, dict[str, str]]:
    """Read a stage's record and the digests of what it was made from."""
    path = out / processed_file(name, stage)
    remedy = f"Run `rig2sea run {name}` first."
    if not path.is_file():
        raise CannotComputeError(
            f"{name} takes its thrust from its bench data, and there is no {TITLES[stage]}: "
            f"{path} does not exist.\n{remedy}"
        )
    envelope = read_envelope(path, stage, kind)
    if envelope.record is None:
        raise CannotComputeError(
            f"{name} takes its thrust from its bench data, and they gave no {TITLES[stage]}: "
            f"{envelope.why_not}"
        )
    return envelope.record, dict(envelope.inputs)
