"""A tether without a vehicle: its shape at rest between two points."""

from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.catenary import uniform_load_cable
from pipeline.physics.tether_cable import Cable
from pipeline.physics.tether_static import solve_tether
from pipeline.simulate import kernel_swing as kernel
from pipeline.simulate.tether import LumpedMassTether, TetherState
from pipeline.simulate.tether_arrays import (
    TetherRecord,
    history,
    prepare,
    refuse,
    refuse_short,
    swung,
)
from pipeline.types import FloatArray

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
    still = np.zeros((1, 3))
    status = swung(inputs, out, lower=kernel.HELD, lower_velocity=still, dt_s=_STEP_S, settle=True)
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
