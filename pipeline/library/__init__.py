"""What a notebook wants of rig2sea: files and results as pandas frames, units in the column names.

Everything here is also a command of `rig2sea`; the frames hold what its files hold. The record that
a frame was made from is in ``frame.attrs["record"]``, warnings in ``frame.attrs["warnings"]``.
Errors are those of the commands: `pipeline.errors.InputError` for a file that cannot be used,
`pipeline.errors.CannotComputeError` for data that tell nothing.

    >>> import pipeline
    >>> vehicle = pipeline.load_vehicle("rov8")
    >>> len(vehicle.thrusters)
    8
"""

from pipeline.library.bench import load_vehicle, read_bench, thruster_tables
from pipeline.library.runs import diagnose_runs, identify_runs, read_run, simulate_manoeuvre

__all__ = [
    "diagnose_runs",
    "identify_runs",
    "load_vehicle",
    "read_bench",
    "read_run",
    "simulate_manoeuvre",
    "thruster_tables",
]
