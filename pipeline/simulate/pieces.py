"""Stretches of runs laid one behind the other, to be simulated together."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, offset, slot
from pipeline.records.run_table import Conditions
from pipeline.simulate.kernel import BODY, MIDPOINT, RK4, STATE
from pipeline.simulate.kernel_alone import lag_pieces, simulate_pieces
from pipeline.simulate.pack import PackedVehicle, shafts_turn
from pipeline.simulate.pack_hull import vector_under
from pipeline.types import FloatArray, IntArray

#: Of the parameter vector what effective codes follow from, beside commands and starts.
OF_DRIVES = np.concatenate(
    [
        offset(name) + np.arange(slot(name).size)
        for name in (
            *("thruster_count", "code_max", "code_min", "dead_zone", "supply_drop", "load_drop"),
            *("drive_dead", "lag_dead_share", "lag", "lag_power", "lag_fall", "rotor_inertia"),
        )
    ]
)
#: Sets of drives and starts of which the codes are kept.
_KEPT = 4
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
    late: dict[bytes, FloatArray] = field(default_factory=dict, compare=False)
    """Codes after the lag, by what they follow from: the same for many simulations."""

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
    rows = len(pieces.commands) + len(starts)
    # without turning shafts a step of a few hundredths of a second is short: two slopes suffice
    if method is None:
        method = RK4 if shafts_turn(vector) else MIDPOINT
    states, accelerations = np.empty((rows, STATE)), np.empty((rows, 6))
    thrusts = np.empty((rows, MOST_THRUSTERS))
    simulate_pieces(
        vector,
        np.ascontiguousarray(starts, float),
        _late_codes(pieces, vector, starts),
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


def _late_codes(pieces: Pieces, vector: FloatArray, starts: FloatArray) -> FloatArray:
    """Effective codes (m, 3, 12) at the start, the middle and the end of each step."""
    key = vector[OF_DRIVES].tobytes() + starts[:, BODY:].tobytes()
    late = pieces.late.get(key)
    if late is None:
        padded = np.zeros((len(pieces.commands), MOST_THRUSTERS))
        padded[:, : pieces.commands.shape[1]] = pieces.commands
        late = np.empty((len(padded), 3, MOST_THRUSTERS))
        begin, steps_s = np.ascontiguousarray(starts, float), np.asarray(pieces.steps_s, float)
        lag_pieces(vector, begin, padded, pieces.bounds.astype(np.int64), steps_s, late)
    # the longest unused is forgotten
    pieces.late.pop(key, None)
    pieces.late[key] = late
    for oldest in list(pieces.late)[:-_KEPT]:
        pieces.late.pop(oldest, None)
    return late


@dataclass(frozen=True)
class Alike:
    """Stretches of a layout under the same conditions, with the steps and rows that are theirs."""

    conditions: Conditions
    stretches: IntArray
    pieces: Pieces
    steps: IntArray
    rows: IntArray


def alike_pieces(layout: Pieces, conditions: Sequence[Conditions]) -> tuple[Alike, ...]:
    """Sort the stretches of a layout by their conditions."""
    found = []
    for known in dict.fromkeys(conditions):
        own = np.array([k for k, one in enumerate(conditions) if one == known])
        first, end = layout.bounds[own], layout.bounds[own + 1]
        steps = np.concatenate([np.arange(a, b) for a, b in zip(first, end, strict=True)])
        rows = np.concatenate(
            [np.arange(a + k, b + k + 1) for k, a, b in zip(own, first, end, strict=True)]
        )
        pieces = Pieces(
            layout.commands[steps],
            np.concatenate([[0], np.cumsum(end - first)]),
            layout.steps_s[own],
        )
        found.append(Alike(known, own, pieces, steps, rows))
    return tuple(found)


def run_alike(
    packed: PackedVehicle,
    layout: Pieces,
    alike: tuple[Alike, ...],
    vector: FloatArray,
    *,
    starts: FloatArray,
    external: FloatArray,
    method: int | None = None,
) -> tuple[FloatArray, FloatArray]:
    """States and accelerations of a layout, each run as it is known to have been.

    Parameters as of `run_pieces`; `vector` is the vehicle's, whatever ran with more ballast or
    less, and `alike` the layout sorted by conditions.
    """
    if len(alike) == 1:
        under = vector_under(alike[0].conditions, vector)
        return run_pieces(packed, layout, under, starts, external, method=method)
    count = len(layout.commands) + len(starts)
    states, rates = np.empty((count, STATE)), np.empty((count, 6))
    for one in alike:
        states[one.rows], rates[one.rows] = run_pieces(
            packed,
            one.pieces,
            vector_under(one.conditions, vector),
            starts[one.stretches],
            external[one.steps],
            method=method,
        )
    return states, rates
