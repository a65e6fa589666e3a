"""What the measured place says of the DVL's errors, whatever moves the vehicle."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.kinematics.dead_reckoning import ERRORS, mount_of, track_of
from pipeline.diagnose.kinematics.dvl_errors import reckoning
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors


def place_told(
    run: RunTable, sensors: Sensors | None, directions: Sequence[Coordinate]
) -> tuple[FloatArray, FloatArray]:
    """Information (d, d) and score (d,) of dead reckoning; zeros where there is no place.

    A DVL that reads the velocity through the water says nothing of the kind.
    """
    count = len(directions)
    information, score = np.zeros((count, count)), np.zeros(count)
    at = {(one.effect.id, one.parameter.name): k for k, one in enumerate(directions)}
    own = [at[effect, name] for effect, name, _, _ in ERRORS if (effect, name) in at]
    if len(own) < len(ERRORS) or sensors is None or sensors.dvl is None or sensors.dvl.water_track:
        return information, score
    track = track_of(run, sensors)
    wander = 0.0 if sensors.imu is None else sensors.imu.attitude_wander_rad
    unit = np.array([directions[k].unit_size for k in own])
    told = None if track is None else reckoning([track], mount_of(sensors), unit, wander)
    if told is not None:
        information[np.ix_(own, own)], score[own] = told.information, told.score
    return information, score
