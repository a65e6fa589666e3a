"""One flight: autopilot, allocator and compiled kernel in a loop, everything of it kept."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from pipeline.control.autopilot import Autopilot, Setpoint
from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import inflow_speed, levers
from pipeline.simulate.fly import CONTROL_PERIOD_S, motion_of, usual_step_s
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import initial_state, run
from pipeline.types import BoolArray, FloatArray

#: Depth that is kept, far from the surface. [m]
DEPTH_M = 10.0


class Decide(Protocol):
    """An allocator that also tells which thrusts it means."""

    def decide(
        self, demand: FloatArray, nu_relative: FloatArray
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Codes (n,), wanted thrusts (n,) [N], and whether a limit cut the demand (6,)."""
        ...


@dataclass(frozen=True)
class Course:
    """What is to be kept, and what disturbs it: functions of time.

    `disturbance` gives force [N] and moment [N m] on the body, (6,).
    """

    speed_mps: float
    duration_s: float
    disturbance: Callable[[float], FloatArray]
    heading_rad: float = 0.0
    depth_m: float = 0.0
    """Steps at `step_s`, from heading and depth at the start."""
    step_s: float = 0.0
    roll_rad: float | None = None

    def reference(self, time_s: float) -> Setpoint:
        """Return what the autopilot is told."""
        stepped = time_s >= self.step_s
        return Setpoint(
            self.speed_mps,
            DEPTH_M + (self.depth_m if stepped else 0.0),
            self.heading_rad if stepped else 0.0,
            0.0,
            self.roll_rad,
        )


@dataclass(frozen=True)
class Flight:
    """A flight, a row for each control period.

    `motion` (k, 4): surge speed [m/s], depth [m], heading, pitch [rad] at the start of a period;
    `reference` (k, 4) likewise; `demand` (k, 6) of the autopilot; `wanted_n`, `codes`, `actuator`
    (effective code), `inflow_mps` (k, n); `thrust_n` (k, n) at the end of a period; `cut` (k,).
    """

    course: Course
    motion: FloatArray
    reference: FloatArray
    demand: FloatArray
    wanted_n: FloatArray
    codes: FloatArray
    actuator: FloatArray
    inflow_mps: FloatArray
    thrust_n: FloatArray
    cut: BoolArray

    @property
    def time_s(self) -> FloatArray:
        """Time of the rows (k,). [s]."""
        return CONTROL_PERIOD_S * np.arange(len(self.motion), dtype=np.float64)


def fly_course(
    packed: PackedVehicle, autopilot: Autopilot, allocator: Decide | None, course: Course
) -> Flight:
    """Fly a course from its speed, thrusters at what the allocator asks for the drag there.

    The true vehicle with a fresh autopilot, the same for every flight. Without an allocator the
    wanted wrench itself acts on the body: ideal thrusters.

    Raises
    ------
    CannotComputeError
        As `run` does.
    """
    count = len(packed.thruster_names)
    if allocator is None:  # ideal thrusters do not drag
        packed = replace(packed, thrust_tables=np.zeros_like(packed.thrust_tables))
    steps = round(course.duration_s / CONTROL_PERIOD_S)
    inner = round(CONTROL_PERIOD_S / usual_step_s(packed))
    state = _start(packed, autopilot, allocator, course)
    kept = {
        "motion": np.zeros((steps, 4)),
        "reference": np.zeros((steps, 4)),
        "demand": np.zeros((steps, 6)),
        "wanted_n": np.zeros((steps, count)),
        "codes": np.zeros((steps, count)),
        "actuator": np.zeros((steps, count)),
        "thrust_n": np.zeros((steps, count)),
    }
    nu = np.zeros((steps, 6))
    cuts = np.zeros(steps, dtype=np.bool_)
    cut = False
    for k in range(steps):
        now = k * CONTROL_PERIOD_S
        motion, wanted = motion_of(state), course.reference(now)
        demand, autopilot = autopilot.step(motion, wanted, CONTROL_PERIOD_S, saturated=cut)
        outside = course.disturbance(now)
        if allocator is None:
            codes, thrust, cut = np.zeros(count), np.zeros(count), False
            outside = outside + demand
        else:
            codes, thrust, cut = allocator.decide(demand, state[7:13])
        nu[k], cuts[k] = state[7:13], cut
        row = (motion.surge_mps, motion.depth_m, motion.heading_rad, motion.pitch_rad)
        kept["motion"][k] = row
        kept["reference"][k] = [
            wanted.surge_mps or 0.0,
            wanted.depth_m or 0.0,
            wanted.heading_rad or 0.0,
            wanted.pitch_rad or 0.0,
        ]
        kept["demand"][k], kept["wanted_n"][k], kept["codes"][k] = demand, thrust, codes
        piece = run(
            packed,
            np.broadcast_to(codes, (inner, count)),
            dt_s=CONTROL_PERIOD_S / inner,
            start=state,
            external=outside[None, :],
            start_time_s=now,
        )
        kept["actuator"][k], kept["thrust_n"][k] = piece.actuator[-1], piece.thrust_n[-1]
        state = piece.final_state
    return Flight(course=course, inflow_mps=inflow_speed(packed, nu), cut=cuts, **kept)


def _start(
    packed: PackedVehicle, autopilot: Autopilot, allocator: Decide | None, course: Course
) -> FloatArray:
    """Kernel state under way, actuators where the first demand puts them."""
    nu = (course.speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0)
    state = initial_state(position_ned_m=(0.0, 0.0, DEPTH_M), nu=nu)
    if allocator is None:
        return state
    level = Setpoint(course.speed_mps, DEPTH_M, 0.0, 0.0, course.roll_rad)
    demand, _ = autopilot.step(motion_of(state), level, CONTROL_PERIOD_S)
    codes, _, _ = allocator.decide(demand, state[7:13])
    count = len(codes)
    kinds = read(packed.vector, "thruster_type")[:count].astype(int)
    in_time = read(packed.vector, "rotor_inertia")[:count] > 0.0
    share = read(packed.vector, "inflow_fraction")[:count]
    inflow = share * inflow_speed(packed, state[None, 7:13])[0]
    for i in range(count):
        state[BODY + i] = codes[i]
        if in_time[i]:
            along = np.maximum(np.sign(codes[i : i + 1]) * inflow[i], 0.0)
            rpm = packed.shaft_speed(int(kinds[i]), np.abs(codes[i : i + 1]), along)
            state[BODY + i] = np.sign(codes[i]) * float(rpm[0]) / 60.0
    return state


def effective_codes(packed: PackedVehicle, flight: Flight) -> FloatArray:
    """Codes (k, n) that the power follows: behind the lag, or commanded where shafts are solved."""
    count = flight.codes.shape[1]
    in_time = read(packed.vector, "rotor_inertia")[:count] > 0.0
    return np.asarray(np.where(in_time[None, :], flight.codes, flight.actuator))


def wrench_of(packed: PackedVehicle, thrust_n: FloatArray) -> FloatArray:
    """Surge, heave, pitch and yaw (k, 4) of thrusts (k, n). [N], [N m]."""
    return np.asarray((thrust_n @ levers(packed).T)[:, AXIS_ROWS])


#: Rows of a wrench that `AXES` of the record names.
AXIS_ROWS = (0, 2, 4, 5)
