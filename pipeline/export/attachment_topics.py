"""Topics of what is attached to a simulated vehicle: its tether with the winch, its latches."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.export.cdr import Filling
from pipeline.export.log_topics import BODY_FRAME, Topic, step_topic
from pipeline.types import FloatArray

if TYPE_CHECKING:  # the simulator brings the compiler along; writing a log does not need it
    from pipeline.simulate.tethered_mover import TetherLog


def topics_of_tether(tether: "TetherLog", prefix: str, *, winch: bool) -> list[Topic]:
    """Topics of a tether at every step of the run, of the drum too where it has a `winch`.

    Raises
    ------
    CannotComputeError
        For a value that is not a finite number.
    """
    time_s = tether.time_s
    tension = step_topic(
        f"{prefix}/tether/tension",
        "sensor_msgs/msg/JointState",
        "effort: tension of the cable at its upper end and at the vehicle [N]",
        time_s,
        {
            "name": ("top", "vehicle"),
            "effort": np.stack([tether.top_tension_n, tether.lower_tension_n], axis=1),
        },
    )
    wrench = _wrench(
        f"{prefix}/tether/wrench",
        "wrench: of the tether on the vehicle, about the body origin, body axes [N, N m]",
        time_s,
        tether.wrench_on_vehicle,
    )
    if not winch:
        return [tension, wrench]
    drum = step_topic(
        f"{prefix}/winch",
        "sensor_msgs/msg/JointState",
        "position: cable paid out [m]; velocity: of the cable, positive pays out [m/s]; "
        "effort: tension at the drum [N]",
        time_s,
        {
            "name": ("winch",),
            "position": tether.paid_out_m[:, None],
            "velocity": tether.payout_mps[:, None],
            "effort": tether.top_tension_n[:, None],
        },
    )
    return [tension, wrench, drum]


def topic_of_latch(module: str, time_s: FloatArray, wrench: FloatArray, prefix: str) -> Topic:
    """Topic of the wrench (k, 6) with which a held module loads its latch.

    Raises
    ------
    CannotComputeError
        For a value that is not a finite number.
    """
    return _wrench(
        f"{prefix}/latch/{module}",
        "wrench: of the held module on the vehicle, an inner load of the latch, about the body "
        "origin, body axes [N, N m]",
        time_s,
        wrench,
    )


def _wrench(name: str, meaning: str, time_s: FloatArray, wrench: FloatArray) -> Topic:
    values: dict[str, Filling] = {
        "header.frame_id": BODY_FRAME,
        "wrench.force": wrench[:, :3],
        "wrench.torque": wrench[:, 3:],
    }
    return step_topic(name, "geometry_msgs/msg/WrenchStamped", meaning, time_s, values)
