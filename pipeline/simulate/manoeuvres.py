"""The manoeuvres a vehicle can be asked to fly, by name."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.control.autopilot import Reference
from pipeline.physics.parameters import read
from pipeline.simulate import signals
from pipeline.simulate.fly import Plan, general_allocator
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import initial_state
from pipeline.types import FloatArray

#: Depth at which the manoeuvres are flown in open water, and where walls are known. [m]
OPEN_WATER_DEPTH_M = 10.0
POOL_DEPTH_M = 1.5
#: Largest roll or pitch that an excitation may hold against the righting moment. [rad]
LARGEST_TILT_RAD = 0.15


@dataclass(frozen=True)
class Manoeuvre:
    """A named manoeuvre: what it is for, and the plan it makes for a vehicle.

    `plan(packed, amplitude, duration)`: amplitude 1 is the usual size; `duration_s` the usual
    length.
    """

    name: str
    purpose: str
    duration_s: float
    plan: Callable[[PackedVehicle, float, float], Plan]


def _reach(packed: PackedVehicle) -> FloatArray:
    """Largest force and moment along each axis alone at rest, (6,); 0 where there is none."""
    allocator = general_allocator(packed)
    matrix = allocator.configuration()
    size = np.minimum(allocator.largest_n, -allocator.smallest_n)
    reach = np.zeros(6)
    inverse = np.linalg.pinv(matrix, rcond=1e-6)
    for axis in range(6):
        unit = inverse[:, axis]
        if np.abs(matrix @ unit - np.eye(6)[axis]).max() < 1e-6:
            reach[axis] = float(np.min(size / np.maximum(np.abs(unit), 1e-12)))
    return reach


def _gentle_reach(packed: PackedVehicle) -> FloatArray:
    """`_reach` with roll and pitch held to a tilt that a pool trial would allow, (6,)."""
    vector = packed.vector
    righting = float(
        read(vector, "weight") * read(vector, "centre_of_mass")[2]
        - read(vector, "buoyancy") * read(vector, "centre_of_buoyancy")[2]
    )
    reach = _reach(packed)
    reach[3:5] = np.minimum(reach[3:5], max(righting, 0.0) * LARGEST_TILT_RAD / 0.35)
    return reach


def _speed(packed: PackedVehicle, amplitude: float) -> float:
    """Cruising speed [m/s]: what 0.4 of the surge force sustains by the nominal drag."""
    force = 0.4 * _reach(packed)[0]
    linear = float(read(packed.vector, "linear_damping")[0, 0])
    quadratic = float(read(packed.vector, "quadratic_damping")[0])
    if quadratic <= 0.0:
        return float(amplitude * force / max(linear, 1e-9))
    root = (-linear + np.sqrt(linear**2 + 4 * quadratic * force)) / (2 * quadratic)
    return amplitude * float(root)


def _depth(packed: PackedVehicle) -> float:
    return POOL_DEPTH_M if packed.context.walls else OPEN_WATER_DEPTH_M


def _start(packed: PackedVehicle) -> FloatArray:
    return initial_state(position_ned_m=(0.0, 0.0, _depth(packed)))


def _under_autopilot(
    packed: PackedVehicle, reference: Callable[[float], Reference], duration_s: float
) -> Plan:
    """Fly references; depth and pitch are held where the reference leaves them open."""
    depth = _depth(packed)

    def complete(t: float) -> Reference:
        wanted = reference(t)
        return replace(
            wanted,
            depth_m=depth if wanted.depth_m is None else depth + wanted.depth_m,
            pitch_rad=0.0 if wanted.pitch_rad is None else wanted.pitch_rad,
        )

    return Plan(duration_s, reference=complete, start=_start(packed))


def _hover(packed: PackedVehicle, _amplitude: float, duration_s: float) -> Plan:
    return _under_autopilot(packed, lambda _t: Reference(0.0, heading_rad=0.0), duration_s)


def _straight(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    speed = _speed(packed, amplitude)
    return _under_autopilot(packed, lambda _t: Reference(speed, heading_rad=0.0), duration_s)


def _surge_steps(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    speed = _speed(packed, amplitude)
    levels = (0.0, 0.5, 1.0, 0.25, 0.75, 0.0)
    return _under_autopilot(
        packed,
        lambda t: Reference(speed * levels[min(int(t / duration_s * 6), 5)], heading_rad=0.0),
        duration_s,
    )


def _surge_ramp(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    """Open loop: force rises along a line, then is cut off (coast-down)."""
    force = 0.5 * amplitude * _reach(packed)[0]

    def wrench(t: float) -> FloatArray:
        share = float(signals.ramp(np.array([t]), 5.0, 0.6 * duration_s)[0])
        return np.array([force * share if t < 0.75 * duration_s else 0.0, 0, 0, 0, 0, 0])

    keep = Reference(depth_m=_depth(packed), heading_rad=0.0, pitch_rad=0.0)
    return Plan(duration_s, reference=lambda _t: keep, wrench=wrench, start=_start(packed))


def _zig_zag(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    speed, swing = _speed(packed, 1.0), np.radians(20.0) * amplitude
    period = 20.0

    def reference(t: float) -> Reference:
        side = 1.0 if (t // period) % 2 == 0 else -1.0
        return Reference(speed, heading_rad=swing * side if t > 5.0 else 0.0)

    return _under_autopilot(packed, reference, duration_s)


def _circle(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    speed, rate = _speed(packed, 1.0), np.radians(9.0) * amplitude
    return _under_autopilot(
        packed, lambda t: Reference(speed, heading_rad=rate * max(t - 10.0, 0.0)), duration_s
    )


def _spiral(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    """Turn at rates that grow step by step, then the other way (Dieudonne)."""
    speed, rate = _speed(packed, 1.0), np.radians(15.0) * amplitude
    levels = np.array([0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5])
    hold = duration_s / levels.size
    edges = np.concatenate([[0.0], np.cumsum(levels) * hold * rate])

    def reference(t: float) -> Reference:
        k = min(int(t / hold), levels.size - 1)
        heading = float(edges[k] + levels[k] * rate * (t - k * hold))
        return Reference(speed, heading_rad=heading)

    return _under_autopilot(packed, reference, duration_s)


def _heave_steps(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    levels = (0.0, 1.0, 0.0, 2.0, 0.5, 0.0)
    size = amplitude * (0.5 if packed.context.walls else 1.0)
    return _under_autopilot(
        packed,
        lambda t: Reference(0.0, size * levels[min(int(t / duration_s * 6), 5)], 0.0),
        duration_s,
    )


def _pitch_steps(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    speed = _speed(packed, 0.7)
    levels = (0.0, 1.0, 0.0, -1.0, 0.5, 0.0)

    def reference(t: float) -> Reference:
        angle = np.radians(8.0) * amplitude * levels[min(int(t / duration_s * 6), 5)]
        return Reference(surge_mps=speed, heading_rad=0.0, pitch_rad=float(angle))

    # depth is left alone: the vehicle climbs and dives with its pitch
    return Plan(duration_s, reference=reference, start=_start(packed))


def _excitation(
    signal: Callable[[FloatArray, int], FloatArray],
) -> Callable[[PackedVehicle, float, float], Plan]:
    """Open-loop force and moments along every axis that can be pushed, about a gentle hold."""

    def plan(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
        reach = 0.35 * amplitude * _gentle_reach(packed)
        time_s = np.arange(0.0, duration_s + 1.0, 0.1)
        table = np.stack([reach[axis] * signal(time_s, axis) for axis in range(6)], axis=1)
        keep = Reference(depth_m=_depth(packed), heading_rad=0.0)
        return Plan(
            duration_s,
            reference=lambda _t: keep,
            wrench=lambda t: table[min(int(t / 0.1 + 0.5), len(table) - 1)],
            start=_start(packed),
        )

    return plan


def _free_decay(packed: PackedVehicle, amplitude: float, duration_s: float) -> Plan:
    """Released with roll, pitch and velocity; no command at all."""
    start = initial_state(
        position_ned_m=(0.0, 0.0, _depth(packed)),
        attitude_rad=(0.25 * amplitude, 0.15 * amplitude, 0.0),
        nu=(0.8 * amplitude, 0.2 * amplitude, 0.1 * amplitude, 0.0, 0.0, 0.2 * amplitude),
    )
    return Plan(duration_s, start=start)


MANOEUVRES: dict[str, Manoeuvre] = {
    m.name: m
    for m in (
        Manoeuvre("hover", "hold depth and heading at rest", 60.0, _hover),
        Manoeuvre("straight", "run ahead at one speed", 60.0, _straight),
        Manoeuvre("surge_steps", "steps of surge speed", 120.0, _surge_steps),
        Manoeuvre("surge_ramp", "rising surge force, then coasting", 90.0, _surge_ramp),
        Manoeuvre("zig_zag", "heading steps to both sides under way", 120.0, _zig_zag),
        Manoeuvre("circle", "turn at a constant rate under way", 90.0, _circle),
        Manoeuvre("spiral", "turns of growing rate, both ways", 160.0, _spiral),
        Manoeuvre("heave_steps", "steps of depth at rest", 120.0, _heave_steps),
        Manoeuvre("pitch_steps", "steps of pitch under way", 90.0, _pitch_steps),
        Manoeuvre(
            "multisine",
            "sines along every axis, open loop",
            120.0,
            _excitation(
                lambda t, axis: signals.multisine(t, 0.02 + 0.004 * axis, 0.4 + 0.01 * axis, 14)
            ),
        ),
        Manoeuvre(
            "chirp",
            "rising frequency along every axis, open loop",
            120.0,
            _excitation(lambda t, axis: signals.chirp(t, 0.01 + 0.002 * axis, 0.5)),
        ),
        Manoeuvre(
            "prbs",
            "pseudo-random steps along every axis, open loop",
            120.0,
            _excitation(lambda t, axis: signals.prbs(t, 1.5, 61 * axis)),
        ),
        Manoeuvre("free_decay", "released and left alone", 60.0, _free_decay),
    )
}
