"""Whether accelerometer and attitude agree on where down is: wrong axes or components show."""

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.pool_run_resample import resample
from pipeline.records.run_arrays import PoolRun
from pipeline.types import FloatArray

_TABLE_HZ = 20.0
_LEAST_ROWS = 100
#: A vehicle that accelerates by a third of gravity feels it 18 degrees off.
_MOST_APART_DEG = 30.0


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
    size = np.linalg.norm(force, axis=1)
    felt = size > 0.0
    if felt.sum() < _LEAST_ROWS:
        return []
    down = down_in_body(table.values["attitude"][rows][felt])
    cosine = -(force[felt] / size[felt, None] * down).sum(axis=1)
    apart = float(np.degrees(np.median(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    if apart < _MOST_APART_DEG:
        return []
    attitude, specific = run.channels["attitude"].topic, run.channels["specific_force"].topic
    return [
        Problem(
            "warning",
            place,
            f"down by the specific force ({specific}) and down by the attitude ({attitude}) are "
            f"{apart:.0f} degrees apart.",
            "",
            "Check axes, sign and, of a quaternion, order of both under pool: channels in "
            "vehicle.yaml.",
        )
    ]


def down_in_body(attitude: FloatArray) -> FloatArray:
    """R^T e_z (n, 3) of quaternions w, x, y, z (n, 4), body to NED, of any length but zero."""
    w, x, y, z = attitude.T
    down = np.stack([x * z - w * y, y * z + w * x, 0.5 * (w * w - x * x - y * y + z * z)], axis=1)
    return np.asarray(2.0 * down / (attitude**2).sum(axis=1, keepdims=True))
