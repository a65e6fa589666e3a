"""Tables that stand twice, on a copied sheet or in a second format: their points count once."""

from dataclasses import replace

from pipeline.errors import Place, Problem
from pipeline.ingest.readings import Reading

COPY = "duplicate"
#: Fewer readings may agree by chance.
_LEAST_ROWS = 4

_Key = tuple[tuple[str, ...], ...]


class TablesSeen:
    """Remembers the tables of all files of a folder and marks those that were there before."""

    def __init__(self) -> None:
        self._first: dict[_Key, Place] = {}

    def marked(
        self,
        place: Place,
        readings: tuple[Reading, ...],
        problems: list[Problem],
        *told: object,
    ) -> tuple[Reading, ...]:
        """Return the readings, all marked where an earlier table has the same ones.

        Parameters
        ----------
        place : Place
            The table.
        readings : tuple of Reading
            Its readings.
        problems : list of Problem
            A warning is added here for a copy.
        told : object
            What headings tell of the table; one that differs is no copy.
        """
        live = [one for one in readings if not one.marks]
        key = ((str(told),), *map(_numbers, live))
        if len(set(key)) <= _LEAST_ROWS:
            return readings
        if key not in self._first:
            self._first[key] = place
            return readings
        what = (
            f"all {len(live)} rows stand in {self._first[key]}, too, with the same numbers; kept "
            "but not fitted."
        )
        problems.append(Problem("warning", place, what, "", "Delete the copy."))
        return tuple(one if one.marks else replace(one, marks=(COPY,)) for one in readings)


def _numbers(reading: Reading) -> tuple[str, ...]:
    # nine digits: the same table as text and as a workbook differs in the last ones
    return tuple(f"{name}={value:.9g}" for name, value in sorted(reading.values.items()))
