"""Whether accelerometer and attitude, or a level hull, agree on where down is: wrong axes show."""

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.pool_run_resample import resample
from pipeline.records.run_arrays import PoolRun
from pipeline.types import FloatArray

_TABLE_HZ = 20.0
_LEAST_ROWS = 100
#: A vehicle that accelerates by a third of gravity feels it 18 degrees off.
_MOST_APART_DEG = 30.0
#: About half of gravity: less does not say where down is.
_LEAST_MPS2 = 5.0
#: No vehicle spends half of a run tilted further, unless it is upside down.
_MOST_TILTED_DEG = 60.0


def gravity_against_attitude(run: PoolRun, place: Place) -> list[Problem]:
    """Compare the direction of the specific force with down as the attitude has it.

    At rest an accelerometer feels gravity upwards, f = -g R^T e_z. Under way its median direction
    is still that, as no vehicle accelerates one way for half of the time.
    """
    if not {"attitude", "specific_force"} <= set(run.channels):
        return []
    table = resample(run, _TABLE_HZ, quantities=("attitude", "specific_force"))
    rows = table.valid["attitude"] & table.valid["specific_force"]
    force = table.values["specific_force"][rows]
    apart_deg = _apart_deg(force, down_in_body(table.values["attitude"][rows]))
    if apart_deg < _MOST_APART_DEG:
        return []
    attitude, specific = run.channels["attitude"].topic, run.channels["specific_force"].topic
    return [
        Problem(
            "warning",
            place,
            f"down by the specific force ({specific}) and down by the attitude ({attitude}) are "
            f"{apart_deg:.0f} degrees apart.",
            "",
            "Check axes, sign and, of a quaternion, order of both under pool: channels in "
            "vehicle.yaml.",
        )
    ]


def gravity_against_level(run: PoolRun, place: Place) -> list[Problem]:
    """Compare the direction of the specific force with down of a level vehicle.

    For logs without an attitude, where nothing else shows that the axes are others than assumed.
    """
    channel = run.channels.get("specific_force")
    if channel is None or "attitude" in run.channels:
        return []
    force = channel.values[channel.usable()]
    force = force[np.isfinite(force).all(axis=1)]
    if not force.size or np.median(np.linalg.norm(force, axis=1)) < _LEAST_MPS2:
        return []  # gravity was taken out, which is told of the sizes
    apart_deg = _apart_deg(force, np.tile([0.0, 0.0, 1.0], (len(force), 1)))
    if apart_deg < _MOST_TILTED_DEG:
        return []
    what = (
        f"down by the specific force ({channel.topic}) is {apart_deg:.0f} degrees from the z axis "
        f"of the body, with the axes {channel.read.axes}: the vehicle lay on its side or back, or "
        "the axes are others."
    )
    remedy = "State body_axes of the IMU (such as flu) under pool: channels in vehicle.yaml."
    return [Problem("warning", place, what, "", remedy)]


def _apart_deg(force: FloatArray, down: FloatArray) -> float:
    """Median angle between what accelerometers feel and up (n, 3); 0 where there is little."""
    size = np.linalg.norm(force, axis=1)
    felt = size > 0.0
    if felt.sum() < _LEAST_ROWS:
        return 0.0
    cosine = -(force[felt] / size[felt, None] * down[felt]).sum(axis=1)
    return float(np.degrees(np.median(np.arccos(np.clip(cosine, -1.0, 1.0)))))


def down_in_body(attitude: FloatArray) -> FloatArray:
    """R^T e_z (n, 3) of quaternions w, x, y, z (n, 4), body to NED, of any length but zero."""
    w, x, y, z = attitude.T
    down = np.stack([x * z - w * y, y * z + w * x, 0.5 * (w * w - x * x - y * y + z * z)], axis=1)
    return np.asarray(2.0 * down / (attitude**2).sum(axis=1, keepdims=True))
