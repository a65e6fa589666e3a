"""Stretches of runs laid one behind the other, to be simulated together."""

from dataclasses import dataclass

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS
from pipeline.simulate.kernel import MIDPOINT, RK4, STATE
from pipeline.simulate.kernel_pieces import simulate_pieces
from pipeline.simulate.pack import PackedVehicle, shafts_turn
from pipeline.types import FloatArray, IntArray

#: No state of a vehicle is as large, in whatever unit.
_RUN_AWAY = 1e9


@dataclass(frozen=True)
class Pieces:
    """Stretches: `commands` (m, n) of all of them, `bounds` (k + 1,), `steps_s` (k,) their steps.

    Of the results a stretch fills one row more than it has steps: rows `first_row` (k,) to
    `last_row` (k,), both included.
    """

    commands: FloatArray
    bounds: IntArray
    steps_s: FloatArray

    @property
    def first_row(self) -> IntArray:
        """Row of the start of each stretch."""
        return np.asarray(self.bounds[:-1] + np.arange(self.steps_s.size))

    @property
    def last_row(self) -> IntArray:
        """Row of the end of each stretch."""
        return np.asarray(self.bounds[1:] + np.arange(self.steps_s.size))


def run_pieces(
    packed: PackedVehicle,
    pieces: Pieces,
    vector: FloatArray,
    starts: FloatArray,
    external: FloatArray,
    *,
    method: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """States (m + k, STATE) and accelerations (m + k, 6) of all stretches.

    A simulation that leaves the finite numbers is not refused: its rows are not finite.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle.
    pieces : Pieces
        What is simulated.
    vector : ndarray
        Parameter vector.
    starts : ndarray, shape (k, STATE)
        First states.
    external : ndarray, shape (m, 6)
        Force [N] and moment [N m] from outside, held for each step.
    method : int, optional
        Of the kernel; the fastest that is good enough for short steps otherwise.
    """
    count = len(packed.thruster_names)
    rows = len(pieces.commands) + len(starts)
    # without turning shafts a step of a few hundredths of a second is short: two slopes suffice
    if method is None:
        method = RK4 if shafts_turn(vector) else MIDPOINT
    padded = np.zeros((len(pieces.commands), MOST_THRUSTERS))
    padded[:, :count] = pieces.commands
    states, accelerations = np.empty((rows, STATE)), np.empty((rows, 6))
    thrusts = np.empty((rows, MOST_THRUSTERS))
    simulate_pieces(
        vector,
        np.ascontiguousarray(starts, float),
        padded,
        np.ascontiguousarray(external, float),
        pieces.bounds.astype(np.int64),
        np.ascontiguousarray(pieces.steps_s, float),
        method,
        *packed.tables,
        states,
        accelerations,
        thrusts,
    )
    # numbers that only a run-away motion has would overflow in what is made of them
    if not max(np.abs(states).max(initial=0.0), np.abs(accelerations).max(initial=0.0)) < _RUN_AWAY:
        lost = ~(np.abs(states) < _RUN_AWAY).all(axis=1)
        lost |= ~(np.abs(accelerations) < _RUN_AWAY).all(axis=1)
        states[lost], accelerations[lost] = np.nan, np.nan
    return states, accelerations
