"""Compile what simulates, by using it on seconds of a run.

`make` has it done beside the first steps of a run (``python -m evaluation.compile_kernels``). Who
needs a function that is being compiled waits for it, and finds the rest there.
"""

from pathlib import Path

import numpy as np

from evaluation.bundled.mmt300_runs import true_vehicle
from pipeline.diagnose.case import Case
from pipeline.diagnose.regression.known import by_file
from pipeline.identify.trial_windows import fly_trial
from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.simulate.applied_wrench import hull_wrench, thruster_wrench
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.sensor_schema import Sensors

RAW = Path(__file__).resolve().parents[1] / "raw"
LOG = RAW / "mmt300" / "pool" / "2024-05-15-straight.mcap"
#: As the workflow takes a log; so many rows.
RATE_HZ, ROWS = 50.0, 1000

vehicle = load_vehicle(RAW / "mmt300")
packed = true_vehicle(vehicle)
run = resample(read_pool_run(LOG, vehicle, RAW), RATE_HZ, by_step=True).rows(0, ROWS)
fly_trial(packed, vehicle.sensors or Sensors(), run, threads=1)
by_file(Case(vehicle.name, vehicle, packed, (run,), effects={}))
thruster_wrench(packed, np.zeros((1, len(packed.thruster_names))), np.zeros((1, 6)))
hull_wrench(packed, np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 6)))
