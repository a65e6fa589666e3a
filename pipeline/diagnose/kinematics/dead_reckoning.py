r"""Dead reckoning by DVL and attitude, held against the measured position and depth.

Kinematics alone decides how the two differ; no mass, damping or thrust takes part. With the errors
of a DVL as `ERRORS` lists them, (Kinsey and Whitcomb 2007, IEEE J. Oceanic Eng. 32(2), 286-299)

.. math:: p(t_2) - p(t_1) = \int_{t_1}^{t_2} R \left[ \tfrac{1}{s} R_e\, v_{meas}(t + \tau)
          - \omega \times (r + \delta r) \right] dt

Runs are cut into stretches from one reading of the place to another. What a stretch lacks is linear
in what the errors are off by, and so it is in a constant error of the run's attitude.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.identify.channel_noise import was_measured
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

#: What may be wrong with the velocity: effect and parameter, its neutral value, and the step with
#: which its derivative is taken.
ERRORS: tuple[tuple[str, str, float, float], ...] = (
    ("dvl_delay", "delay_s", 0.0, 0.02),
    ("dvl_lever_arm", "x_m", 0.0, 0.01),
    ("dvl_lever_arm", "y_m", 0.0, 0.01),
    ("dvl_lever_arm", "z_m", 0.0, 0.01),
    ("dvl_misalignment", "roll_deg", 0.0, 0.1),
    ("dvl_misalignment", "pitch_deg", 0.0, 0.1),
    ("dvl_misalignment", "yaw_deg", 0.0, 0.1),
    ("dvl_scale", "scale", 1.0, 0.01),
)
NEUTRAL = np.array([neutral for _, _, neutral, _ in ERRORS])
#: Least and most time from one end of a stretch to the other. [s]
_STRETCH_S, _LONGEST_S = 2.0, 6.0
_CONTINUOUS = ("velocity", "attitude", "angular_velocity")
_NEEDED = (*_CONTINUOUS, "position")


@dataclass(frozen=True)
class Mount:
    """How the DVL is stated to sit: its turn to the body, and its place. [m]."""

    turn: Rotation
    place_m: FloatArray


@dataclass(frozen=True)
class Track:
    """What a run has for dead reckoning.

    `omega`, `velocity` (m, 3) as measured at `time_s` (m,), `missing` (m,) where either or the
    attitude is not known. By axis north, east, down: `ends`, samples between which stretches lie,
    and `place`, what was read there.
    """

    time_s: FloatArray
    attitude: Rotation
    omega: FloatArray
    velocity: FloatArray
    missing: BoolArray
    ends: tuple[IntArray, ...]
    place: tuple[FloatArray, ...]


@dataclass(frozen=True)
class Stretches:
    """The stretches of one run along one axis.

    `lacks` (n,) what dead reckoning lacks to the measured distance [m], `causes` (n, 8) what a unit
    of each error adds to it, `turned` (n, 3) what a radian of a constant error of the attitude
    adds; `duration_s` (n,), `middle_s` (n,) of each, `joined` (n - 1,) whether the next one begins
    where it ends.
    """

    run: int
    axis: int
    lacks: FloatArray
    causes: FloatArray
    turned: FloatArray
    duration_s: FloatArray
    middle_s: FloatArray
    joined: BoolArray


def mount_of(sensors: Sensors) -> Mount:
    """How the vehicle file states the DVL to sit."""
    dvl = sensors.dvl
    rotation = (0.0, 0.0, 0.0) if dvl is None else dvl.rotation_deg
    place = (0.0, 0.0, 0.0) if dvl is None else dvl.position_m
    return Mount(Rotation.from_euler("ZYX", np.radians(rotation)[::-1]), np.array(place))


def track_of(run: RunTable, sensors: Sensors) -> Track | None:
    """Take from a run what dead reckoning needs; None where that was not measured.

    Depth alone is not enough: what the attitude's wander adds to the little that a vehicle moves up
    and down looks like a DVL that is turned.
    """
    if not all(was_measured(run, name) for name in _NEEDED):
        return None
    known = np.logical_and.reduce([run.valid[name] for name in _CONTINUOUS])
    level = np.array([1.0, 0.0, 0.0, 0.0])
    quaternion = np.where(run.valid["attitude"][:, None], run.values["attitude"], level)
    attitude = Rotation.from_quat(quaternion[:, [1, 2, 3, 0]])
    axes = [_ends(run, "position", values) for values in run.values["position"].T]
    if was_measured(run, "depth"):
        place = np.zeros(3) if sensors.depth is None else np.array(sensors.depth.position_m)
        depth = run.values["depth"][:, 0] - attitude.apply(place)[:, 2]
        axes[2] = _ends(run, "depth", depth)
    if all(ends.size < 2 for ends, _ in axes):
        return None
    return Track(
        run.time_s,
        attitude,
        np.nan_to_num(run.values["angular_velocity"]),
        np.nan_to_num(run.values["velocity"]),
        ~known,
        tuple(ends for ends, _ in axes),
        tuple(place for _, place in axes),
    )


def _ends(run: RunTable, quantity: str, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """Choose readings of a place that are a stretch apart."""
    seen = run.valid[quantity] & np.isfinite(values)
    if quantity in run.reading:
        seen = seen & run.reading[quantity]
    chosen: list[int] = []
    for sample in np.flatnonzero(seen).tolist():
        if not chosen or run.time_s[sample] - run.time_s[chosen[-1]] >= _STRETCH_S:
            chosen.append(sample)
    ends = np.array(chosen, int)
    return ends, values[ends]


def velocity_of_body(track: Track, errors: FloatArray, mount: Mount) -> FloatArray:
    """Velocity (m, 3) of the body's origin in body axes, the errors (8,) of the DVL undone."""
    late, arm, turn, scale = errors[0], errors[1:4], errors[4:7], errors[7]
    shown = track.velocity
    if late != 0.0:
        shown = np.stack(
            [np.interp(track.time_s + late, track.time_s, one) for one in shown.T], axis=1
        )
    wrong = Rotation.from_euler("ZYX", np.radians(turn)[::-1])
    there = (mount.turn * wrong * mount.turn.inv()).apply(shown) / scale
    return np.asarray(there - np.cross(track.omega, mount.place_m + arm))


def stretches(tracks: Sequence[Track], errors: FloatArray, mount: Mount) -> tuple[Stretches, ...]:
    """Hold dead reckoning with some errors (8,) of the DVL against the place, run by run."""
    return tuple(
        one for number, track in enumerate(tracks) for one in _of_run(number, track, errors, mount)
    )


def _of_run(number: int, track: Track, errors: FloatArray, mount: Mount) -> list[Stretches]:
    def covered(velocity: FloatArray) -> FloatArray:
        """Distance north, east, down (m, 3) since the begin."""
        earth = track.attitude.apply(velocity)
        steps = 0.5 * (earth[1:] + earth[:-1]) * np.diff(track.time_s)[:, None]
        return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])

    velocity = velocity_of_body(track, errors, mount)
    own = covered(velocity)
    causes = []
    for index, (_, _, _, step) in enumerate(ERRORS):
        ahead, behind = errors.copy(), errors.copy()
        ahead[index] += step
        behind[index] -= step
        change = covered(velocity_of_body(track, ahead, mount))
        causes.append((change - covered(velocity_of_body(track, behind, mount))) / (2.0 * step))
    turned = [covered(np.cross(axis, velocity)) for axis in np.eye(3)]
    # what a late velocity shows at a time was read later
    later = np.interp(track.time_s + errors[0], track.time_s, track.missing) > 0.0
    gaps = np.concatenate([[0], np.cumsum(track.missing | later)])
    found = []
    for axis, (ends, place) in enumerate(zip(track.ends, track.place, strict=True)):
        if ends.size < 2:
            continue
        first, last = ends[:-1], ends[1:]
        # readings of the velocity that belong to a stretch are those of its time, late or not
        shown = track.time_s[[0, -1]] - errors[0]
        good = (gaps[last + 1] == gaps[first]) & (
            track.time_s[last] - track.time_s[first] <= _LONGEST_S
        )
        good &= (track.time_s[first] >= shown[0]) & (track.time_s[last] <= shown[1])
        if not good.any():
            continue
        first, last = first[good], last[good]

        def over(
            way: FloatArray, a: IntArray = first, b: IntArray = last, k: int = axis
        ) -> FloatArray:
            return np.asarray(way[b, k] - way[a, k])

        found.append(
            Stretches(
                number,
                axis,
                np.diff(place)[good] - over(own),
                np.stack([over(way) for way in causes], axis=1),
                np.stack([over(way) for way in turned], axis=1),
                track.time_s[last] - track.time_s[first],
                0.5 * (track.time_s[last] + track.time_s[first]),
                first[1:] == last[:-1],
            )
        )
    return found
