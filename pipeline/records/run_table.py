"""A pool run on one time base: what identification, validation and diagnosis work on.

Held in memory only; the processed file of a run is made by the stage that reads it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from pipeline.records.run_conditions import AS_STATED, Conditions, KnownOfRun
from pipeline.types import BoolArray, FloatArray, IntArray

#: Quantities of a run: name -> (columns, unit, meaning). Axes SNAME and NED. Commands and shaft
#: speeds have a column for each thruster.
QUANTITIES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "command": ((), "code", "commanded code of each thruster, in the order of the vehicle file"),
    "shaft_speed": ((), "rpm", "shaft speed of each thruster, in the order of the vehicle file"),
    "angular_velocity": (("p", "q", "r"), "rad/s", "body axes"),
    "specific_force": (("x", "y", "z"), "m/s^2", "body axes, at the place of the sensor"),
    "attitude": (("w", "x", "y", "z"), "1", "quaternion, body to NED"),
    "velocity": (("u", "v", "w"), "m/s", "over ground, body axes, at the place of the sensor"),
    "depth": (("depth",), "m", "of the sensor"),
    "position": (("north", "east", "down"), "m", "NED"),
    "voltage": (("supply",), "V", "supply"),
    "current": (("supply",), "A", "drawn from the supply"),
}


#: Readings that stand in their rows to this are not told apart from them. [s]
_ON_ROW_S = 1e-9


@dataclass(frozen=True)
class OffRow:
    """How the readings of a quantity differ from the rows nearest to them; zero in other rows.

    `late_s` (m,) is by how much a reading is later than its row, `more` (m, k) what it shows less
    the value of the table there, which lies on the line to the next reading. Between two readings
    of a DVL a vehicle may have changed its mind, and a line misses that by more than the noise.
    """

    late_s: FloatArray
    more: FloatArray

    @classmethod
    def of(
        cls, time_s: FloatArray, values: FloatArray, reading_s: FloatArray, readings: FloatArray
    ) -> Self | None:
        """Compare readings with a table; None where all stand in their rows.

        Parameters
        ----------
        time_s : ndarray, shape (m,)
            Evenly spaced times of the table. [s]
        values : ndarray, shape (m, k)
            The table; four columns are a quaternion of either sign.
        reading_s, readings : ndarray, shape (n,), (n, k)
            Times and values of the readings.
        """
        if time_s.size < 2:
            return None
        period = float(time_s[1] - time_s[0])
        row = np.rint((reading_s - time_s[0]) / period).astype(int)
        inside = (row >= 0) & (row < time_s.size)
        row, reading_s, readings = row[inside], reading_s[inside], readings[inside]
        late_s = reading_s - time_s[row]
        if not (np.abs(late_s) > _ON_ROW_S).any():
            return None
        # of several readings next to a row the nearest is written last and stays
        order = np.argsort(-np.abs(late_s), kind="stable")
        row, late_s, readings = row[order], late_s[order], readings[order]
        if readings.shape[1] == 4:
            side = np.einsum("ij,ij->i", readings, np.nan_to_num(values[row]))
            readings = readings * np.where(side < 0.0, -1.0, 1.0)[:, None]
        found = cls(np.zeros(time_s.size), np.zeros(values.shape))
        found.late_s[row] = late_s
        found.more[row] = np.nan_to_num(readings - values[row])
        return found

    def rows(self, kept: slice | BoolArray | IntArray) -> Self:
        """Return some of the rows."""
        return type(self)(self.late_s[kept], self.more[kept])


@dataclass(frozen=True)
class RunTable:
    """Channels resampled to one time base.

    `time_s` (m,) from 0; `values` quantity -> (m, k); `valid` quantity -> (m,) False where a gap,
    a mark or the end of the channel leaves nothing to trust: what stands there is not to be used
    (not a number in a table of a log). A quantity that was not measured is absent. Known delays
    are removed. `name` is the run's.
    """

    name: str
    time_s: FloatArray
    values: dict[str, FloatArray]
    valid: dict[str, BoolArray]
    notes: tuple[str, ...] = field(default=())
    reading: dict[str, BoolArray] = field(default_factory=dict)
    """Quantity -> (m,) True at the sample nearest to each reading of the sensor; what lies between
    is interpolated. A quantity that is absent here says nothing about it."""
    off_row: dict[str, OffRow] = field(default_factory=dict)
    """Quantity -> how its readings differ from their rows; absent where they stand in them."""
    thrusters: tuple[str, ...] = ()
    """Names of the columns of `command` and `shaft_speed`; empty where nothing names them."""
    start_time_ns: int = 0
    """Where `time_s` is 0, on the clock of the log. [ns since 1970]"""
    left_out: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    """Channel -> mark -> readings that took no part because of it."""
    known: KnownOfRun | None = None
    """How the vehicle differed from its file, where that is known."""

    @property
    def period_s(self) -> float:
        """Usual time from a row to the next [s]."""
        return float(np.median(np.diff(self.time_s)))

    def trusted(self, quantity: str) -> BoolArray:
        """Tell in which rows (m,) a quantity that is there can be trusted, all its components."""
        return np.asarray(self.valid[quantity] & np.isfinite(self.values[quantity]).all(axis=1))

    def pause_s(self, quantity: str) -> float:
        """Usual pause between readings of a quantity; a row where none are marked. [s]."""
        marks = self.reading.get(quantity)
        if marks is None or marks.sum() <= 2:
            return self.period_s
        return float(np.median(np.diff(self.time_s[marks])))

    @property
    def changes(self) -> list[int]:
        """Rows at which something of the vehicle, as it is known, begins to be otherwise."""
        return [] if self.known is None else self.known.rows_of_changes(self.time_s).tolist()

    def rows(self, begin: int, end: int) -> "RunTable":
        """Return the rows [begin, end) as a table of their own, times from 0."""
        part, begin_s = slice(begin, end), float(self.time_s[begin])
        return replace(
            self,
            known=None if self.known is None else self.known.part(part, begin_s),
            time_s=self.time_s[part] - begin_s,
            values={name: values[part] for name, values in self.values.items()},
            valid={name: valid[part] for name, valid in self.valid.items()},
            reading={name: marks[part] for name, marks in self.reading.items()},
            off_row={name: off.rows(part) for name, off in self.off_row.items()},
            start_time_ns=self.start_time_ns + round(1e9 * begin_s),
        )

    def force_over(self, rows: slice) -> FloatArray | None:
        """Return the known force from outside at some rows (k, 6) [N, N m]; None without any."""
        if self.known is None or self.known.force is None:
            return None
        return self.known.force[rows]

    def conditions_at(self, time_s: float) -> Conditions:
        """Return how the vehicle differed from its file at a time [s]."""
        return AS_STATED if self.known is None else self.known.at(time_s)
