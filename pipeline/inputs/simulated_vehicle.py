"""The vehicle that is to be simulated: found by name, read, and packed for the kernel."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from pipeline.errors import CannotComputeError
from pipeline.inputs.bench_models import bench_model
from pipeline.inputs.vehicle_place import find_vehicle, result_of
from pipeline.plan import TITLES, VEHICLE_FILE, typed_name
from pipeline.provenance import file_digest
from pipeline.records.base import Record
from pipeline.records.fits import InverseCharacteristic
from pipeline.records.pool_run import RunNotes
from pipeline.records.run_table import KnownOfRun, RunTable
from pipeline.simulate.context import BenchModel, model_of
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run_conditions import run_setup
from pipeline.simulate.tether_along import tether_force
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.notes import opposed_thrusters, vehicle_notes
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

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

    `text` is a name under the raw folder, a path to a folder with ``vehicle.yaml``, or a bundled
    name; `out` holds ``processed/``.

    Raises `UsageError` when there is no such vehicle; `InputError, CannotComputeError` when it
    cannot be read, has no model, its bench results are missing, or one of its thrusters pushes
    against what the allocator takes it for.
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
    """Pack another file of a vehicle (with identified values) with the vehicle's bench results."""
    vehicle = load_vehicle(file)
    return pack_vehicle(vehicle, _bench(vehicle, name, file, out)[0])


def _bench(
    vehicle: Vehicle, name: str, file: Path, out: Path
) -> tuple[BenchModel | None, tuple[str, ...]]:
    """Return what the bench says of the thrusters, where the model asks for it."""
    known: set[str | None] = set()

    def read(thruster_type: str, stage: str, kind: type[R]) -> R:
        record, inputs = bench_result(typed_name(name, thruster_type), out, stage, kind)
        known.add(inputs.get(f"raw/{name}/{VEHICLE_FILE}"))
        return record

    bench = bench_model(vehicle, read)
    if known <= {file_digest(file)}:
        return bench, ()
    changed = (
        f"{VEHICLE_FILE} was changed after the bench results were computed; if that touched "
        f"more than model: and sensors:, run `rig2sea run {name}` again."
    )
    return bench, (changed,)


def load_inverse(name: str, out: Path) -> InverseCharacteristic:
    """Read an inverse characteristic, which the allocator uses; `name` as `typed_name` has it."""
    record, _ = bench_result(name, out, "inverse", InverseCharacteristic)
    return record


def load_inverses(vehicle: Vehicle, name: str, out: Path) -> dict[str, InverseCharacteristic]:
    """Read the inverse characteristics of a vehicle's types of thruster, "" that of `tables`."""
    return {one: load_inverse(typed_name(name, one), out) for one in vehicle.used_types}


def bench_result(name: str, out: Path, stage: str, kind: type[R]) -> tuple[R, dict[str, str]]:
    """Read a stage's record and the digests of what it was made from."""
    record, inputs, why_not = result_of(name, out, stage, kind)
    if record is None:
        raise CannotComputeError(
            f"{name} takes its thrust from its bench data, and there is no {TITLES[stage]}: "
            f"{why_not}\nRun `rig2sea run {name}` first, where its bench data are there."
        )
    return record, inputs


def with_known(table: RunTable, notes: RunNotes | None, one: SimulatedVehicle) -> RunTable:
    """Lay what the notes and the vehicle file say of a run beside its table.

    Ballast, payloads, water and events as they are in the notes; the tether of the day, or of the
    nominal model, as the force with which it acted along the measured motion. `known.notes` say
    what could not be taken.

    Raises `CannotComputeError` for notes that do not fit the vehicle.
    """
    setup = run_setup(one.vehicle, model_of(one.vehicle), notes)
    setup.checked(one.packed.vector)
    told, force = list(setup.notes), None
    try:
        force = tether_force(one.packed, one.vehicle.sensors or Sensors(), table, setup)
    except CannotComputeError as error:
        told.append(f"{table.name}: the tether is left out of what is computed: {error}")
    times = setup.times_s
    conditions = tuple(setup.conditions(time_s) for time_s in times)
    if force is None and not told and all(known.as_stated for known in conditions):
        return table
    return replace(table, known=KnownOfRun(times, conditions, force, tuple(told)))
