"""Fly a manoeuvre: open loop, or under the autopilot, through an allocator."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from math import atan2, pi, remainder, sqrt
from typing import NamedTuple, Protocol

import numpy as np

from pipeline.control.allocation import beyond_dead_zone
from pipeline.control.autopilot import Autopilot, Design, MeasuredState, Setpoint
from pipeline.control.bounded_allocation import GeneralAllocator
from pipeline.physics.parameters import read, write
from pipeline.simulate.applied_wrench import settled_thrust
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.simulate.run import Mover, Trajectory, initial_state, largest_step_s, run
from pipeline.types import FloatArray

#: Period of the autopilot and of the commands. [s]
CONTROL_PERIOD_S = 0.1
STEP_S = 0.02


class FlightChange(Protocol):
    """Something that happens to the vehicle in flight."""

    def __call__(self, time_s: float, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """State and true parameter vector from this time on."""
        ...


class CodeAllocator(Protocol):
    """Turns a wrench demand into codes."""

    def decide(
        self, demand: FloatArray, nu_relative: FloatArray
    ) -> tuple[FloatArray, FloatArray, bool]:
        """Codes (n,), wanted thrusts (n,) [N], and whether a limit cut the demand (6,)."""
        ...


@dataclass(frozen=True)
class FlightPlan:
    """What is flown: references for the autopilot, a wrench added to them, or both.

    `reference` and `wrench` are functions of time; `wrench` (6,) is in newtons and newton metres,
    body axes. `start` is the kernel state at time zero.
    """

    duration_s: float
    reference: Callable[[float], Setpoint] | None = None
    wrench: Callable[[float], FloatArray] | None = None
    start: FloatArray | None = None


def general_allocator(packed: PackedVehicle) -> GeneralAllocator:
    """Allocator of the nominal vehicle: it believes the vehicle file, whatever the truth is."""
    count = len(packed.thruster_names)
    vector = packed.vector
    kinds = read(vector, "thruster_type")[:count].astype(int)
    fractions = read(vector, "inflow_fraction")[:count]
    ahead = read(vector, "thrust_gain")[:count]
    gains = np.stack([ahead, ahead * read(vector, "reverse_gain")[:count]])
    lost, code_max = (read(vector, slot)[:count] for slot in ("dead_zone", "code_max"))
    tables, steps = packed.thrust_tables, packed.steps
    codes = np.arange(tables.shape[3])

    def code_from_thrust(thrust_n: FloatArray, inflow_mps: FloatArray) -> FloatArray:
        out = np.zeros(count)
        for i in range(count):
            side = 0 if thrust_n[i] >= 0 else 1
            along = max(float(inflow_mps[i]) * (1 if side == 0 else -1), 0.0) * fractions[i]
            row = min(along / steps[kinds[i], 0], tables.shape[2] - 1.0)
            low = min(int(row), max(tables.shape[2] - 2, 0))
            share = row - low
            high = min(low + 1, tables.shape[2] - 1)
            curve = (1 - share) * tables[kinds[i], side, low] + share * tables[kinds[i], side, high]
            curve = max(gains[side, i], 1e-9) * curve
            first = max(int(np.argmax(curve > 0)) - 1, 0)
            limit = packed.code_limits[i, 1] if side == 0 else -packed.code_limits[i, 0]
            size = np.interp(abs(thrust_n[i]), curve[first:], codes[first:] * steps[kinds[i], 1])
            # round-off of the allocation is no demand: it would sit at the edge of the dead zone
            if abs(thrust_n[i]) > 1e-9 * curve[-1]:
                out[i] = min(float(size), limit) * (1 if side == 0 else -1)
        return np.round(beyond_dead_zone(out, lost, code_max))

    ends, at_rest = packed.code_limits.T, np.zeros(count)
    # a drive that gives no thrust that way has the limit of one that does: its share of a demand is
    # left out, for scaled by what it can give nothing would be left of any demand
    free = replace(packed, vector=vector.copy())
    write(free.vector, "code_min", -read(vector, "code_max"))
    own = np.abs(settled_thrust(packed, ends, at_rest))
    other = np.abs(settled_thrust(free, np.stack([-ends[1], ends[1]]), at_rest))
    smallest, largest = np.maximum(np.where(own > 0.0, own, other), 1e-9)
    return GeneralAllocator(
        position_m=read(vector, "thruster_position")[:count],
        direction=read(vector, "thruster_direction")[:count],
        largest_n=largest,
        smallest_n=-smallest,
        code_from_thrust=code_from_thrust,
    )


def autopilot_for(packed: PackedVehicle) -> Autopilot:
    """Autopilot whose gains follow from the nominal vehicle's inertia and damping."""
    vector = packed.vector
    matrix = mass_of(vector)
    added = read(vector, "added_mass")
    share = float(read(vector, "coriolis_fraction"))
    # M = c u w and N = c u v of Munk and lift ahead; an angle of attack alpha is w / u, and turning
    # the nose to starboard of the course by psi gives v = -u psi
    pitch = share * (added[2, 2] - added[0, 0]) + float(read(vector, "pitch_lift_slope"))
    yaw = share * (added[1, 1] - added[0, 0]) - float(read(vector, "yaw_lift_slope"))
    return Autopilot(
        Design(
            surge_mass_kg=float(matrix[0, 0]),
            heave_mass_kg=float(matrix[2, 2]),
            pitch_inertia_kgm2=float(matrix[4, 4]),
            yaw_inertia_kgm2=float(matrix[5, 5]),
            surge_linear=float(read(vector, "linear_damping")[0, 0]),
            surge_quadratic=float(read(vector, "quadratic_damping")[0]),
            roll_inertia_kgm2=float(matrix[3, 3]),
            pitch_upset_kg=max(float(pitch), 0.0),
            yaw_upset_kg=max(float(yaw), 0.0),
        )
    )


def motion_of(state: FloatArray) -> MeasuredState:
    """Tell the autopilot what a perfect sensor suite would of a kernel state."""
    # written out, for one attitude: asked of SciPy it takes 40 times as long, a fifth of a flight
    w, x, y, z = state[3:7].tolist()
    size = sqrt(x * x + y * y + z * z + w * w)
    w, x, y, z = w / size, x / size, y / size, z / size
    u_mps, v_mps, w_mps = state[7:10].tolist()
    half_sum, half_difference = atan2(x + z, w - y), atan2(z - x, w + y)
    pitch = 2.0 * atan2(np.hypot(w + y, z - x), np.hypot(w - y, x + z)) - 0.5 * pi
    return MeasuredState(
        surge_mps=float(state[7]),
        depth_m=float(state[2]),
        depth_rate_mps=2.0 * ((x * z - y * w) * u_mps + (y * z + x * w) * v_mps)
        + (w * w - x * x - y * y + z * z) * w_mps,
        heading_rad=remainder(half_sum + half_difference, 2.0 * pi),
        pitch_rad=pitch,
        pitch_rate_radps=float(state[11]),
        yaw_rate_radps=float(state[12]),
        roll_rad=remainder(half_sum - half_difference, 2.0 * pi),
        roll_rate_radps=float(state[10]),
    )


class Period(NamedTuple):
    """A control period: the state and demand that it begins with, what follows, how it went."""

    state: FloatArray
    demand: FloatArray
    codes: FloatArray
    wanted_n: FloatArray
    cut: bool
    flown: Trajectory


def fly(
    packed: PackedVehicle,
    plan: FlightPlan,
    *,
    vector: FloatArray | None = None,
    allocator: CodeAllocator | None = None,
    step_s: float | None = None,
    change: FlightChange | None = None,
    mover: Mover = run,
    watch: Callable[[Period], object] = lambda _: None,
) -> Trajectory:
    """Fly a plan and return the whole run.

    Autopilot and allocator (`general_allocator` otherwise) believe `packed`; `vector` is the truth,
    e.g. with effects switched on. `step_s` [s] divides the control period, `usual_step_s`
    otherwise. `change` is asked at the start of every control period, its vector takes the place of
    `vector`, and the autopilot is not told. `mover` moves the vehicle from command to command:
    `run`, or the vehicle on its tether. `watch` is shown every period.

    Raises
    ------
    CannotComputeError
        As `run` does.
    """
    allocate = general_allocator(packed) if allocator is None else allocator
    autopilot = autopilot_for(packed)
    step_s = usual_step_s(packed, vector) if step_s is None else step_s
    inner = max(round(CONTROL_PERIOD_S / step_s), 1)
    state = initial_state() if plan.start is None else plan.start
    pieces: list[Trajectory] = []
    saturated = False
    for k in range(round(plan.duration_s / CONTROL_PERIOD_S)):
        now = k * CONTROL_PERIOD_S
        if change is not None:
            state, vector = change(now, state)
        demand = np.zeros(6)
        if plan.reference is not None:
            demand, autopilot = autopilot.step(
                motion_of(state), plan.reference(now), CONTROL_PERIOD_S, saturated=saturated
            )
        if plan.wrench is not None:
            demand = demand + plan.wrench(now)
        codes, wanted_n, saturated = allocate.decide(demand, state[7:13])
        piece = mover(
            packed,
            np.tile(codes, (inner, 1)),
            dt_s=CONTROL_PERIOD_S / inner,
            vector=vector,
            start=state,
            start_time_s=now,
        )
        watch(Period(state, demand, codes, wanted_n, saturated, piece))
        pieces.append(piece)
        state = piece.final_state
    return join(pieces)


def usual_step_s(packed: PackedVehicle, vector: FloatArray | None = None) -> float:
    """Integration step [s]: 0.02 s, or the next that the shafts allow and that divides 0.1 s."""
    parts = np.ceil(CONTROL_PERIOD_S / largest_step_s(packed, vector) - 1e-9)
    return float(CONTROL_PERIOD_S / max(parts, round(CONTROL_PERIOD_S / STEP_S)))


def run_changing(
    packed: PackedVehicle,
    commands: FloatArray,
    change: FlightChange,
    at_s: Sequence[float],
    *,
    dt_s: float,
    start: FloatArray | None = None,
    mover: Mover = run,
) -> Trajectory:
    """Run commands open loop while something happens to the vehicle.

    `packed`, `commands`, `dt_s`, `start` are as `run` takes them, `mover` as `fly` does. `change`
    is asked at the start and at the times `at_s` [s], each moved to the next step; the sample there
    is that of just after.
    """
    edges = sorted({min(int(np.ceil(t / dt_s - 1e-9)), len(commands)) for t in at_s} | {0})
    state = initial_state() if start is None else start
    pieces: list[Trajectory] = []
    for begin, end in zip(edges, [*edges[1:], len(commands)], strict=True):
        state, vector = change(begin * dt_s, state)
        if begin == end:
            continue
        pieces.append(
            mover(
                packed,
                commands[begin:end],
                dt_s=dt_s,
                vector=vector,
                start=state,
                start_time_s=begin * dt_s,
            )
        )
        state = pieces[-1].final_state
    return join(pieces)


def join(pieces: list[Trajectory]) -> Trajectory:
    """Put consecutive trajectories together; the shared samples are kept once."""
    names = [one.name for one in fields(Trajectory) if one.name != "final_state"]
    return Trajectory(**stacked(pieces, names), final_state=pieces[-1].final_state)


def stacked(pieces: Sequence[object], names: Sequence[str]) -> dict[str, FloatArray]:
    """Put arrays of consecutive pieces together, of which each ends where the next begins."""

    def stack(name: str) -> FloatArray:
        parts = [getattr(piece, name)[:-1] for piece in pieces[:-1]]
        return np.concatenate([*parts, getattr(pieces[-1], name)])

    return {name: stack(name) for name in names}
