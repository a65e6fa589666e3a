"""Tables of a folder beside each other: copies count once, and all must agree."""

from collections.abc import Hashable, Mapping, Sequence

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.bench_table import Reading, Table, numbers
from pipeline.ingest.rows import COPY, counted, listed
from pipeline.types import FloatArray

#: What of a table is compared: of what must be equal, a reading by what it depends on.
Curves = Mapping[Hashable, Mapping[float, float]]
#: Specimens of one type differ by a few per cent; their larger readings tell it.
ALIKE, _LARGER = 0.1, 0.2
#: No specimen differs by so much: one of them is in another unit, or of another machine.
_APART = 2.0
CONTRADICTS = "contradicts other tables"


def disagreement(
    tables: Sequence[Table], curves: Sequence[Curves], name: str
) -> tuple[list[Problem], frozenset[int]]:
    """Tell of the tables that differ from the others; `name` is what is compared.

    Returns what is wrong, and the numbers of the tables that cannot be fitted together: of two that
    are a factor apart nobody knows which is right; one of several thrusters is another than they.
    """
    shares: dict[int, float] = {}
    partners: dict[int, int] = {}
    for at, own in enumerate(curves):
        for key, curve in own.items():
            holders = [other for other, one in enumerate(curves) if one.get(key)]
            others = [other for other in holders if other != at or len(holders) > 2]
            share = share_of(curve, [curves[other][key] for other in others]) if curve else 1.0
            if abs(np.log(share)) > abs(np.log(shares.get(at, 1.0))):
                shares[at] = share
                partners[at] = others[0] if len(holders) == 2 else at
    odd = {at: one for at, one in shares.items() if abs(one - 1.0) > ALIKE}
    apart = frozenset(
        at
        for at, one in odd.items()
        if abs(np.log(one)) > np.log(_APART) or tables[at].block.thruster is not None
    )
    problems = []
    for at, share in odd.items():
        thruster, is_apart = tables[at].block.thruster, at in apart
        if at >= partners[at] or partners[at] not in odd:  # of two one message is enough
            who = "this table" if thruster is None else f'thruster "{thruster}"'
            place = tables[at].place
            say = place.error if is_apart and thruster is None else place.warning
            how = "what contradicts is kept but not" if is_apart else "all of it is"
            problems.append(
                say(
                    f"{who} gives {share:.2f} times the {name} of the others, where all else is "
                    f"equal; {how} fitted.",
                    "tests of one type of machine, in one unit, at one voltage, in one water.",
                    "Correct the unit, or take it out of the folder; sheets and columns are chosen "
                    f"in vehicle.yaml:\n  columns:\n    {tables[at].kind}: {{sheets: [...]}}",
                )
            )
    return problems, apart


def share_of(curve: Mapping[float, float], others: Sequence[Mapping[float, float]]) -> float:
    """Return the reading of one table over the middle one of others, where they overlap."""
    at = np.array(sorted(curve))
    every = [
        np.interp(at, sorted(one), [one[x] for x in sorted(one)], np.nan, np.nan)
        for one in others
        if one
    ]
    there = np.isfinite(every).any(axis=0) if every else np.zeros(at.size, np.bool_)
    if not there.any():
        return 1.0
    own = np.array([curve[x] for x in at[there].tolist()])
    middle = np.nanmedian(np.array(every)[:, there], axis=0)
    large = np.abs(middle) > _LARGER * np.abs(middle).max()
    share = float(np.median(own[large] / middle[large])) if large.any() else 1.0
    return share if share > 0.0 else 1.0


#: Fewer readings may agree by chance, as may rows of few quantities: but not speed beside torque.
_LEAST_ROWS, _LEAST_QUANTITIES, _TELLING = 4, 3, frozenset({"shaft_speed", "torque"})
_AT_REST = ("code", "advance_ratio", "speed")
#: Of the rows of a copy; of the largest value, what rounding changes; of pairs that are looked at.
_WHOLE, _ROUNDING, _MOST_PAIRS = 0.9, 1e-3, 4_000_000


class Copies:
    """Remembers the readings of a folder, and marks those that were read before."""

    def __init__(self) -> None:
        """Begin with nothing seen."""
        self._seen: dict[object, Place] = {}
        self._codeless: list[tuple[Place, FloatArray]] = []

    def mark(self, tables: Sequence[Table]) -> None:
        """Mark the readings of a file's tables that stand further up, or in another table.

        All of a table, or single rows, which of a mooring test may well repeat: a thrust is read
        coarsely. Several files may measure the same code: that is a repetition of the test.
        """
        for table in tables:
            first = self._results_of(table)
            rows = {one.row: _key(table, one) for one in table.live()}
            seen = len(self._seen.keys() & set(rows.values()))
            is_whole = seen >= max(_LEAST_ROWS, _WHOLE * len(set(rows.values()))) or bool(first)
            copies: dict[Place, list[int]] = {} if first is None else {first: list(rows)}
            for one in table.live() if first is None else ():
                is_new = rows[one.row] not in self._seen
                place = self._seen.setdefault(rows[one.row], table.place)
                if not is_new and (is_whole or _is_telling(table, one)):
                    copies.setdefault(place, []).append(one.row)
            for place, own in copies.items():
                where = "further up" if place == table.place else f"in {place}"
                what = (
                    f"{counted(len(own), 'row')} again as {where} "
                    f"({listed(own)}); kept but not fitted."
                )
                here = table.at(own[0])
                table.problems.append(
                    here.warning(what, "", "Delete the copy.") if is_whole else here.note(what)
                )
                table.mark(set(own), COPY)

    def _results_of(self, table: Table) -> Place | None:
        """Return the table whose points one without codes has again, rounded or without signs."""
        if table.kind != "load_test" or any("code" in one.values for one in table.readings):
            return None
        mine = np.abs([numbers(table.readings, name) for name in sorted(_TELLING)]).T
        found = None
        for place, theirs in self._codeless:
            if _LEAST_ROWS < len(mine) <= len(theirs) <= _MOST_PAIRS / len(mine):
                apart = np.abs(mine[:, None, :] - theirs[None, :, :])
                close = (apart <= _ROUNDING * theirs.max(axis=0)).all(axis=2).any(axis=1)
                found = place if close.mean() >= _WHOLE else found
        if len(mine):
            self._codeless.append((table.place, mine))
        return found


def _key(table: Table, one: Reading) -> object:
    # nine digits: the same file read as text and as a workbook differs in the last ones
    values = {name: f"{v:.9g}" for name, v in one.values.items() if name != "time"}
    return table.nominal_voltage_v, table.sense, frozenset(values.items())


def _is_telling(table: Table, one: Reading) -> bool:
    values = one.values
    if table.kind == "mooring" or 0.0 in {values.get(name) for name in _AT_REST}:
        return False
    count = len(values) + ("advance_ratio" in values)
    return values.keys() >= _TELLING or count >= _LEAST_QUANTITIES
