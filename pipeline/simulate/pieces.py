"""Stretches of runs laid one behind the other, to be simulated together."""

from dataclasses import dataclass, field

import numpy as np

from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.records.run_table import AS_STATED, Conditions
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.kernel_alone import lag_pieces, simulate_pieces
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import vector_under
from pipeline.types import FloatArray, IntArray

#: What effective codes follow from, beside commands and starts.
_OF_DRIVES = (
    *("thruster_count", "code_max", "code_min", "dead_zone", "supply_drop", "load_drop"),
    *("drive_dead", "lag_dead_share", "lag", "lag_power", "lag_fall", "rotor_inertia"),
)


@dataclass(frozen=True)
class Pieces:
    """Stretches: `commands` (m, n) of all of them, `bounds` (k + 1,), `steps_s` (k,) their steps.

    `conditions` (k,) of each, or of all. Of the results a stretch fills one row more than it has
    steps: rows `first_row` (k,) to `last_row` (k,), both included.
    """

    commands: FloatArray
    bounds: IntArray
    steps_s: FloatArray
    conditions: tuple[Conditions, ...] = (AS_STATED,)
    late: dict[bytes, FloatArray] = field(default_factory=dict, compare=False)
    """Effective codes by what they follow from: the same for many simulations in turn."""

    @property
    def first_row(self) -> IntArray:
        """Row of the start of each stretch."""
        return np.asarray(self.bounds[:-1] + np.arange(self.steps_s.size))

    @property
    def last_row(self) -> IntArray:
        """Row of the end of each stretch."""
        return np.asarray(self.bounds[1:] + np.arange(self.steps_s.size))


def run_pieces(  # noqa: PLR0917 - what is flown, and by what
    packed: PackedVehicle,
    pieces: Pieces,
    vector: FloatArray,
    starts: FloatArray,
    external: FloatArray,
    method: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States (m + k, STATE), accelerations (m + k, 6) and thrusts (m + k, 12) of all stretches.

    A simulation that leaves the finite numbers is not refused: its rows are not finite. `vector` is
    the vehicle's, whatever ran with more ballast or less; `starts` (k, STATE) are first states,
    `external` (m, 6) or (1, 6) force [N] and moment [N m] from outside, held for each step.
    """
    rows = len(pieces.commands) + len(starts)
    found = np.empty((rows, STATE)), np.empty((rows, 6)), np.empty((rows, MOST_THRUSTERS))
    known = dict.fromkeys(pieces.conditions)
    if len(known) > 1:
        lengths, numbers = np.diff(pieces.bounds), np.arange(pieces.steps_s.size)
        step_of, row_of = np.repeat(numbers, lengths), np.repeat(numbers, lengths + 1)
        for one in known:
            own = np.array([each == one for each in pieces.conditions])
            bounds = np.concatenate([[0], np.cumsum(lengths[own])])
            part = Pieces(pieces.commands[own[step_of]], bounds, pieces.steps_s[own], (one,))
            outside = external if len(external) == 1 else external[own[step_of]]
            parts = run_pieces(packed, part, vector, starts[own], outside, method)
            for whole, values in zip(found, parts, strict=True):
                whole[own[row_of]] = values
        return found
    under = vector_under(pieces.conditions[0], vector)
    begin, steps_s = np.ascontiguousarray(starts, float), np.ascontiguousarray(pieces.steps_s)
    bounds, outside = pieces.bounds.astype(np.int64), np.ascontiguousarray(external, float)
    key = b"".join(read(under, name).tobytes() for name in _OF_DRIVES) + begin[:, BODY:].tobytes()
    late = pieces.late.get(key)
    if late is None:
        codes = np.zeros((len(pieces.commands), MOST_THRUSTERS))
        codes[:, : pieces.commands.shape[1]] = pieces.commands
        # at the start, the middle and the end of each step
        late = np.empty((len(codes), 3, MOST_THRUSTERS))
        lag_pieces(under, begin, codes, bounds, steps_s, late)
        for oldest in list(pieces.late)[:-3]:
            pieces.late.pop(oldest, None)
        pieces.late[key] = late
    simulate_pieces(under, begin, late, outside, bounds, steps_s, method, *packed.tables, *found)
    return found
