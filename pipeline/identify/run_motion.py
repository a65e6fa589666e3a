"""The measured motion of a run for an equation of motion: whatever of it was measured.

Accelerations come from the accelerometer where there is one, else from the velocity, the position,
or, in heave alone, the depth. Where no velocity was measured, what the accelerations add up to over
a few seconds stands for it: enough to take drag into account, not enough to call it a speed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.identify.smoothing import leaky_sum
from pipeline.physics.complementary_filter import followed
from pipeline.records.run_table import RunTable, down_axis
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: Shortest run that is looked at. [s]
_SHORTEST_S = 5.0
#: Positions with longer pauses between readings are no source of a velocity. [s]
_LONGEST_POSITION_S = 0.5
#: How long what stands for an unmeasured velocity remembers an acceleration. [s]
_MEMORY_S = 5.0
#: Below this share of the vertical the axis of heave says nothing of the depth.
_LEAST_UPRIGHT = 0.7


@dataclass(frozen=True)
class RunMotion:
    """Motion of the body origin on the rows of a table.

    `nu` (m, 6) velocity, zero where nothing is known; `attitude` (m, 4) quaternions, level where
    nothing is known; `run_up` (m, 6) what the accelerations add up to, so that a difference of two
    rows is the integral of nu' between them; `known` (m, 6) where the equation of an axis rests on
    readings. `sources` (6,): the quantity that the acceleration along an axis is from, "" for none.
    """

    period_s: float
    reading_s: float
    """Longest usual pause between readings of what is differentiated. [s]"""
    nu: FloatArray
    attitude: FloatArray
    run_up: FloatArray
    known: BoolArray
    has_velocity: BoolArray
    """(3,): which components of the linear velocity were measured; others are stand-ins."""
    has_attitude: bool
    sources: tuple[str, ...]

    @property
    def down(self) -> FloatArray:
        """Direction of down in body axes (m, 3)."""
        return down_axis(self.attitude)

    @property
    def measured_nu(self) -> FloatArray:
        """Velocity (m, 6) without what only stands for one."""
        found = self.nu.copy()
        found[:, :3] *= self.has_velocity
        return found


def run_motion(packed: PackedVehicle, sensors: Sensors, run: RunTable) -> RunMotion:
    """Work out the motion of a run.

    Raises
    ------
    CannotComputeError
        When the run is too short, or nothing of it tells an acceleration.
    """
    count = run.time_s.size
    period = float(run.time_s[1] - run.time_s[0]) if count > 1 else 0.0
    if count * period < _SHORTEST_S:
        raise CannotComputeError(f"{run.name}: {count * period:.1f} s are too short to tell gains")
    attitude, upright = _attitude(run)
    omega, turning, turned_by = _rates(run, attitude, upright, period)
    place = np.array(sensors.dvl.position_m if sensors.dvl is not None else (0.0, 0.0, 0.0))
    velocity, moving, moved_by = _velocity(run, attitude, upright, omega, place, period)
    has_velocity = np.asarray(moving.any(axis=0), np.bool_)
    if "specific_force" in run.values and upright.any():
        lever = np.array(sensors.imu.position_m if sensors.imu is not None else (0.0, 0.0, 0.0))
        force = np.nan_to_num(run.values["specific_force"])
        felt = run.valid["specific_force"] & upright & turning
        # of the origin but for the part by the angular acceleration, which adds up to omega x r
        plain = force + packed.context.gravity_mps2 * down_axis(attitude)
        plain -= np.cross(omega, np.cross(omega, lever) + np.where(moving, velocity, 0.0))
        plain = np.where(felt[:, None], plain, 0.0)
        # up to a row, not half a step beyond it
        run_up = period * (np.cumsum(plain, axis=0) - 0.5 * plain) - np.cross(omega, lever)
        known = felt[:, None] & (moving | ~has_velocity)
        sources = ["specific_force"] * 3
        # noise of the velocity would stand in drag and thrust at once, as thrust without effect
        if moved_by == "velocity":
            read = np.asarray(known.all(axis=1), np.bool_)
            read &= run.reading.get("velocity", read)
            along = followed(velocity[:, has_velocity], read, run_up[:, has_velocity], period)
            if along is not None:
                velocity[:, has_velocity] = along
        for k in np.flatnonzero(~has_velocity):
            # its mean is taken off first
            change = period * (plain[:, k] - plain[:, k].mean())
            velocity[:, k] = leaky_sum(change, float(np.exp(-period / _MEMORY_S)))
    else:
        run_up, known = velocity, moving
        sources = [moved_by if flag else "" for flag in has_velocity]
    known = np.column_stack([known, np.repeat(turning[:, None], 3, axis=1)])
    if not known.any():
        raise CannotComputeError(
            f"{run.name}: no acceleration can be found; that needs a gyroscope, an accelerometer "
            "with an attitude, a velocity, or a position or depth with an attitude"
        )
    sources += [turned_by] * 3
    return RunMotion(
        period_s=period,
        reading_s=_slowest(run, period),
        nu=np.column_stack([velocity, omega]),
        attitude=attitude,
        run_up=np.column_stack([run_up, omega]),
        known=known,
        has_velocity=has_velocity,
        has_attitude=bool(upright.any()),
        sources=tuple(
            source if flags.any() else "" for source, flags in zip(sources, known.T, strict=True)
        ),
    )


def _slowest(run: RunTable, period: float) -> float:
    """Longest usual pause between readings of what is differentiated. [s]."""
    wanted = ["angular_velocity" if "angular_velocity" in run.values else "attitude"]
    if "specific_force" not in run.values:
        wanted += [
            next((name for name in ("velocity", "position", "depth") if name in run.values), "")
        ]
    return max(period, *(run.pause_s(name) for name in wanted if name in run.reading))


def _attitude(run: RunTable) -> tuple[FloatArray, BoolArray]:
    level = np.tile([1.0, 0.0, 0.0, 0.0], (run.time_s.size, 1))
    if "attitude" not in run.values:
        return level, np.zeros(run.time_s.size, np.bool_)
    values = run.values["attitude"]
    there = run.valid["attitude"] & np.isfinite(values).all(axis=1)
    there &= np.abs(np.nan_to_num(values)).sum(axis=1) > 0.0
    return np.where(there[:, None], np.nan_to_num(values), level), there


def _rates(
    run: RunTable, attitude: FloatArray, upright: BoolArray, period: float
) -> tuple[FloatArray, BoolArray, str]:
    if "angular_velocity" in run.values:
        there = run.trusted("angular_velocity")
        values = np.nan_to_num(run.values["angular_velocity"])
        return np.where(there[:, None], values, 0.0), there, "angular_velocity"
    if not upright.any():
        return np.zeros((run.time_s.size, 3)), np.zeros(run.time_s.size, np.bool_), ""
    turn = Rotation.from_quat(attitude[:, [1, 2, 3, 0]])
    # from the row before to the one after, half of it each way at the ends
    rows = np.arange(run.time_s.size)
    before, after = np.maximum(rows - 1, 0), np.minimum(rows + 1, rows[-1])
    moved = (turn[before].inv() * turn[after]).as_rotvec()
    return moved / (period * (after - before))[:, None], upright, "attitude"


def _velocity(  # noqa: PLR0917  what a velocity is made of
    run: RunTable,
    attitude: FloatArray,
    upright: BoolArray,
    omega: FloatArray,
    place: FloatArray,
    period: float,
) -> tuple[FloatArray, BoolArray, str]:
    """Velocity of the origin (m, 3), where each component is known (m, 3), and what it is from."""
    count = run.time_s.size
    if "velocity" in run.values:
        values = run.values["velocity"]
        there = run.valid["velocity"][:, None] & np.isfinite(values)
        return np.nan_to_num(values) - np.cross(omega, place), there, "velocity"
    nothing = np.zeros((count, 3)), np.zeros((count, 3), np.bool_), ""
    if not upright.any():
        return nothing
    if "position" in run.values and _is_dense(run, "position"):
        rate = np.gradient(np.nan_to_num(run.values["position"]), period, axis=0)
        there = run.valid["position"] & upright
        turn = Rotation.from_quat(attitude[:, [1, 2, 3, 0]])
        return turn.inv().apply(rate), np.repeat(there[:, None], 3, axis=1), "position"
    if "depth" in run.values and _is_dense(run, "depth"):
        climb = np.gradient(np.nan_to_num(run.values["depth"][:, 0]), period)
        along = down_axis(attitude)[:, 2]
        there = run.valid["depth"] & upright & (along > _LEAST_UPRIGHT)
        values, known, _ = nothing
        values[:, 2] = np.where(there, climb / np.maximum(along, _LEAST_UPRIGHT), 0.0)
        known[:, 2] = there
        return values, known, "depth"
    return nothing


def _is_dense(run: RunTable, name: str) -> bool:
    read_at = run.time_s[run.reading[name]] if name in run.reading else run.time_s
    return read_at.size > 2 and float(np.median(np.diff(read_at))) <= _LONGEST_POSITION_S
