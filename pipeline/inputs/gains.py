"""Sound runs of a vehicle, and the gains of its thrusters in runs that were read."""

from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import InputError
from pipeline.identify.thruster_gains import gains_of
from pipeline.ingest.log_files import day_of, logs_of
from pipeline.inputs.simulated_vehicle import SimulatedVehicle
from pipeline.plan import POOL
from pipeline.records.gains import ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.vehicle.run_notes import notes_file, read_run_notes
from pipeline.vehicle.sensor_schema import Sensors


def gains_of_runs(
    one: SimulatedVehicle,
    tables: Sequence[RunTable],
    sound: Sequence[RunTable] = (),
    sound_name: str = "",
) -> ThrusterGains:
    """Tell what each thruster gave in each run.

    `sound` are runs that their notes call healthy, one of `tables` is judged by the others;
    `sound_name` is how to call them, their names if empty.
    """
    return gains_of(
        one.packed,
        one.vehicle.sensors or Sensors(),
        tables,
        uncertainty=model_of(one.vehicle).uncertainty,
        reference=sound,
        reference_name=sound_name,
        vehicle_file_sha256=one.file_digest,
    )


def sound_runs(one: SimulatedVehicle) -> tuple[dict[Path, str], tuple[str, ...]]:
    """Find the logs of a vehicle's sound runs, each with why it is taken for one.

    Notes count before days: a run with ``healthy: false`` is none on any day. Also returns the
    notes that could not be read, whose runs are therefore left out.
    """
    found: dict[Path, str] = {}
    refused: list[str] = []
    days = set(one.vehicle.accepted_days)
    for log in logs_of(one.file.parent / POOL):
        notes = notes_file(log)
        said = None
        if notes is not None:
            try:
                said = read_run_notes(notes, f"{one.name}/{POOL}/{notes.name}").healthy
            except InputError as error:
                refused.append(f"{log.name} is not taken for sound: {error}")
                continue
        if said:
            found[log.resolve()] = "healthy: true in its notes"
        elif said is None and days and day_of(log) in days:
            found[log.resolve()] = f"{day_of(log)} is an accepted day"
    return found, tuple(refused)
