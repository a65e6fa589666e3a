"""Runs of a vehicle that is nothing but a motion: velocity and attitude known in closed form."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

PERIOD_S = 0.02
#: Body velocity [m/s] and roll, pitch, yaw [rad] at a time [s].
Motion = tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FloatArray]]


def lively(phase: float = 0.0) -> Motion:
    """Speed and attitude that change on every axis."""

    def velocity(t: FloatArray) -> FloatArray:
        t = t + phase
        parts = 0.6 + 0.4 * np.sin(0.5 * t), 0.3 * np.sin(0.37 * t + 1.0), 0.2 * np.cos(0.61 * t)
        return np.stack(parts, axis=-1)

    def angles(t: FloatArray) -> FloatArray:
        t = t + phase
        parts = (
            0.2 * np.sin(0.7 * t),
            0.25 * np.sin(0.45 * t + 0.5),
            1.2 * np.sin(0.3 * t) + 0.1 * t,
        )
        return np.stack(parts, axis=-1)

    return velocity, angles


def straight() -> Motion:
    """Ahead at one speed, level, on one heading."""

    def velocity(t: FloatArray) -> FloatArray:
        return np.tile([0.8, 0.0, 0.0], (t.size, 1))

    def angles(t: FloatArray) -> FloatArray:
        return np.tile([0.0, 0.0, 0.4], (t.size, 1))

    return velocity, angles


def reckoned_run(
    motion: Motion,
    delay_s: float = 0.0,
    arm_m: Sequence[float] = (0.0, 0.0, 0.0),
    turn_deg: Sequence[float] = (0.0, 0.0, 0.0),
    scale: float = 1.0,
    *,
    place_m: Sequence[float] = (0.0, 0.0, 0.0),
    mount_deg: Sequence[float] = (0.0, 0.0, 0.0),
    seconds: float = 60.0,
    noise: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
) -> RunTable:
    """Make the table of a run whose DVL is wrong by so much; `noise` of velocity and position."""
    velocity, angles = motion
    time_s = PERIOD_S * np.arange(round(seconds / PERIOD_S) + 1)

    def attitude(t: FloatArray) -> Rotation:
        return Rotation.from_euler("ZYX", angles(t)[..., ::-1])

    def omega(t: FloatArray) -> FloatArray:
        half = 1e-4
        return (attitude(t - half).inv() * attitude(t + half)).as_rotvec() / (2.0 * half)

    fine = PERIOD_S / 4.0 * np.arange(4 * (time_s.size - 1) + 1)
    earth = attitude(fine).apply(velocity(fine))
    # Simpson's rule over each period
    parts = [earth[k::4][: time_s.size - 1] for k in range(4)] + [earth[4::4]]
    steps = PERIOD_S / 12.0 * (parts[0] + 4 * parts[1] + 2 * parts[2] + 4 * parts[3] + parts[4])
    position = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    then = time_s - delay_s
    there = velocity(then) + np.cross(omega(then), np.array(place_m) + np.array(arm_m))
    mount = Rotation.from_euler("ZYX", np.radians(mount_deg)[::-1])
    wrong = Rotation.from_euler("ZYX", np.radians(turn_deg)[::-1])
    shown = scale * (mount * wrong.inv() * mount.inv()).apply(there)
    draw = np.random.default_rng(seed)
    known = np.ones(time_s.size, bool)
    reading = np.arange(time_s.size) % 10 == 0

    def error(deviation: float) -> FloatArray:
        """Draw that of a reading every tenth sample, straight lines between, as in a table."""
        at = np.flatnonzero(reading)
        drawn = deviation * draw.standard_normal((at.size, 3))
        return np.stack([np.interp(time_s, time_s[at], one) for one in drawn.T], axis=1)

    turn = attitude(time_s).as_quat()[:, [3, 0, 1, 2]]
    values = {
        "velocity": shown + error(noise[0]),
        "attitude": turn,
        "angular_velocity": omega(time_s),
        "position": position + error(noise[1]),
    }
    return RunTable(
        "run",
        time_s,
        values,
        dict.fromkeys(values, known),
        reading={"velocity": reading, "position": reading},
    )
