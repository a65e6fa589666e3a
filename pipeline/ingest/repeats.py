"""What stands twice counts once: tables that are copies, and rows of many digits."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import Place
from pipeline.ingest.bench_table import Reading, Table, numbers
from pipeline.ingest.rows import COPY, counted, listed
from pipeline.types import FloatArray

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
