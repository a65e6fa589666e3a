"""What is known of a run beside its log, laid beside its table for the fits."""

from dataclasses import replace

from pipeline.errors import CannotComputeError
from pipeline.inputs.simulated_vehicle import SimulatedVehicle
from pipeline.records.run_notes import RunNotes
from pipeline.records.run_table import KnownOfRun, RunTable
from pipeline.simulate.context import model_of
from pipeline.simulate.run_conditions import run_setup
from pipeline.simulate.tether_along import tether_force
from pipeline.vehicle.sensor_schema import Sensors


def with_known(table: RunTable, notes: RunNotes | None, one: SimulatedVehicle) -> RunTable:
    """Lay what the notes and the vehicle file say of a run beside its table.

    Ballast, payloads, water and events as they are in the notes; the tether of the day, or of the
    nominal model, as the force with which it acted along the measured motion. `known.notes` say
    what could not be taken.

    Raises
    ------
    CannotComputeError
        For notes that do not fit the vehicle.
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
