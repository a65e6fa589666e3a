"""A pool run on one time base: what identification, validation and diagnosis work on.

Held in memory only; the processed file of a run is made by the stage that reads it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from pipeline.types import BoolArray, FloatArray, IntArray

#: Times that agree to this are the same: stamps are rounded, and so are steps. [s]
_SAME_S = 1e-6
#: Decimals of a mean: what differences of long sums leave beyond them is round-off.
_DIGITS = 9

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

#: Quantity -> name and unit of each component that is compared; shaft speeds are named by thruster.
COMPONENTS: dict[str, tuple[tuple[str, str], ...]] = {
    "velocity": (("u", "m/s"), ("v", "m/s"), ("w", "m/s")),
    "angular_velocity": (("p", "rad/s"), ("q", "rad/s"), ("r", "rad/s")),
    "attitude": (("phi", "rad"), ("theta", "rad"), ("psi", "rad")),
    "depth": (("depth", "m"),),
    "position": (("north", "m"), ("east", "m"), ("down", "m")),
    "specific_force": (("fx", "m/s^2"), ("fy", "m/s^2"), ("fz", "m/s^2")),
    "shaft_speed": (),
    "voltage": (("supply", "V"),),
}


def mean_held(
    sent_s: FloatArray, values: FloatArray, time_s: FloatArray, step_s: float
) -> FloatArray:
    """Mean of the commands that hold over the step which begins at each row.

    A simulation takes one command a step. Where a new one comes in mid-step, either of the two
    alone would be up to a step early or late: a tenth of the lag of many drives, and plain to see
    for an accelerometer. The mean leaves a lagging drive where the two in turn leave it, but for
    what the lag forgets within a step.

    `sent_s` (n,) is when each of the commands `values` (n, k) was sent, ascending, the first taken
    to have held before, too; `time_s` (m,) are the begins of the steps, `step_s` long. [s]. Returns
    the means (m, k).

    >>> import numpy as np
    >>> sent_s, codes = np.array([0.0, 0.05]), np.array([[10.0], [20.0]])
    >>> mean_held(sent_s, codes, np.array([0.02, 0.04, 0.06]), 0.02).ravel().tolist()
    [10.0, 15.0, 20.0]
    """
    reached = np.concatenate(
        [np.zeros((1, values.shape[1])), np.cumsum(values[:-1] * np.diff(sent_s)[:, None], axis=0)]
    )

    def held_at(at_s: FloatArray) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], FloatArray]:
        index = np.clip(np.searchsorted(sent_s, at_s, side="right") - 1, 0, None)
        return index, reached[index] + values[index] * (at_s - sent_s[index])[:, None]

    first, begun = held_at(time_s + _SAME_S)
    last, ended = held_at(time_s + step_s - _SAME_S)
    mean = (ended - begun) / (step_s - 2.0 * _SAME_S)
    # one command alone is that command, not nearly so: thrusts have kinks at whole codes
    return np.where((first == last)[:, None], values[first], np.round(mean, _DIGITS))


@dataclass(frozen=True)
class KnownBody:
    """Something put onto the vehicle of the file, or taken off (negative numbers).

    `mass_kg` in air, `volume_m3` the water that it displaces, `position_m` body axes;
    `inertia_kgm2` I_xx, I_yy, I_zz about its own centre.
    """

    name: str
    mass_kg: float
    volume_m3: float
    position_m: tuple[float, float, float]
    inertia_kgm2: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Conditions:
    """How a vehicle differs from its file for a while; `density_kgpm3` None: as in the file."""

    bodies: tuple[KnownBody, ...] = ()
    density_kgpm3: float | None = None
    gravity_mps2: float = 9.81

    @property
    def as_stated(self) -> bool:
        """Whether nothing differs."""
        return not self.bodies and self.density_kgpm3 is None


#: Conditions of a run of which nothing else is known.
AS_STATED = Conditions()


@dataclass(frozen=True)
class KnownOfRun:
    """What is known of a run, by its own time.

    `from_s` (k,) are the times from which `conditions` hold, the first at or before the first row;
    `force` (m, 6) is what acts on the vehicle from outside at every row of the table, body axes,
    about the origin: its cable's [N, N m]. `notes` are for whoever reads the result.
    """

    from_s: tuple[float, ...] = (0.0,)
    conditions: tuple[Conditions, ...] = (AS_STATED,)
    force: FloatArray | None = None
    notes: tuple[str, ...] = ()

    def at(self, time_s: float) -> Conditions:
        """Return the conditions at a time [s]."""
        place = int(np.searchsorted(self.from_s, time_s + 1e-9, side="right")) - 1
        return self.conditions[max(place, 0)]

    def rows_of_changes(self, time_s: FloatArray) -> IntArray:
        """Rows of a table with these times at which something else begins to hold."""
        rows = np.searchsorted(time_s, np.array(self.from_s[1:]) - 1e-9)
        return np.unique(rows[(rows > 0) & (rows < time_s.size)])

    def part(self, rows: slice, begin_s: float) -> "KnownOfRun":
        """Return what is known of some rows, counted from `begin_s` on. [s]."""
        return replace(
            self,
            from_s=tuple(one - begin_s for one in self.from_s),
            force=None if self.force is None else self.force[rows],
        )


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
        """Compare `readings` (n, k) at `reading_s` (n,) with a table; None where all stand in rows.

        The table has `values` (m, k) at evenly spaced times `time_s` (m,) [s]; four columns are a
        quaternion of either sign.
        """
        if time_s.size < 2:
            return None
        period = float(time_s[1] - time_s[0])
        row = np.rint((reading_s - time_s[0]) / period).astype(int)
        inside = np.flatnonzero((row >= 0) & (row < time_s.size))
        late_s = np.zeros(row.shape)
        late_s[inside] = reading_s[inside] - time_s[row[inside]]
        if not (np.abs(late_s) > _ON_ROW_S).any():
            return None
        # of several readings next to a row the nearest is written last and stays; a long log has
        # twenty a row, so the others are left out first
        order = inside[np.argsort(-np.abs(late_s[inside]), kind="stable")]
        nearest = np.full(time_s.size, -1)
        nearest[row[order]] = order
        row = np.flatnonzero(nearest >= 0)
        late_s, readings = late_s[nearest[row]], readings[nearest[row]]
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


#: Rows from the first up to, and without, the last.
Range = tuple[int, int]


def stretches(mark: BoolArray, bridge: int = 0) -> list[Range]:
    """Begin and end of each run of True; pauses of up to `bridge` samples are bridged.

    >>> stretches(np.array([0, 1, 1, 0, 1, 0, 0, 0, 1], bool), bridge=1)
    [(1, 5), (8, 9)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mark, [False]]).astype(np.int8)))
    found: list[Range] = []
    for begin, end in edges.reshape(-1, 2).tolist():
        if found and begin - found[-1][1] <= bridge:
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return found


def angles(quaternion: FloatArray) -> FloatArray:
    """Roll, pitch, yaw (m, 3) of quaternions (m, 4), not a number where they are not. [rad]."""
    found = np.full((len(quaternion), 3), np.nan)
    there = np.isfinite(quaternion).all(axis=1) & (np.abs(quaternion).sum(axis=1) > 0)
    if there.any():
        # a second of processor, which whoever reads a record has no use for
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_quat(quaternion[there][:, [1, 2, 3, 0]])
        found[there] = turn.as_euler("ZYX")[:, ::-1]
    return found


def continuous(quaternion: FloatArray) -> FloatArray:
    """Take of the two signs of each quaternion (m, 4) the one next to that before."""
    same = np.where(np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0.0, -1.0, 1.0)
    return np.asarray(quaternion * np.concatenate([[1.0], np.cumprod(same)])[:, None])


def down_axis(quaternion: FloatArray) -> FloatArray:
    """Down in body axes (m, 3), the last row of the rotation matrix, of quaternions (m, 4)."""
    w, x, y, z = quaternion.T
    return np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=1)


def quaternion_product(p: FloatArray, q: FloatArray) -> FloatArray:
    """Product p q (m, 4) of quaternions w, x, y, z (m, 4); one of them may be a single one (4,)."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )


def components(table: RunTable, quantity: str) -> FloatArray:
    """Values (m, k) of what is compared; attitude as angles."""
    values = table.values[quantity]
    return angles(values) if quantity == "attitude" else values


def difference(quantity: str, measured: FloatArray, simulated: FloatArray) -> FloatArray:
    """Measured less simulated; angles by the shorter way."""
    gap = measured - simulated
    return np.asarray((gap + np.pi) % (2 * np.pi) - np.pi) if quantity == "attitude" else gap
