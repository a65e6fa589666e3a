"""Motions written down by hand, for the tests of the sensors; the kernel takes no part."""

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.physics.parameters import write
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.simulate.sensors import Log, measure
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

Make = Callable[..., PackedVehicle]
GRAVITY = 9.81  # as the plain vehicle's context says
STEP_S = 0.02


def motion(
    duration_s: float = 2.0,
    *,
    nu: tuple[float, ...] = (0, 0, 0, 0, 0, 0),
    nu_dot: tuple[float, ...] = (0, 0, 0, 0, 0, 0),
    roll_pitch_yaw: tuple[float, float, float] = (0, 0, 0),
    position: tuple[float, float, float] = (0, 0, 0),
    command: FloatArray | None = None,
    actuator: FloatArray | None = None,
    start_s: float = 0.0,
) -> Trajectory:
    """Velocity that is constant or changes evenly, at an attitude and a place that are held."""
    count = round(duration_s / STEP_S) + 1
    elapsed = STEP_S * np.arange(count)
    yaw_pitch_roll = roll_pitch_yaw[::-1]
    x, y, z, w = Rotation.from_euler("ZYX", yaw_pitch_roll).as_quat()
    codes = np.zeros((count, 5)) if command is None else command
    return Trajectory(
        time_s=start_s + elapsed,
        position_ned_m=np.tile(np.array(position, float), (count, 1)),
        quaternion=np.tile([w, x, y, z], (count, 1)),
        nu=np.array(nu, float) + elapsed[:, None] * np.array(nu_dot, float),
        nu_dot=np.tile(np.array(nu_dot, float), (count, 1)),
        command=codes,
        actuator=codes if actuator is None else actuator,
        thrust_n=np.zeros((count, 5)),
        final_state=np.zeros(18),
    )


def changed(packed: PackedVehicle, **slots: object) -> FloatArray:
    vector = packed.vector.copy()
    for name, value in slots.items():
        write(vector, name, np.asarray(value, float))
    return vector


def sense(packed: PackedVehicle, trajectory: Trajectory, seed: int = 0, **sensors: object) -> Log:
    vector = sensors.pop("vector", None)
    return measure(trajectory, packed, Sensors(**sensors), vector=vector, seed=seed)  # type: ignore[arg-type]


def each(values: FloatArray, expected: tuple[float, ...]) -> None:
    """Every reading is the expected one."""
    assert len(values)
    np.testing.assert_allclose(values, np.tile(expected, (len(values), 1)), rtol=0, atol=1e-12)


def with_shaft_tables(packed: PackedVehicle) -> PackedVehicle:
    """Shaft speed 20 code + 50 speed along the thruster [rpm]: a plane, interpolated exactly."""
    code, speed = np.arange(128.0), np.arange(0.0, 2.05, 0.1)
    return dataclasses.replace(packed, shaft_tables=(20 * code + 50 * speed[:, None])[None])
