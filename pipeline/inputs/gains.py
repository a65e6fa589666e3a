"""Gains of thrusters of runs that were read: with the model and the sensors of a vehicle file."""

from collections.abc import Sequence

from pipeline.identify.thruster_gains import gains_of
from pipeline.inputs.simulated_vehicle import SimulatedVehicle
from pipeline.records.gains import ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.vehicle.sensor_schema import Sensors


def gains_of_runs(
    one: SimulatedVehicle,
    tables: Sequence[RunTable],
    sound: Sequence[RunTable] = (),
    sound_name: str = "",
) -> ThrusterGains:
    """Tell what each thruster gave in each run.

    Parameters
    ----------
    one : SimulatedVehicle
        The vehicle.
    tables : sequence of RunTable
        Its runs.
    sound : sequence of RunTable
        Runs that their notes call healthy; one of `tables` is judged by the others.
    sound_name : str
        How to call them; their names if empty.
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
