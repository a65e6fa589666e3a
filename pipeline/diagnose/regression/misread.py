"""What errors of the DVL change in the velocity that a run shows, whatever moves the vehicle.

With the errors r, R_e, s and tau of place, mount, scale and delay a DVL reads (Kinsey and Whitcomb
2007, IEEE J. Oceanic Eng. 32(2), 286-299)

    y(t) = s R_e^T [v + omega x (p + r)](t - tau),

of which the reader of the log takes omega x p off again. A velocity that is late answers to the
force, the rates and the attitude of a time tau ago: to one that reads it, these come late.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.physics.parameters import read
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Dvl


def misread(dvl: Dvl | None, vector: FloatArray) -> FloatArray:
    """Change (3, 6) of the measured velocity by a unit of velocity and rates.

    Parameters
    ----------
    dvl : Dvl or None
        How it is stated to sit.
    vector : ndarray
        Parameter vector, of which the slots ``dvl_*`` count, but for the delay.
    """
    place = np.zeros(3) if dvl is None else np.array(dvl.position_m)
    stated = (0.0, 0.0, 0.0) if dvl is None else dvl.rotation_deg
    mount = Rotation.from_euler("ZYX", np.radians(stated)[::-1])
    error = Rotation.from_euler("ZYX", read(vector, "dvl_rotation")[::-1])
    turned = float(read(vector, "dvl_scale")) * (mount * error.inv() * mount.inv()).as_matrix()
    there = _turning(place + read(vector, "dvl_lever_arm"))
    return np.hstack([turned - np.eye(3), turned @ there - _turning(place)])


def _turning(place: FloatArray) -> FloatArray:
    """Matrix (3, 3) of omega x place."""
    x, y, z = place
    return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
