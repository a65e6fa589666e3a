"""From a tether's description to the kernel's arrays and back, and the refusals on the way."""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.winch import Winch
from pipeline.simulate import kernel_swing as kernel
from pipeline.simulate.kernel_tether import MOST_SUBSTEPS, WINCH_SIZE
from pipeline.simulate.tether import LumpedMassTether, TetherHistory, TetherState
from pipeline.types import ArrayLike, FloatArray

#: Nodes that a cable has room for at most: every step of a run keeps the place of each.
MOST_NODES = 20000


@dataclass(frozen=True)
class Prepared:
    """What the kernel takes of a tether; the last four are its state, changed in place."""

    cable: FloatArray
    winch: FloatArray
    commands: FloatArray
    fastest_water: float
    place: FloatArray
    speed: FloatArray
    rest: FloatArray
    carried: FloatArray


@dataclass(frozen=True)
class TetherRecord:
    """What the kernel fills of a tether's run."""

    place: FloatArray
    tension: FloatArray
    ends: FloatArray
    logs: FloatArray

    @classmethod
    def empty(cls, steps: int, room: int) -> "TetherRecord":
        """Arrays for a number of steps and nodes."""
        return cls(
            place=np.empty((steps + 1, room, 3)),
            tension=np.empty((steps + 1, room - 1)),
            ends=np.empty((steps + 1, 2, 3)),
            logs=np.empty((steps + 1, 4)),
        )


def swung(
    inputs: Prepared,
    out: TetherRecord,
    *,
    lower: int,
    lower_velocity: FloatArray,
    dt_s: float,
    settle: bool,
) -> int:
    """Let the kernel move a tether between its ends, and fill `out`; return its status.

    `lower` is ``kernel_swing.FREE`` or ``HELD``, `lower_velocity` (1 or steps, 3) that of a held
    end [m/s]; with `settle` nodes are stopped at each peak of their energy, which brings them to
    rest.
    """
    return int(
        kernel.swing(
            inputs.cable,
            inputs.winch,
            lower,
            lower_velocity,
            inputs.commands,
            inputs.fastest_water,
            float(dt_s),
            settle,
            inputs.place,
            inputs.speed,
            inputs.rest,
            inputs.carried,
            out.place,
            out.tension,
            out.ends,
            out.logs,
        )
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
    current = np.asarray(current_mps, float)
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
        cable=tether.numbers(current),
        winch=numbers,
        commands=commands,
        fastest_water=float(np.linalg.norm(current)),
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
