"""Fly a vehicle on its tether: both, and the winch, advance together.

A run can be cut into pieces, as a control loop does: start a piece from the final states of the one
before. The result is that of one run, bit for bit.
"""

from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.catenary import uniform_load_cable
from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.physics.tether_cable import Cable
from pipeline.physics.tether_static import solve_tether
from pipeline.physics.winch import Winch
from pipeline.simulate import kernel_swing as kernel
from pipeline.simulate.kernel import STATE
from pipeline.simulate.kernel_tethered import simulate_tethered
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory, checked_codes, initial_state, trajectory
from pipeline.simulate.tether import (
    LumpedMassTether,
    TetherHistory,
    TetherRecord,
    TetherState,
    history,
    lumped_tether,
    prepare,
    refuse,
    refuse_short,
)
from pipeline.types import ArrayLike, FloatArray
from pipeline.vehicle.attachment_schema import Tether

#: The lower end of a tether and the vehicle's attachment nearer than this are one place. [m]
_SAME_PLACE_M = 1e-6


def fly_tethered(
    packed: PackedVehicle,
    commands: FloatArray,
    tether: Tether | LumpedMassTether,
    *,
    dt_s: float,
    vector: FloatArray | None = None,
    start: FloatArray | None = None,
    external: FloatArray | None = None,
    tether_start: TetherState | None = None,
    winch: Winch | None = None,
    winch_command: ArrayLike = 0.0,
    start_time_s: float = 0.0,
) -> tuple[Trajectory, TetherHistory]:
    """Simulate a vehicle on its tether, commands (m, n) held for one step each.

    The parameter vector says where the tether is attached and anchored, and the current in it is
    the tether's too. Water and gravity of a section of the vehicle file are the vehicle's.
    `vector`, `start`, `external` are as in `run`. The tether begins at `tether_start`; at rest in
    the current otherwise, with velocities that fall linearly from those of the attachment to none
    at the upper end. A winch there is told `winch_command` (m,), between -1 and 1, positive pays
    out; without it the length stays.

    Raises
    ------
    CannotComputeError
        As `run`; also for a tether that does not reach.

    Notes
    -----
    Fourth order (RK4) in the sub-steps that the tether needs, as long as no segment goes slack or
    taut; first order with a winch.
    """
    p = packed.vector if vector is None else np.asarray(vector, float)
    codes = checked_codes(packed, commands, p, dt_s, start_time_s=start_time_s)
    steps = len(codes)
    cable = tether
    if isinstance(cable, Tether):
        cable = lumped_tether(
            cable,
            density_kgpm3=float(read(p, "density")),
            gravity_mps2=packed.context.gravity_mps2,
        )
    begin = initial_state() if start is None else np.array(start, float)
    if begin.shape != (STATE,) or not np.isfinite(begin).all():
        raise CannotComputeError(
            f"the state to start from, of shape {begin.shape}, is not {STATE} finite numbers"
        )
    current = np.array(read(p, "current"), float)
    if tether_start is None:
        tether_start = _at_rest(cable, p, begin, current)
    elif np.linalg.norm(tether_start.position_ned_m[-1] - _attachment(p, begin)) > _SAME_PLACE_M:
        # a taut cable is longer than what was paid out: only one that starts elsewhere must reach
        refuse_short(tether_start.paid_out_m, tether_start.position_ned_m[0], _attachment(p, begin))
    prepared = prepare(
        cable,
        tether_start,
        current_mps=current,
        winch=winch,
        winch_command=winch_command,
    )
    states = np.empty((steps + 1, STATE))
    accelerations, wrenches = np.empty((steps + 1, 6)), np.empty((steps + 1, 6))
    thrusts = np.empty((steps + 1, MOST_THRUSTERS))
    record = TetherRecord.empty(steps, len(prepared.place))
    status = simulate_tethered(
        p,
        begin,
        codes,
        np.zeros((1, 6)) if external is None else np.ascontiguousarray(external, float),
        float(dt_s),
        *packed.tables,
        *prepared,
        states,
        accelerations,
        thrusts,
        wrenches,
        *record,
    )
    refuse(status, cable, dt_s, name=f"{packed.name} on its tether")
    tether_run = history(record, prepared, dt_s=dt_s, start_time_s=start_time_s, wrench=wrenches)
    flown = trajectory(packed, codes, states, accelerations, thrusts, dt_s, start_time_s)
    return flown, tether_run


def _attachment(p: FloatArray, state: FloatArray) -> FloatArray:
    """Return the place of the attachment, NED."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_quat(state[[4, 5, 6, 3]])
    return np.asarray(state[:3] + turn.apply(read(p, "tether_point")), dtype=float)


def _at_rest(
    cable: LumpedMassTether, p: FloatArray, state: FloatArray, current: FloatArray
) -> TetherState:
    """Return the tether at rest between anchor and vehicle, its lower end moving with that."""
    from scipy.spatial.transform import Rotation

    lower = _attachment(p, state)
    rest = hang(
        cable,
        top_ned_m=np.array(read(p, "tether_anchor"), float),
        lower_ned_m=lower,
        current_mps=current,
    )
    arm = np.cross(state[10:13], read(p, "tether_point"))
    below = Rotation.from_quat(state[[4, 5, 6, 3]]).apply(state[7:10] + arm)
    share = np.linspace(0.0, 1.0, cable.segments + 1)[:, None]
    return TetherState(
        position_ned_m=rest.position_ned_m,
        velocity_ned_mps=share * below,
        rest_length_m=rest.rest_length_m,
    )


#: Step of the relaxation. [s]
_STEP_S = 0.1


def hang(
    tether: LumpedMassTether,
    *,
    top_ned_m: FloatArray,
    lower_ned_m: FloatArray,
    current_mps: FloatArray,
    settle_s: float = 20.0,
) -> TetherState:
    """Return the tether at rest between two fixed points in a uniform current (3,), NED [m/s].

    Starts from the quasi-static solution, or from a hanging catenary where there is none (a neutral
    cable in still water, a cable that its weight pushes against the flow), and settles the nodes
    for `settle_s` by dynamic relaxation with kinetic damping; 0 leaves the starting shape.

    Raises
    ------
    CannotComputeError
        The tether is shorter than the distance.
    """
    top, lower = np.asarray(top_ned_m, float), np.asarray(lower_ned_m, float)
    current = np.asarray(current_mps, float)
    refuse_short(tether.length_m, top, lower)
    place = _starting_shape(tether, top, lower, current)
    state = TetherState(
        position_ned_m=place,
        velocity_ned_mps=np.zeros_like(place),
        rest_length_m=np.full(tether.segments, tether.segment_m),
    )
    if settle_s <= 0:
        return state
    steps = max(int(np.ceil(settle_s / _STEP_S)), 1)
    inputs = prepare(tether, state, current_mps=current)
    out = TetherRecord.empty(steps, len(inputs.place))
    status = kernel.swing(kernel.HELD, np.zeros((1, 3)), _STEP_S, settle_s > 0, *inputs, *out)
    refuse(status, tether, _STEP_S)
    return replace(state, position_ned_m=history(out, inputs, dt_s=_STEP_S).final.position_ned_m)


def _starting_shape(
    tether: LumpedMassTether, top: FloatArray, lower: FloatArray, current: FloatArray
) -> FloatArray:
    """Return nodes (n + 1, 3) near equilibrium."""
    cable = Cable(
        tether.length_m,
        tether.diameter_m,
        tether.normal_drag,
        tether.tangential_drag,
        wet_weight_npm=tether.wet_weight_npm,
        axial_stiffness_n=tether.axial_stiffness_n,
    )
    nodes = tether.segments + 1
    try:
        rest = solve_tether(
            cable,
            start_m=top,
            end_m=lower,
            flow=current,
            density_kgpm3=max(tether.density_kgpm3, 1e-9),
            nodes=nodes,
        )
        place = rest.position_m.copy()
    except CannotComputeError:
        place = _catenary(tether, top, lower)
    place[0], place[-1] = top, lower
    return place


def _catenary(tether: LumpedMassTether, top: FloatArray, lower: FloatArray) -> FloatArray:
    """Return nodes on a catenary, hanging or, of a floating cable, standing."""
    length = tether.length_m
    s = np.linspace(0.0, length, tether.segments + 1)
    distance = float(np.linalg.norm(lower - top))
    if length <= distance * (1 + 1e-6):
        return np.asarray(top + s[:, None] / length * (lower - top), dtype=float)
    load = np.array([0.0, 0.0, 1.0 if tether.wet_weight_npm >= 0 else -1.0])
    end = lower.copy()
    aside = 0.01 * np.sqrt(length**2 - distance**2)
    if float(np.hypot(*(lower - top)[:2])) < aside:
        end[0] += aside  # a fold has no catenary
        end = top + (end - top) * min(1.0, 0.999 * length / float(np.linalg.norm(end - top)))
    place, _ = uniform_load_cable(s, length_m=length, start_m=top, end_m=end, load_npm=load)
    return np.asarray(place + s[:, None] / length * (lower - end), dtype=float)
