"""The manoeuvres a vehicle can be asked to fly, by name.

Where the vehicle file knows walls (a pool), runs ahead become runs to and fro of a few metres with
the heading kept, and turns are tight; elsewhere there is room.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeline.control.autopilot import Setpoint
from pipeline.physics.parameters import read
from pipeline.simulate.fly import FlightPlan
from pipeline.simulate.manoeuvre_reach import ANY_AXIS, gentle_reach, reach_alone
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import initial_state
from pipeline.types import FloatArray

#: Depth at which the manoeuvres are flown in open water, and where walls are known. [m]
OPEN_WATER_DEPTH_M = 10.0
POOL_DEPTH_M = 1.5
#: Length of a run to and fro in a pool, and largest radius of a turn there. [m]
POOL_LEG_M = 3.0
POOL_RADIUS_M = 1.0
#: Excitations in a pool are this much smaller: there is no room to drift.
POOL_EXCITATION = 0.4


def ramp(time_s: FloatArray, start_s: float, rise_s: float) -> FloatArray:
    """0 before `start_s`, then a line to 1 within `rise_s`."""
    return np.clip((time_s - start_s) / rise_s, 0.0, 1.0)


def multisine(time_s: FloatArray, lowest_hz: float, highest_hz: float, lines: int) -> FloatArray:
    """Sum of equally spaced sines with Schroeder's phases, scaled to a peak of one.

    phi_k = -pi k (k - 1) / n keeps the crest factor low (Schroeder 1970, IEEE Trans. Inf. Theory
    16(1), 85-89).
    """
    k = np.arange(1, lines + 1)
    frequency = np.linspace(lowest_hz, highest_hz, lines)
    phase = -np.pi * k * (k - 1) / lines
    signal = np.cos(2 * np.pi * frequency * time_s[:, None] + phase).sum(axis=1)
    return np.asarray(signal / np.abs(signal).max())


def chirp(time_s: FloatArray, start_hz: float, end_hz: float) -> FloatArray:
    """Sine whose frequency grows linearly from start to end over the signal."""
    from scipy.signal import chirp as linear_chirp

    return np.asarray(
        linear_chirp(time_s - time_s[0], start_hz, float(np.ptp(time_s)), end_hz, phi=-90)
    )


def prbs(time_s: FloatArray, hold_s: float, seed: int) -> FloatArray:
    """Pseudo-random binary signal of +1 and -1: a maximum-length sequence held for `hold_s`.

    The seed sets where in the sequence the signal starts.
    """
    from scipy.signal import max_len_seq

    bits = max_len_seq(9)[0] * 2.0 - 1.0
    index = np.floor((time_s - time_s[0]) / hold_s).astype(int) + seed
    return np.asarray(bits[index % bits.size])


@dataclass(frozen=True)
class Manoeuvre:
    """A named manoeuvre: what it is for, and the plan it makes for a vehicle.

    `plan(packed, amplitude, duration)`: amplitude 1 is the usual size; `duration_s` the usual
    length. `axes` are those that it cannot do without.
    """

    name: str
    purpose: str
    duration_s: float
    plan: Callable[[PackedVehicle, float, float], FlightPlan]
    axes: tuple[str, ...] = ()


def _speed(packed: PackedVehicle, amplitude: float) -> float:
    """Cruising speed [m/s]: what 0.4 of the surge force sustains by the nominal drag."""
    force = 0.4 * reach_alone(packed)[0]
    linear = float(read(packed.vector, "linear_damping")[0, 0])
    quadratic = float(read(packed.vector, "quadratic_damping")[0])
    if quadratic <= 0.0:
        return float(amplitude * force / max(linear, 1e-9))
    root = (-linear + np.sqrt(linear**2 + 4 * quadratic * force)) / (2 * quadratic)
    return amplitude * float(root)


def _depth(packed: PackedVehicle) -> float:
    return POOL_DEPTH_M if packed.context.walls else OPEN_WATER_DEPTH_M


def _start(packed: PackedVehicle, north_m: float = 0.0, east_m: float = 0.0) -> FloatArray:
    return initial_state(position_ned_m=(north_m, east_m, _depth(packed)))


def _start_of_leg(packed: PackedVehicle) -> FloatArray:
    """Start of a run ahead: in a pool half a leg behind the middle."""
    return _start(packed, -POOL_LEG_M / 2.0 if packed.context.walls else 0.0)


def _leg_sign(packed: PackedVehicle, speed_mps: float) -> Callable[[float], float]:
    """1 for ahead, in a pool by turns 1 and -1, a leg each."""
    if not packed.context.walls or speed_mps <= 0.0:
        return lambda _t: 1.0
    leg_s = POOL_LEG_M / speed_mps
    return lambda t: 1.0 if int(t / leg_s) % 2 == 0 else -1.0


def _level_roll(packed: PackedVehicle) -> float | None:
    """Roll to hold: 0 where the thrusters can make a roll moment, else left to the righting one."""
    return 0.0 if reach_alone(packed)[3] > 0.0 else None


def _level_hold(packed: PackedVehicle) -> Setpoint:
    return Setpoint(None, _depth(packed), 0.0, 0.0, _level_roll(packed))


def _under_autopilot(
    packed: PackedVehicle,
    reference: Callable[[float], Setpoint],
    duration_s: float,
    start: FloatArray | None = None,
) -> FlightPlan:
    """Fly references; depth, pitch and roll are held where the reference leaves them open."""
    depth, roll = _depth(packed), _level_roll(packed)

    def complete(t: float) -> Setpoint:
        wanted = reference(t)
        return replace(
            wanted,
            depth_m=depth if wanted.depth_m is None else depth + wanted.depth_m,
            pitch_rad=0.0 if wanted.pitch_rad is None else wanted.pitch_rad,
            roll_rad=roll,
        )

    begin = _start(packed) if start is None else start
    return FlightPlan(duration_s, reference=complete, start=begin)


def _hover(packed: PackedVehicle, _amplitude: float, duration_s: float) -> FlightPlan:
    return _under_autopilot(packed, lambda _t: Setpoint(0.0, heading_rad=0.0), duration_s)


def _straight(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    speed = _speed(packed, amplitude)
    sign = _leg_sign(packed, speed)
    return _under_autopilot(
        packed,
        lambda t: Setpoint(speed * sign(t), heading_rad=0.0),
        duration_s,
        _start_of_leg(packed),
    )


def _surge_steps(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    speed = _speed(packed, amplitude)
    sign = _leg_sign(packed, speed)
    levels = (0.0, 0.5, 1.0, 0.25, 0.75, 0.0)

    def reference(t: float) -> Setpoint:
        level = levels[min(int(t / duration_s * 6), 5)]
        return Setpoint(speed * level * sign(t), heading_rad=0.0)

    return _under_autopilot(packed, reference, duration_s, _start_of_leg(packed))


def _surge_ramp(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    """Open loop: force rises along a line, then is cut off (coast-down); in a pool to and fro."""
    force = 0.5 * amplitude * reach_alone(packed)[0]
    period = min(duration_s, 15.0) if packed.context.walls else duration_s

    def wrench(t: float) -> FloatArray:
        now = t % period
        share = float(ramp(np.array([now]), 0.05 * period, 0.6 * period)[0])
        sign = 1.0 if int(t / period) % 2 == 0 else -1.0
        return np.array([sign * force * share if now < 0.75 * period else 0.0, 0, 0, 0, 0, 0])

    keep = _level_hold(packed)
    return FlightPlan(
        duration_s, reference=lambda _t: keep, wrench=wrench, start=_start_of_leg(packed)
    )


def _zig_zag(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    speed, swing = _speed(packed, 1.0), np.radians(20.0) * amplitude
    sign = _leg_sign(packed, speed)
    period = 20.0

    def reference(t: float) -> Setpoint:
        side = 1.0 if (t // period) % 2 == 0 else -1.0
        return Setpoint(speed * sign(t), heading_rad=swing * side if t > 5.0 else 0.0)

    return _under_autopilot(packed, reference, duration_s, _start_of_leg(packed))


def _turning(packed: PackedVehicle, usual_rate: float) -> tuple[float, float, FloatArray]:
    """Speed [m/s], yaw rate [rad/s] and start of a turn; in a pool slow and tight."""
    speed = _speed(packed, 1.0)
    if not packed.context.walls:
        return speed, usual_rate, _start(packed)
    speed *= 0.5
    return speed, max(usual_rate, speed / POOL_RADIUS_M), _start(packed, 0.0, -POOL_RADIUS_M)


def _circle(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    speed, rate, start = _turning(packed, np.radians(9.0))
    straight = 2.0 if packed.context.walls else 10.0
    return _under_autopilot(
        packed,
        lambda t: Setpoint(speed, heading_rad=amplitude * rate * max(t - straight, 0.0)),
        duration_s,
        start,
    )


def _spiral(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    """Turn at rates that grow step by step, then the other way (Dieudonne)."""
    speed, rate, start = _turning(packed, np.radians(15.0))
    rate *= amplitude
    levels = np.array([0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5])
    if packed.context.walls:
        # no straight part: it would end at the wall
        levels = np.array([1.0, 0.75, 1.25, 1.0, -1.0, -0.75, -1.25, -1.0])
    hold = duration_s / levels.size
    edges = np.concatenate([[0.0], np.cumsum(levels) * hold * rate])

    def reference(t: float) -> Setpoint:
        k = min(int(t / hold), levels.size - 1)
        heading = float(edges[k] + levels[k] * rate * (t - k * hold))
        return Setpoint(speed, heading_rad=heading)

    return _under_autopilot(packed, reference, duration_s, start)


def _heave_steps(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    levels = (0.0, 1.0, 0.0, 2.0, 0.5, 0.0)
    size = amplitude * (0.5 if packed.context.walls else 1.0)
    return _under_autopilot(
        packed,
        lambda t: Setpoint(0.0, size * levels[min(int(t / duration_s * 6), 5)], 0.0),
        duration_s,
    )


def _pitch_steps(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    speed, roll = _speed(packed, 0.7), _level_roll(packed)
    # in open water depth is left alone: the vehicle climbs and dives with its pitch
    held = _depth(packed) if packed.context.walls else None
    sign = _leg_sign(packed, speed)
    levels = (0.0, 1.0, 0.0, -1.0, 0.5, 0.0)

    def reference(t: float) -> Setpoint:
        angle = np.radians(8.0) * amplitude * levels[min(int(t / duration_s * 6), 5)]
        return Setpoint(speed * sign(t), held, 0.0, float(angle), roll)

    return FlightPlan(duration_s, reference=reference, start=_start_of_leg(packed))


def _excitation(
    signal: Callable[[FloatArray, int], FloatArray],
) -> Callable[[PackedVehicle, float, float], FlightPlan]:
    """Open-loop force and moments along every axis that can be pushed, about a level hold."""

    def plan(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
        room = POOL_EXCITATION if packed.context.walls else 1.0
        reach = 0.35 * room * amplitude * gentle_reach(packed)
        time_s = np.arange(0.0, duration_s + 1.0, 0.1)
        table = np.stack([reach[axis] * signal(time_s, axis) for axis in range(6)], axis=1)
        if packed.context.walls:
            table = table - table[: max(round(duration_s / 0.1), 1)].mean(axis=0)
        keep = _level_hold(packed)
        return FlightPlan(
            duration_s,
            reference=lambda _t: keep,
            wrench=lambda t: table[min(int(t / 0.1 + 0.5), len(table) - 1)],
            start=_start(packed),
        )

    return plan


def _free_decay(packed: PackedVehicle, amplitude: float, duration_s: float) -> FlightPlan:
    """Released with roll, pitch and velocity; no command at all."""
    # a pool is shallow and a vehicle may be heavy
    depth = 0.8 * _depth(packed) if packed.context.walls else _depth(packed)
    start = initial_state(
        position_ned_m=(0.0, 0.0, depth),
        attitude_rad=(0.25 * amplitude, 0.15 * amplitude, 0.0),
        nu=(0.8 * amplitude, 0.2 * amplitude, 0.1 * amplitude, 0.0, 0.0, 0.2 * amplitude),
    )
    return FlightPlan(duration_s, start=start)


MANOEUVRES: dict[str, Manoeuvre] = {
    m.name: m
    for m in (
        Manoeuvre("hover", "hold depth and heading at rest", 60.0, _hover, ("heave",)),
        Manoeuvre("straight", "run ahead at one speed", 60.0, _straight, ("surge",)),
        Manoeuvre("surge_steps", "steps of surge speed", 120.0, _surge_steps, ("surge",)),
        Manoeuvre("surge_ramp", "rising surge force, then coasting", 90.0, _surge_ramp, ("surge",)),
        Manoeuvre(
            "zig_zag", "heading steps to both sides under way", 120.0, _zig_zag, ("surge", "yaw")
        ),
        Manoeuvre("circle", "turn at a constant rate under way", 90.0, _circle, ("surge", "yaw")),
        Manoeuvre("spiral", "turns of growing rate, both ways", 160.0, _spiral, ("surge", "yaw")),
        Manoeuvre("heave_steps", "steps of depth at rest", 120.0, _heave_steps, ("heave",)),
        Manoeuvre(
            "pitch_steps", "steps of pitch under way", 90.0, _pitch_steps, ("surge", "pitch")
        ),
        Manoeuvre(
            "multisine",
            "sines along every axis, open loop",
            120.0,
            _excitation(lambda t, axis: multisine(t, 0.02 + 0.004 * axis, 0.4 + 0.01 * axis, 14)),
            ANY_AXIS,
        ),
        Manoeuvre(
            "chirp",
            "rising frequency along every axis, open loop",
            120.0,
            _excitation(lambda t, axis: chirp(t, 0.01 + 0.002 * axis, 0.5)),
            ANY_AXIS,
        ),
        Manoeuvre(
            "prbs",
            "pseudo-random steps along every axis, open loop",
            120.0,
            _excitation(lambda t, axis: prbs(t, 1.5, 61 * axis)),
            ANY_AXIS,
        ),
        Manoeuvre("free_decay", "released and left alone", 60.0, _free_decay),
    )
}
