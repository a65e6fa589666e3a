"""A pool run -> the same commands simulated, errors of every channel, manoeuvres, the overlay."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.control.allocation import at_limit
from pipeline.errors import CannotComputeError, InputError, is_of_the_machine
from pipeline.export.mcap_log import write_run_log
from pipeline.export.overlay import write_overlay
from pipeline.identify.manoeuvre_detection import find_manoeuvres
from pipeline.identify.trial_errors import trial_warnings
from pipeline.ingest.log_files import is_log_name
from pipeline.ingest.mcap_file import RecordedFile
from pipeline.inputs.no_solution import with_reason
from pipeline.provenance import file_digest
from pipeline.records.run_table import RunTable
from pipeline.records.trial import LARGEST_OVERLAY_BYTES, ManoeuvreFound, RunTrial, StoredRun
from pipeline.simulate.context import model_of
from pipeline.stages.job import Job, leaves_record
from pipeline.stages.run_table_file import read_tables, write_tables
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

if TYPE_CHECKING:
    from pipeline.identify.trial_windows import TrialFlights
    from pipeline.simulate.pack import PackedVehicle


@leaves_record
def run(job: Job) -> RunTrial:
    """Simulate the run; a vehicle without a model leaves why not, and the manoeuvres."""
    for ending in (".npz", ".mcap"):
        job.beside(ending).unlink(missing_ok=True)
    stored = job.needed_at(f"pool/{job.output.name}", "pool_run", StoredRun)
    table = read_tables(Path(next(iter(stored.files))))["measured"]
    vehicle = job.vehicle()
    found = RunTrial(
        vehicle=job.vehicle_name,
        run=stored.run,
        day=stored.day,
        start_time_ns=stored.start_time_ns,
        duration_s=stored.duration_s,
        manoeuvres=_manoeuvres(table, vehicle),
        commands_at_limit=_at_limit(table, vehicle),
        without_commands_s=_without_commands(table),
    )
    try:
        with with_reason("the comparison with the model"):
            found = _simulated(job, stored, table, found)
    except CannotComputeError as error:
        if is_of_the_machine(error):
            raise
        found = found.model_copy(update={"why_not": str(error), "why_no_gains": str(error)})
    return found.model_copy(update={"warnings": trial_warnings(found)})


def _simulated(job: Job, stored: StoredRun, table: RunTable, found: RunTrial) -> RunTrial:
    model_of(job.vehicle())
    # the compiled kernel takes two seconds to load: only for vehicles that are flown
    from pipeline.identify.trial_errors import compared, predicted_table
    from pipeline.identify.trial_windows import fly_trial
    from pipeline.inputs.gains import gains_of_runs
    from pipeline.inputs.simulated_vehicle import load_simulated, with_known

    one = load_simulated(str(job.vehicle_file.parent), job.raw_root, Path())
    found = found.model_copy(
        update={"gains": gains_of_runs(one, [replace(table, name=stored.run)])}
    )
    sensors = one.vehicle.sensors or Sensors()
    table = with_known(table, stored.notes, one)
    flights = fly_trial(one.packed, sensors, table)
    predicted = predicted_table(one.packed, sensors, table, flights)
    write_tables(job.beside(".npz"), {"windows": predicted})
    notes = [*one.notes, *(() if table.known is None else table.known.notes)]
    try:
        notes += _write_overlay(job, stored, table, one.vehicle, one.packed, flights)
    except InputError as error:
        if is_of_the_machine(error):
            raise
        notes.append(f"no log with measured and simulated channels was written: {error}")
    files = [path for path in map(job.beside, (".npz", ".mcap")) if path.is_file()]
    return found.model_copy(
        update={
            "horizon_s": flights.horizon_s,
            "lead_s": flights.lead_s,
            "windows": flights.windows,
            "windows_left_out": flights.left_out,
            "channels": compared(sensors, table, predicted, flights),
            "notes": tuple(notes),
            "files": {path.as_posix(): file_digest(path) for path in files},
        }
    )


def _write_overlay(  # noqa: PLR0917 - one caller
    job: Job,
    stored: StoredRun,
    table: RunTable,
    vehicle: Vehicle,
    packed: "PackedVehicle",
    flights: "TrialFlights",
) -> list[str]:
    """Write measured and simulated channels into one log; return what is to be said of it."""
    from pipeline.identify.trial_errors import sensor_log

    sensors = vehicle.sensors or Sensors()
    log = next(path for path in job.inputs if is_log_name(path.name))
    windows = sensor_log(packed, sensors, table, flights)
    about: dict[str, Any] = {
        "vehicle_name": job.vehicle_name,
        "density_kgpm3": vehicle.water.density_kgpm3,
        "gravity_mps2": vehicle.water.gravity_mps2,
        "start_time_ns": table.start_time_ns,
        "metadata": {
            "simulated": f"windows of {flights.horizon_s:g} s under /sim",
            "code": job.code,
            "log_sha256": file_digest(log),
        },
    }
    # a recording of another format is not copied into MCAP: what was simulated stands alone
    is_mcap = log.suffix.lower() == ".mcap"
    if stored.size_bytes > LARGEST_OVERLAY_BYTES or not is_mcap:
        simulated = {name: one for name, one in windows.items() if name != "command"}
        command = {"command": windows["command"]}
        write_run_log(job.beside(".mcap"), command, simulated=simulated, **about)
        return [
            (
                f"the log has {stored.size_bytes / 1e9:.1f} GB and was not copied: open it "
                "together with the log of the simulated channels."
            )
        ]
    write_overlay(job.beside(".mcap"), RecordedFile(log, stored.file), windows, **about)
    return []


def _without_commands(table: RunTable) -> float:
    there = table.valid.get("command")
    if there is None or table.time_s.size < 2:
        return 0.0
    return float(np.sum(~there)) * float(table.time_s[1] - table.time_s[0])


def _at_limit(table: RunTable, vehicle: Vehicle) -> dict[str, float]:
    """Share of the commanded time that each thruster is at an end of its range."""
    command = table.values.get("command")
    if command is None:
        return {}
    there = table.valid["command"] & np.isfinite(command).all(axis=1)
    found = {}
    for column, thruster in enumerate(vehicle.thrusters[: command.shape[1]]):
        drive = vehicle.drives[thruster.drive]
        own = command[there, column]
        if own.size:
            share = float(np.mean(at_limit(own, drive.code_min, drive.code_max)))
            if share > 0:
                found[thruster.name] = share
    return found


def _manoeuvres(table: RunTable, vehicle: Vehicle) -> tuple[ManoeuvreFound, ...]:
    by_name = {one.name: vehicle.drives[one.drive] for one in vehicle.thrusters}
    if not table.thrusters or any(name not in by_name for name in table.thrusters):
        return find_manoeuvres(table)
    drives = [by_name[name] for name in table.thrusters]
    return find_manoeuvres(
        table, np.array([max(drive.code_max, -drive.code_min) for drive in drives], float)
    )
