"""What a measured motion demands of the thrusters, and what of it is known to be no thrust's."""

from dataclasses import replace

import numpy as np

from pipeline.measured.motion import MeasuredMotion
from pipeline.physics.parameters import write
from pipeline.records.run_table import Conditions, RunTable
from pipeline.simulate.kernel_alone import demand_along
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import vector_under
from pipeline.types import BoolArray, FloatArray


def settled(vector: FloatArray) -> FloatArray:
    """Parameters of thrusters whose shafts have settled."""
    found = vector.copy()
    write(found, "rotor_inertia", 0.0)
    return found


def demanded(
    packed: PackedVehicle, vector: FloatArray, motion: MeasuredMotion, *, still: bool = False
) -> FloatArray:
    """Wrench (m, 6) that a motion demands: M nu' less every force but thrust [N, N m].

    `still` leaves out M nu'.
    """
    rate = np.zeros_like(motion.nu_dot) if still else motion.nu_dot
    out = np.zeros((len(motion.state), 6))
    demand_along(
        vector,
        np.ascontiguousarray(motion.state),
        np.ascontiguousarray(rate),
        packed.strips,
        out,
    )
    return out


def known_wrench(packed: PackedVehicle, run: RunTable, motion: MeasuredMotion) -> FloatArray:
    """Wrench (m, 6) on the vehicle of the file that is known of a run beside its log [N, N m].

    The cable's force, and what bodies put on or taken off and other water make of the demand.
    """
    found = np.zeros((len(motion.state), 6))
    known = run.known
    if known is None:
        return found
    if known.force is not None:
        found += known.force
    ends = [*known.from_s[1:], np.inf]
    for begin, end, conditions in zip(known.from_s, ends, known.conditions, strict=True):
        rows = (motion.time_s >= begin - 1e-9) & (motion.time_s < end - 1e-9)
        if rows.any() and not conditions.as_stated:
            found[rows] += taken_by(packed, conditions, rows_of(motion, rows))
    return found


def taken_by(packed: PackedVehicle, conditions: Conditions, motion: MeasuredMotion) -> FloatArray:
    """Wrench (m, 6) by which the vehicle of the file moves as it does under conditions [N, N m]."""
    vector = settled(packed.vector)
    under = vector_under(conditions, vector)
    return demanded(packed, vector, motion) - demanded(packed, under, motion)


def rows_of(motion: MeasuredMotion, rows: BoolArray) -> MeasuredMotion:
    """Keep some rows of a motion."""
    return replace(
        motion,
        time_s=motion.time_s[rows],
        state=motion.state[rows],
        nu_dot=motion.nu_dot[rows],
    )
