"""What is flown: the vehicle, speeds, disturbance, steps."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.control.autopilot import Design
from pipeline.physics.parameters import read, write
from pipeline.simulate.applied_wrench import inflow_speed, settled_thrust
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.validate.flight import AXIS_ROWS

#: Length of a keeping flight, and of one with a step. [s]
KEEPING_S = 30.0
STEP_FLIGHT_S = 20.0
#: When a step comes. [s]
STEP_AT_S = 2.0
HEADING_STEP_DEG = 10.0
DEPTH_STEP_M = 0.4
#: A heading step that no portion reaches at once: how fast it goes shows what the portion allows.
LARGE_STEP_DEG = 60.0
#: The disturbance pushes with sines on heave and yaw: as much as the autopilot's stiffness at rest
#: answers with these deviations, but at most this share of the range at the highest speed.
PUSH_DEPTH_M = 0.15
PUSH_HEADING_DEG = 5.0
LARGEST_PUSH = 0.15
#: Periods of the disturbance on surge, heave, pitch, yaw. [s]
DISTURBANCE_PERIOD_S = np.array([1.0, 10.0, 1.0, 7.5])
#: Surge portions that are flown; heading and pitch get the rest.
SURGE_PORTIONS = (0.3, 0.5, 0.6, 0.7, 0.85)
#: A vehicle without a table of speeds is flown at these shares of the speed that it can keep.
SPEED_SHARES = (0.0, 0.25, 0.5, 0.75, 0.9)
_FASTEST_MPS = 5.0
#: A thruster with a smaller share of an axis takes no part in it. [N/N], [N/(N m)]
_NO_SHARE = 1e-9


def calm_vehicle(packed: PackedVehicle) -> PackedVehicle:
    """Return the vehicle in open water, with thrust that falls with speed as its tables have it.

    Walls are far away, and the inflow of every thruster counts, less its wake fraction: where the
    nominal model leaves it out there would be nothing to compensate.
    """
    vector = packed.vector.copy()
    write(vector, "wall_count", 0.0)
    share = np.zeros_like(read(vector, "inflow_fraction"))
    share[: len(packed.thruster_names)] = packed.context.inflow_shares or 1.0
    write(vector, "inflow_fraction", share)
    return replace(packed, vector=vector)


def thrust_limits(packed: PackedVehicle, speed_mps: float) -> FloatArray:
    """Largest thrust forward and in reverse that each thruster can give at a surge speed. [N].

    Shape (2, n), both positive, at the ends of the codes; against the motion no more is promised
    than along it, as the firmware's limits are. A drive without negative codes gives nothing in
    reverse.
    """
    size = np.abs(inflow_speed(packed, np.eye(6)[:1] * speed_mps))[0]
    reverse, forward = settled_thrust(packed, packed.code_limits.T, np.stack([-size, size]))
    return np.asarray(np.maximum(np.stack([forward, -reverse]), 0.0))


def axis_range(packed: PackedVehicle, thrust_of_wrench: FloatArray, speed_mps: float) -> FloatArray:
    """Largest force and moment on each axis alone at a speed, (6,); 0 where there is none.

    Of surge that ahead, which is what keeps a speed; of every other axis the smaller of both ways.
    `thrust_of_wrench` (n, 6) are the thrusts that the allocator shares a unit of each axis out to;
    a column of zeros where it has no means.
    """
    forward, reverse = thrust_limits(packed, speed_mps)[:, :, None]
    size = np.abs(thrust_of_wrench)

    def room(limit: FloatArray) -> FloatArray:
        each = np.divide(limit, size, out=np.full(size.shape, np.inf), where=size > _NO_SHARE)
        least = each.min(axis=0)
        return np.where(np.isfinite(least), least, 0.0)

    ahead = room(np.where(thrust_of_wrench > 0.0, forward, reverse))
    back = room(np.where(thrust_of_wrench > 0.0, reverse, forward))
    return np.concatenate([ahead[:1], np.minimum(ahead, back)[1:]])


def without_needed_reverse(packed: PackedVehicle, thrust_of_wrench: FloatArray) -> tuple[str, ...]:
    """Name the thrusters that surge ahead needs in reverse and whose drives give none."""
    _, reverse = thrust_limits(packed, 0.0)
    lacking = (thrust_of_wrench[:, 0] < -_NO_SHARE) & (reverse <= 0.0)
    return tuple(name for name, lacks in zip(packed.thruster_names, lacking, strict=True) if lacks)


def fastest_kept_mps(packed: PackedVehicle, thrust_of_wrench: FloatArray) -> float:
    """Speed at which the drag of the model takes all the surge force there is. [m/s]."""
    linear = float(read(packed.vector, "linear_damping")[0, 0])
    quadratic = float(read(packed.vector, "quadratic_damping")[0])
    speeds = np.arange(0.0, _FASTEST_MPS, 0.01)
    force = np.array([axis_range(packed, thrust_of_wrench, float(v))[0] for v in speeds])
    short = np.flatnonzero(linear * speeds + quadratic * speeds**2 > force)
    return float(speeds[short[0]]) if short.size else _FASTEST_MPS


def push(design: Design, range_n_nm: FloatArray) -> FloatArray:
    """Amplitudes (4,) of the disturbance on surge, heave, pitch, yaw. [N], [N m].

    Surge is left alone: what the speed does then is the allocator's doing. `range_n_nm` (4,) is
    that at the highest speed. [N], [N m]
    """
    heave = design.heave_mass_kg * design.depth_bandwidth**2 * PUSH_DEPTH_M
    yaw = design.yaw_inertia_kgm2 * design.heading_bandwidth**2 * np.radians(PUSH_HEADING_DEG)
    return np.asarray(np.minimum(np.array([0.0, heave, 0.0, yaw]), LARGEST_PUSH * range_n_nm))


def disturbance(amplitude: FloatArray) -> Callable[[float], FloatArray]:
    """Sines on surge, heave, pitch, yaw as a function of time; `amplitude` (4,). [N], [N m]."""
    rate = 2.0 * np.pi / DISTURBANCE_PERIOD_S

    def at(time_s: float) -> FloatArray:
        force = np.zeros(6)
        force[list(AXIS_ROWS)] = amplitude * np.sin(rate * time_s)
        return force

    return at


def calm(_time_s: float) -> FloatArray:
    """No disturbance."""
    return np.zeros(6)
