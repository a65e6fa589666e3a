"""One flight: autopilot, allocator and compiled kernel in a loop, everything of it kept."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.control.autopilot import Setpoint
from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import inflow_speed, levers
from pipeline.simulate.fly import (
    CONTROL_PERIOD_S,
    CodeAllocator,
    FlightPlan,
    Period,
    autopilot_for,
    fly,
    motion_of,
)
from pipeline.simulate.kernel import BODY
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory, initial_state, run
from pipeline.types import BoolArray, FloatArray

#: Depth that is kept, far from the surface. [m]
DEPTH_M = 10.0


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


def fly_course(packed: PackedVehicle, allocator: CodeAllocator | None, course: Course) -> Flight:
    """Fly a course from its speed, thrusters at what the allocator asks for the drag there.

    The true vehicle with a fresh autopilot, the same for every flight. Without an allocator the
    wanted wrench itself acts on the body: ideal thrusters.

    Raises
    ------
    CannotComputeError
        As `run` does.
    """
    if allocator is None:  # ideal thrusters do not drag
        packed = replace(packed, thrust_tables=np.zeros_like(packed.thrust_tables))
    ideal = _Ideal(len(packed.thruster_names))

    def moved(
        packed: PackedVehicle,
        commands: FloatArray,
        *,
        dt_s: float,
        vector: FloatArray | None = None,
        start: FloatArray | None = None,
        start_time_s: float = 0.0,
    ) -> Trajectory:
        return run(
            packed,
            commands,
            dt_s=dt_s,
            vector=vector,
            start=start,
            start_time_s=start_time_s,
            external=(course.disturbance(start_time_s) + ideal.demand)[None],
        )

    kept: list[Period] = []
    plan = FlightPlan(course.duration_s, course.reference, start=_start(packed, allocator, course))
    fly(packed, plan, allocator=allocator or ideal, mover=moved, watch=kept.append)
    seen = [motion_of(one.state) for one in kept]
    told = [course.reference(k * CONTROL_PERIOD_S) for k in range(len(kept))]
    return Flight(
        course=course,
        motion=np.array([(m.surge_mps, m.depth_m, m.heading_rad, m.pitch_rad) for m in seen]),
        reference=np.array(
            [[r.surge_mps, r.depth_m, r.heading_rad, r.pitch_rad] for r in told], float
        ),
        demand=np.array([one.demand for one in kept]),
        wanted_n=np.array([one.wanted_n for one in kept]),
        codes=np.array([one.codes for one in kept]),
        actuator=np.array([one.flown.actuator[-1] for one in kept]),
        inflow_mps=inflow_speed(packed, np.array([one.state[7:13] for one in kept])),
        thrust_n=np.array([one.flown.thrust_n[-1] for one in kept]),
        cut=np.array([one.cut for one in kept]),
    )


@dataclass
class _Ideal:
    """Thrusters that give what is asked: codes of none, the demand acts on the body itself."""

    count: int
    demand: FloatArray = field(default_factory=lambda: np.zeros(6))

    def decide(
        self, demand: FloatArray, nu_relative: FloatArray
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Keep the demand."""
        del nu_relative
        self.demand = demand
        return np.zeros(self.count), np.zeros(self.count), False


def _start(packed: PackedVehicle, allocator: CodeAllocator | None, course: Course) -> FloatArray:
    """Kernel state under way, actuators where the first demand puts them."""
    nu = (course.speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0)
    state = initial_state(position_ned_m=(0.0, 0.0, DEPTH_M), nu=nu)
    if allocator is None:
        return state
    level = Setpoint(course.speed_mps, DEPTH_M, 0.0, 0.0, course.roll_rad)
    demand, _ = autopilot_for(packed).step(motion_of(state), level, CONTROL_PERIOD_S)
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
