"""What a logged supply voltage says of the supply, whatever the vehicle does.

The drives have V / V_nominal = 1 - drop - load_drop mean((N_i / N_max)^2), so that the two
parameters of the supply are read off the voltage by a straight line. Of a battery that runs down
during a run the drop is the mean of what it lacks, which grows along the run as the voltage tells.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Readings of a supply that wanders go together: so long ones count as one. [s]
_BLOCK_S = 4.0
#: What a healthy supply does, and what a meter is off by in a run. [1]
_LEAST_NOISE, _BIAS = 0.002, 0.005
#: A mean drop of less tells no course of it, and a course that grows by more is none. [1]
_LEAST_DROP, _MOST_GROWN = 0.01, 2.0
_PARAMETERS = ("voltage_sag:drop", "voltage_sag:load_drop")


def supply_told(
    packed: PackedVehicle,
    run: RunTable,
    sensors: Sensors | None,
    directions: Sequence[Coordinate],
) -> tuple[FloatArray, FloatArray]:
    """Information (d, d) and score (d,) of the logged voltage; zeros where there is none."""
    count = len(directions)
    information, score = np.zeros((count, count)), np.zeros(count)
    read = _missing(run, sensors)
    place = {one.name: k for k, one in enumerate(directions)}
    own = [place[name] for name in _PARAMETERS if name in place]
    if len(own) < len(_PARAMETERS) or read is None or sensors is None or sensors.voltage is None:
        return information, score
    marks, missing = read
    codes = np.nan_to_num(np.array(run.values["command"], float))[marks]
    load = np.mean((codes / packed.code_limits[:, 1]) ** 2, axis=1)
    block = ((run.time_s[marks] - run.time_s[0]) / _BLOCK_S).astype(int)
    _, block = np.unique(block, return_inverse=True)
    readings = np.bincount(block)
    x = np.column_stack([np.ones(readings.size), np.bincount(block, load) / readings])
    x *= [directions[k].unit_size for k in own]
    y = np.bincount(block, missing) / readings
    noise, bias = max(sensors.voltage.noise_v / sensors.voltage.nominal_v, _LEAST_NOISE), _BIAS
    # the mean is known but for what it is off by in a run; what varies beside the load is no
    # noise, but slow, and counts as one reading
    apart, varies = x - x.mean(axis=0), y - y.mean()
    left = varies - apart @ np.linalg.lstsq(apart, varies, rcond=None)[0]
    weight = 1.0 / (noise**2 + readings.size * float(np.mean(left**2)))
    mean, sure = x.mean(axis=0), 1.0 / (bias**2 + noise**2 / readings.size)
    information[np.ix_(own, own)] = sure * np.outer(mean, mean) + weight * apart.T @ apart
    score[own] = sure * mean * y.mean() + weight * apart.T @ varies
    return information, score


def course_of_drop(run: RunTable, sensors: Sensors | None) -> FloatArray:
    """Drop (rows,) over its mean, along a run: the straight line that a logged voltage follows."""
    read = _missing(run, sensors)
    if read is None or abs(mean := float(read[1].mean())) < _LEAST_DROP:
        return np.ones(run.time_s.size)
    marks, missing = read
    time_s = run.time_s - run.time_s[marks].mean()
    slope = float(time_s[marks] @ missing) / max(float(time_s[marks] @ time_s[marks]), 1e-9)
    return np.asarray(np.clip(1.0 + slope / mean * time_s, 0.0, _MOST_GROWN))


def _missing(run: RunTable, sensors: Sensors | None) -> tuple[BoolArray, FloatArray] | None:
    """Rows at which the voltage was read, and the share of the nominal one that it lacks there."""
    if sensors is None or sensors.voltage is None or "voltage" not in run.values:
        return None
    marks = run.reading.get("voltage", np.zeros(run.time_s.size, bool)) & run.trusted("voltage")
    if not marks.any():
        return None
    return marks, 1.0 - run.values["voltage"][marks, 0] / sensors.voltage.nominal_v
