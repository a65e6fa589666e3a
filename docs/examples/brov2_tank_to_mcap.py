# ruff: noqa: INP001  a script, not a package
"""Convert measured tank runs of a BlueROV2 from npz to logs that rig2sea reads with a vehicle file.

``python docs/examples/brov2_tank_to_mcap.py FOLDER_OF_NPZ --to raw/brov2_tank``; the vehicle file
is ``tests/acceptance/brov2_tank/vehicle.yaml``. The logs are standard ROS 2 messages:

- ``/thrusters/command`` (sensor_msgs/JointState): codes of eight thrusters, see `codes_of`;
- ``/mocap/odometry`` (nav_msgs/Odometry): position, attitude, body velocity and rates, from the
  motion capture, at the times of the file (about 5 Hz, irregular).

The source is github.com/SAABmarine-MEX/saabmarineMEX_learning (commit dda3f3d3, May 2025), reduced
to its measured arrays: ``timestamps_ns``, ``positions`` (x y z roll pitch yaw, all zeroed at the
start by subtraction), ``velocities_body`` (u v w p q r), ``rc_scaled_controls`` (pitch, roll, heave
with its sign turned, yaw, forward, lateral, each (RC override - 1500 us) / 400 us).

What was found out about the axes: each command goes with its own velocity with a positive sign
(correlation 0.82 to 0.97), so body axes are forward, starboard, down. The subtraction left the
heading turned against the position; `heading_offset` finds by how much from the velocities.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.export.log_topics import BODY_FRAME, EARTH_FRAME, Topic
from pipeline.export.mcap_log import write_run_log
from pipeline.simulate.sensors import Channel
from pipeline.types import FloatArray

#: Columns of rc_scaled_controls that are surge, sway, heave, roll, pitch, yaw.
AXES = (4, 5, 2, 1, 0, 3)
CODE_MAX = 400.0
#: Thruster -> what a full command of surge, sway, heave, roll, pitch, yaw adds to its code, as
#: ArduSub mixes the frame with eight thrusters in manual mode. Positive codes push as the vehicle
#: file says: forward or up.
MIXER = {
    "front_right": (1, -1, 0, 0, 0, -1),
    "front_left": (1, 1, 0, 0, 0, 1),
    "rear_right": (1, 1, 0, 0, 0, -1),
    "rear_left": (1, -1, 0, 0, 0, 1),
    "vertical_front_right": (0, 0, -1, -1, 1, 0),
    "vertical_front_left": (0, 0, -1, 1, 1, 0),
    "vertical_rear_right": (0, 0, -1, -1, -1, 0),
    "vertical_rear_left": (0, 0, -1, 1, -1, 0),
}
#: Fresh water, as the vehicle file has it. Nothing in the logs is a pressure.
DENSITY_KGPM3, GRAVITY_MPS2 = 1000.0, 9.82


def codes_of(controls: FloatArray) -> FloatArray:
    """Mix axis commands (m, 6) to codes (m, 8) from -400 to 400.

    An assumption: the pilot's commands went through the autopilot, whose mode the source does not
    state. In manual mode it mixes them like this; in a stabilised mode it adds its own.
    """
    mixed = CODE_MAX * controls[:, AXES] @ np.array(list(MIXER.values()), float).T
    return np.asarray(np.clip(np.round(mixed), -CODE_MAX, CODE_MAX))


def heading_offset(time_s: FloatArray, positions: FloatArray, velocity: FloatArray) -> float:
    """Angle [rad] to add to the heading so that the body velocity is the rate of the position.

    The least-squares turn in the plane between the horizontal velocity by the attitude and by the
    differences of the positions.
    """
    moved = np.gradient(positions[:, :3], time_s, axis=0)
    turned = attitude(positions).apply(velocity[:, :3])
    along = (turned[:, 0] * moved[:, 0] + turned[:, 1] * moved[:, 1]).sum()
    across = (turned[:, 0] * moved[:, 1] - turned[:, 1] * moved[:, 0]).sum()
    return float(np.arctan2(across, along))


def attitude(positions: FloatArray, offset_rad: float = 0.0) -> Rotation:
    """Attitudes body to NED of roll, pitch, yaw (columns 3 to 5)."""
    roll, pitch, yaw = positions[:, 3:6].T
    return Rotation.from_euler("ZYX", np.stack([yaw + offset_rad, pitch, roll], axis=1))


def convert(source: Path, target: Path) -> float:
    """Write the log of a file; returns the heading offset. [rad]."""
    with np.load(source, allow_pickle=False) as arrays:
        stamps_ns = arrays["timestamps_ns"].astype(np.int64)
        positions, velocity = arrays["positions"], arrays["velocities_body"]
        codes = codes_of(arrays["rc_scaled_controls"])
    start_ns = int(stamps_ns[0])
    time_s = (stamps_ns - start_ns) / 1e9
    offset = heading_offset(time_s, positions, velocity)
    odometry = Topic(
        "/mocap/odometry",
        "nav_msgs/msg/Odometry",
        "motion capture: pose.pose body to NED [m], twist.twist in body axes [m/s, rad/s]",
        time_s,
        time_s,
        {
            "header.frame_id": EARTH_FRAME,
            "child_frame_id": BODY_FRAME,
            "pose.pose.position": positions[:, :3],
            "pose.pose.orientation": attitude(positions, offset).as_quat(),
            "twist.twist.linear": velocity[:, :3],
            "twist.twist.angular": velocity[:, 3:],
        },
    )
    # row k is the mean over the same bin as row k of the velocities; the last has none
    commands = Channel(tuple(MIXER), time_s[:-1], time_s[:-1], codes)
    write_run_log(
        target,
        {"command": commands},
        vehicle_name="brov2_tank",
        density_kgpm3=DENSITY_KGPM3,
        gravity_mps2=GRAVITY_MPS2,
        more=[odometry],
        metadata={
            "source": f"saabmarineMEX_learning @ dda3f3d3, {source.name}",
            "heading_offset_rad": f"{offset:.4f}",
        },
        start_time_ns=start_ns,
    )
    return offset


def main(arguments: list[str] | None = None) -> None:
    """Convert every file of a folder."""
    parser = argparse.ArgumentParser(description="npz of tank runs to MCAP")
    parser.add_argument("folder", type=Path, help="where the *.npz are")
    parser.add_argument("--to", type=Path, required=True, help="folder, e.g. raw/brov2_tank")
    given = parser.parse_args(arguments)
    for source in sorted(given.folder.glob("*.npz")):
        target = given.to / "pool" / f"{source.stem.removesuffix('_measured')}.mcap"
        offset = convert(source, target)
        print(f"{target}: heading turned by {np.degrees(offset):.1f} deg")


if __name__ == "__main__":
    main()
