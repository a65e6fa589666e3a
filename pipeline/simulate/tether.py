"""A tether of lumped masses: description, state, what a run gives, and the kernel's arrays of it.

It hangs at rest and moves with the vehicle in `tethered`; the equations are in `kernel_tether`.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.winch import Winch
from pipeline.simulate import kernel_swing as kernel
from pipeline.simulate.kernel_tether import MOST_SUBSTEPS, WINCH_SIZE
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.attachment_schema import Tether

#: Nodes that a cable has room for at most: every step of a run keeps the place of each.
MOST_NODES = 20000


@dataclass(frozen=True)
class LumpedMassTether:
    """A cable cut into segments, and the water it is in; checked where the vehicle file is.

    `length_m` is paid out at the start [m], in `segments` whose length stays: a winch changes their
    number. Drag coefficients C_n, C_t are referred to the diameter; `axial_stiffness_n` is EA [N];
    `density_kgpm3` of the water, 0 for a vacuum; `added_mass` C_a across the cable, 1 for a
    cylinder in unbounded water; `axial_damping` the damping ratio of the shortest axial wave, two
    segments long: longer waves are damped less, in proportion to their frequency.
    """

    length_m: float
    segments: int
    diameter_m: float
    mass_kgpm: float
    normal_drag: float
    tangential_drag: float
    axial_stiffness_n: float
    density_kgpm3: float
    gravity_mps2: float
    added_mass: float = 1.0
    axial_damping: float = 0.5

    @property
    def segment_m(self) -> float:
        """Unstretched length of a segment. [m]."""
        return self.length_m / self.segments

    @property
    def wet_weight_npm(self) -> float:
        """Weight less buoyancy of a metre; negative floats. [N/m]."""
        section = np.pi / 4 * self.diameter_m**2
        return float(self.gravity_mps2 * (self.mass_kgpm - self.density_kgpm3 * section))

    @property
    def wave_speed_mps(self) -> float:
        """Speed of an axial wave, (EA / m)^(1/2). [m/s]."""
        return float(np.sqrt(self.axial_stiffness_n / self.mass_kgpm))

    def numbers(self, current_mps: FloatArray) -> FloatArray:
        """Return the kernel's vector for this cable in a current (3,)."""
        half = 0.5 * self.density_kgpm3 * self.diameter_m
        section = np.pi / 4 * self.diameter_m**2
        return np.array(
            [
                self.mass_kgpm,
                self.wet_weight_npm,
                half * self.normal_drag,
                half * self.tangential_drag,
                self.axial_stiffness_n,
                self.axial_damping * np.sqrt(self.axial_stiffness_n * self.mass_kgpm),
                self.added_mass * self.density_kgpm3 * section,
                self.segment_m,
                *current_mps,
            ]
        )


def lumped_tether(tether: Tether, *, density_kgpm3: float, gravity_mps2: float) -> LumpedMassTether:
    """Return the lumped cable of a vehicle file's tether section, whose mass is in air."""
    # named as in the file, but for the water and what the file does not state
    own = {one.name for one in fields(LumpedMassTether)}
    stated = tether.model_dump(include=own)
    return LumpedMassTether(**stated, density_kgpm3=density_kgpm3, gravity_mps2=gravity_mps2)


@dataclass(frozen=True)
class TetherState:
    """Where a tether is and how it moves; n segments in use, from the top down.

    Nodes at `position_ned_m` with `velocity_ned_mps` (n + 1, 3) [m, m/s], segments of unstretched
    lengths `rest_length_m` (n,) [m]; `drum_speed_radps` of the winch, positive pays out [rad/s];
    `owed_m` was put off when a node was taken out, and is given back within seconds [m].
    """

    position_ned_m: FloatArray
    velocity_ned_mps: FloatArray
    rest_length_m: FloatArray
    drum_speed_radps: float = 0.0
    owed_m: float = 0.0

    @property
    def paid_out_m(self) -> float:
        """Unstretched length between winch and vehicle. [m]."""
        return float(self.rest_length_m.sum() + self.owed_m)


@dataclass(frozen=True)
class TetherHistory:
    """A tether's run, sampled at every step, m + 1 samples.

    Nodes beyond those in use are NaN; with a winch the top stays node 0 and the lower end is node
    ``segments[k]``. `position_ned_m` (m + 1, nodes, 3) [m]; `tension_n` (m + 1, nodes - 1) of the
    segments [N]; `force_on_top_ned_n`, `force_below_ned_n` (m + 1, 3) of the cable on the bodies at
    its ends, tension with weight and drag of the half segment, without its inertia [N];
    `wrench_on_vehicle` (m + 1, 6) all that the tether does to the vehicle, inertia of the half
    segment included, body axes, about the body origin, zeros without a vehicle [N, N m]; `segments`
    in use, `paid_out_m`, `drum_speed_radps`, and `substeps` of the step that begins at the sample,
    (m + 1,). `final` is to go on from.
    """

    time_s: FloatArray
    position_ned_m: FloatArray
    tension_n: FloatArray
    force_on_top_ned_n: FloatArray
    force_below_ned_n: FloatArray
    wrench_on_vehicle: FloatArray
    segments: FloatArray
    paid_out_m: FloatArray
    drum_speed_radps: FloatArray
    substeps: FloatArray
    final: TetherState

    @property
    def top_tension_n(self) -> FloatArray:
        """Tension of the top segment, shape (m + 1,). [N]."""
        return np.asarray(self.tension_n[:, 0], dtype=float)

    @property
    def lower_tension_n(self) -> FloatArray:
        """Tension of the lowest segment, shape (m + 1,). [N]."""
        rows = np.arange(len(self.time_s))
        return np.asarray(self.tension_n[rows, self.segments.astype(int) - 1], dtype=float)


class Prepared(NamedTuple):
    """What the kernel takes of a tether, in its order; the last four are its state, changed."""

    cable: FloatArray
    winch: FloatArray
    commands: FloatArray
    place: FloatArray
    speed: FloatArray
    rest: FloatArray
    carried: FloatArray


class TetherRecord(NamedTuple):
    """What the kernel fills of a tether's run, in its order."""

    place: FloatArray
    tension: FloatArray
    ends: FloatArray
    logs: FloatArray

    @classmethod
    def empty(cls, steps: int, room: int) -> Self:
        """Arrays for a number of steps and nodes."""
        return cls(
            place=np.empty((steps + 1, room, 3)),
            tension=np.empty((steps + 1, room - 1)),
            ends=np.empty((steps + 1, 2, 3)),
            logs=np.empty((steps + 1, 4)),
        )


def prepare(
    tether: LumpedMassTether,
    state: TetherState,
    *,
    current_mps: FloatArray,
    winch: Winch | None = None,
    winch_command: ArrayLike = 0.0,
) -> Prepared:
    """Return the kernel's arrays; arguments as of `fly_tethered`."""
    commands = np.atleast_1d(np.asarray(winch_command, float))
    numbers, most = np.zeros(WINCH_SIZE), state.paid_out_m
    if winch is not None:
        numbers, most = winch.numbers(), max(winch.longest_m, most)
        if not most / tether.segment_m < MOST_NODES - 4:
            raise CannotComputeError(
                f"The winch pays out up to {most:g} m, which is {most / tether.segment_m:.4g} of "
                f"the tether's segments of {tether.segment_m:g} m; there is room for "
                f"{MOST_NODES - 5}.\nState a shorter longest_m of the winch, or fewer segments."
            )
    count = len(state.rest_length_m)
    room = max(int(np.ceil(most / tether.segment_m)) + 4, count + 1) if winch else count + 1
    place, speed, rest = np.zeros((room, 3)), np.zeros((room, 3)), np.ones(room - 1)
    place[: count + 1] = state.position_ned_m
    speed[: count + 1] = state.velocity_ned_mps
    rest[:count] = state.rest_length_m
    return Prepared(
        cable=tether.numbers(np.asarray(current_mps, float)),
        winch=numbers,
        commands=commands,
        place=place,
        speed=speed,
        rest=rest,
        carried=np.array([count, state.drum_speed_radps, state.owed_m]),
    )


def history(
    record: TetherRecord,
    prepared: Prepared,
    *,
    dt_s: float,
    start_time_s: float = 0.0,
    wrench: FloatArray | None = None,
) -> TetherHistory:
    """Return a run from the kernel's arrays."""
    steps = len(record.logs) - 1
    count = int(prepared.carried[kernel.COUNT])
    return TetherHistory(
        time_s=start_time_s + dt_s * np.arange(steps + 1, dtype=float),
        position_ned_m=record.place,
        tension_n=record.tension,
        force_on_top_ned_n=record.ends[:, 0],
        force_below_ned_n=record.ends[:, 1],
        wrench_on_vehicle=np.zeros((steps + 1, 6)) if wrench is None else wrench,
        segments=record.logs[:, 0],
        paid_out_m=record.logs[:, 1],
        drum_speed_radps=record.logs[:, 2],
        substeps=record.logs[:, 3],
        final=TetherState(
            position_ned_m=prepared.place[: count + 1].copy(),
            velocity_ned_mps=prepared.speed[: count + 1].copy(),
            rest_length_m=prepared.rest[:count].copy(),
            drum_speed_radps=float(prepared.carried[kernel.DRUM]),
            owed_m=float(prepared.carried[kernel.OWED]),
        ),
    )


def refuse_short(length_m: float, top: FloatArray, lower: FloatArray) -> None:
    """Refuse a tether that does not reach from its top to its lower end."""
    distance = float(np.linalg.norm(lower - top))
    if length_m < distance:
        raise CannotComputeError(
            f"The tether is {length_m:g} m long, and from its upper end to the vehicle's "
            f"attachment it is {distance:.3f} m: it does not reach.\nPay out more "
            "cable (length_m of the tether in the vehicle file), or start nearer."
        )


def refuse(status: int, tether: LumpedMassTether, dt_s: float, *, name: str = "the tether") -> None:
    """Say what ended a run early."""
    if status == kernel.NOT_FINITE:
        raise CannotComputeError(
            f"The simulation of {name} left the finite numbers: a step of {dt_s:g} s is too large "
            "for its fastest motion.\nTry half of it."
        )
    if status == kernel.TOO_STIFF:
        crossing = tether.segment_m / tether.wave_speed_mps
        raise CannotComputeError(
            f"A step of {dt_s:g} s is too large for the tether: an axial wave crosses its segment "
            f"of {tether.segment_m:g} m in {crossing:.3g} s, and with the fastest drag a step "
            f"would take more than {MOST_SUBSTEPS} sub-steps.\nUse a shorter step, fewer "
            "segments, or check stiffness, diameter and speeds."
        )
    if status == kernel.NO_ROOM:
        raise CannotComputeError(
            "More tether was paid out than there is room for.\nState the winch's longest_m."
        )
