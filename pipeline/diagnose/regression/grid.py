"""A run on an even grid: velocities, attitude, and the wrench that its commands claim."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.diagnose.coordinates import Added, Coordinate
from pipeline.diagnose.regression.claimed import Claimed, Departure, Late
from pipeline.diagnose.regression.place import place_told
from pipeline.diagnose.regression.supply import supply_told
from pipeline.errors import CannotComputeError
from pipeline.measured.completed import completed
from pipeline.measured.motion import channel_of
from pipeline.physics.window_sums import means_over
from pipeline.records.run_table import RunTable, continuous, down_axis
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

CHANNELS = ("u", "v", "w", "p", "q", "r")
#: Rows of the grid may be so far apart. [s]
PERIODS_S = (1 / 10, 1 / 5, 1 / 4, 1 / 3, 1 / 2)
#: Periods of past force that count, and how late a reading may plausibly be. [s]
FORCES, _LATE_S = 5, 1.0
#: Departure, in units of half the plausible range, at which a wrench is taken.
STEP = 1.0


@dataclass(frozen=True, eq=False)
class GridRun:
    """A run at times `period_s` apart.

    `channels` are the velocities that were measured, in the order of `velocity` (m, v); heave may
    be by the depth. `down` (m, 3) is the direction of gravity in body axes, `wrench` (m, 6) the
    mean wrench of the thrusters over the period that ends at a row. For each direction `more`
    (m, d, 6) is the mean wrench of a unit of it but for what goes with the acceleration, and
    `heavier` (d, 6, 6) the mass that a unit adds. `attitude` (m, 4) is the quaternion from body to
    NED. `beside` are what a logged voltage and the measured place say of them, information (d, d)
    and score (d,) of each. `course` (m, v) are the velocities as accelerations tell their course,
    with less noise, where they do. `taken` are the sizes at which the last directions were taken;
    `misread` (d, 3, 6) is what a unit of each direction changes in readings of the velocity, see
    the module; `late` is of a unit of each direction that makes readings late; `claimed` is what
    they are taken from. `made` (m, v) is what a likely change makes of the next velocities, and
    `settled_of` the run without that; see `Response.settled`.
    """

    name: str
    period_s: float
    time_s: FloatArray
    channels: tuple[str, ...]
    velocity: FloatArray
    attitude: FloatArray
    down: FloatArray
    wrench: FloatArray
    more: FloatArray
    heavier: FloatArray
    misread: FloatArray
    beside: tuple[tuple[FloatArray, FloatArray], ...] = ()
    course: FloatArray | None = None
    late: Mapping[int, Late] = field(default_factory=dict)
    taken: Mapping[int, float] = field(default_factory=dict)
    claimed: Claimed | None = field(default=None, repr=False)
    base: "GridRun | None" = field(default=None, repr=False)
    made: FloatArray | None = None
    settled_of: "GridRun | None" = field(default=None, repr=False)

    @property
    def first(self) -> int:
        """The first row that is predicted: all of the past that counts is known."""
        late = int(np.ceil(_LATE_S / self.period_s)) if self.late else 0
        return FORCES - 1 + late

    @property
    def added(self) -> "GridRun":
        """The run with the directions alone that its base has not."""
        count = 0 if self.base is None else self.base.more.shape[1]
        return replace(
            self,
            more=self.more[:, count:],
            heavier=self.heavier[count:],
            misread=self.misread[count:],
            late={k - count: one for k, one in self.late.items() if k >= count},
            taken={k - count: one for k, one in self.taken.items()},
        )

    @property
    def unsettled(self) -> "GridRun":
        """The run without directions at sizes, and without what a change makes of it."""
        plain = self if self.base is None else self.base
        return plain.settled_of or plain

    def of_directions(self, own: IntArray) -> "GridRun":
        """Keep the masses of some directions, and nothing else that they make."""
        none = np.zeros((len(self.velocity), own.size, 6))
        return replace(self, more=none, heavier=self.heavier[own], taken={})


def grid_periods(runs: Sequence[RunTable]) -> tuple[float, ...]:
    """Return the spacings that a grid may have: shares of a second, no nearer than readings [s]."""
    slowest = PERIODS_S[0]
    for run in runs:
        linear = "velocity" if "velocity" in completed(run).values else "depth"
        for quantity in (linear, "angular_velocity"):
            marks = run.reading.get(quantity)
            if marks is not None and marks.sum() > 2:
                slowest = max(slowest, float(np.median(np.diff(run.time_s[marks]))))
    return tuple(one for one in PERIODS_S if one > 0.9 * slowest) or PERIODS_S[-1:]


def on_grids(
    packed: PackedVehicle,
    run: RunTable,
    sensors: Sensors | None,
    directions: Sequence[Coordinate],
    periods_s: Sequence[float],
) -> list[GridRun]:
    """Put a run on grids, with the wrench of each direction.

    Raises
    ------
    CannotComputeError
        Without rates of turn or attitude, or for a run shorter than a second.
    """
    claimed = Claimed(packed, run, sensors)
    departures = [claimed.departure(one, one.side * STEP) for one in directions]
    beside = (
        supply_told(packed, run, sensors, directions),
        place_told(run, sensors, directions),
    )
    return [
        replace(_gridded(claimed, departures, period_s), beside=beside, claimed=claimed)
        for period_s in periods_s
    ]


def _gridded(
    claimed: Claimed,
    departures: Sequence[Departure],
    period_s: float,
) -> GridRun:
    run, motion, row_s = claimed.run, claimed.motion, claimed.row_s
    edges, rows = _rows_of(run, period_s, row_s)
    names: list[str] = []
    columns = []
    for quantity, own in (("velocity", CHANNELS[:3]), ("angular_velocity", CHANNELS[3:])):
        values = channel_of(run, quantity)
        if values is None:
            if quantity == "velocity" and motion.sunk_m is not None:  # heave, by the depth
                names.append("w")
                sinking = _sinking(motion.sunk_m, rows, row_s, period_s)
                columns.append((sinking / motion.upright[rows])[:, None])
            continue
        if quantity == "velocity":  # of the body's origin
            values -= claimed.of_turning
        names += own
        columns.append(_about(values, rows, row_s, period_s, run, quantity))
    course = None
    if motion.follows and len(names) == len(CHANNELS):
        course = _about(motion.nu, rows, row_s, period_s, run, "specific_force")
    attitude = _attitude(motion.state[:, 3:7], rows, row_s, period_s, run)
    count = len(departures)
    more, heavier = np.zeros((edges.size, count, 6)), np.zeros((count, 6, 6))
    misread = np.zeros((count, 3, 6))
    for k, one in enumerate(departures):
        more[:, k], heavier[k], misread[k] = _mean(one.wrench, rows), one.mass, one.misread
    late = {k: _on(one.late, rows) for k, one in enumerate(departures) if one.late}
    return GridRun(
        name=run.name,
        period_s=period_s,
        time_s=edges - run.time_s[0],
        channels=tuple(names),
        velocity=np.concatenate(columns, axis=1),
        course=course,
        attitude=attitude,
        down=down_axis(attitude),
        wrench=_mean(claimed.wrench, rows),
        more=more,
        heavier=heavier,
        misread=misread,
        late=late,
    )


def all_at(grids: Sequence[GridRun], added: Sequence[Added]) -> list[GridRun]:
    """Add directions that are taken at sizes.

    What is ordinary is small, and stays as it was taken; a change that is asked for need not be.

    Parameters
    ----------
    grids : sequence of GridRun
        One run on some grids, or several runs.
    added : sequence of Added
        The directions.
    """
    if not added:
        return list(grids)
    known: dict[int, list[Departure]] = {}
    found = []
    for grid in grids:
        claimed = grid.claimed
        assert claimed is not None  # noqa: S101 - of `on_grids`
        if id(claimed) not in known:
            known[id(claimed)] = [claimed.departure(one.direction, one.size) for one in added]
        found.append(_beside(grid, claimed, known[id(claimed)], added))
    return found


def _beside(
    grid: GridRun,
    claimed: Claimed,
    departures: Sequence[Departure],
    added: Sequence[Added],
) -> GridRun:
    _, rows = _rows_of(claimed.run, grid.period_s, claimed.row_s)
    count = grid.more.shape[1]
    # a supply or a place says nothing of what has no place among the others: a row of zeros
    places = [*range(count), *(-1 if one.of is None else one.of for one in added)]
    padded = [(np.pad(one, (0, 1)), np.pad(score, (0, 1))) for one, score in grid.beside]
    more = [_mean(one.wrench, rows)[:, None] for one in departures]
    late = {k: _on(one.late, rows) for k, one in enumerate(departures, count) if one.late}
    return replace(
        grid,
        more=np.concatenate([grid.more, *more], axis=1),
        heavier=np.concatenate([grid.heavier, [one.mass for one in departures]]),
        misread=np.concatenate([grid.misread, [one.misread for one in departures]]),
        late={**grid.late, **late},
        taken=dict(enumerate((one.size for one in added), start=count)),
        beside=tuple((one[np.ix_(places, places)], score[places]) for one, score in padded),
        base=grid,
    )


def _rows_of(run: RunTable, period_s: float, row_s: float) -> tuple[FloatArray, IntArray]:
    """Return the times of a grid, and the rows of the run there."""
    edges = np.arange(run.time_s[0], run.time_s[-1] + 1e-9, period_s)
    if edges.size < 1.0 / period_s:
        raise CannotComputeError(f"{run.name} is shorter than a second; nothing can be said of it.")
    steps = np.round((edges - edges[0]) / row_s).astype(int)
    return edges, np.minimum(steps, run.time_s.size - 1)


def _mean(values: FloatArray, rows: IntArray) -> FloatArray:
    """Mean over the period that ends at each row; the first row has the second's."""
    found = means_over(values, rows[:-1], np.maximum(rows[1:], rows[:-1] + 1))
    return np.concatenate([found[:1], found])


def _on(late: Late, rows: IntArray) -> Late:
    return Late(late.slip[rows], late.read[rows], late.true[rows], _mean(late.wrench, rows))


def _about(  # noqa: PLR0917 - one caller
    values: FloatArray,
    rows: IntArray,
    row_s: float,
    period_s: float,
    run: RunTable,
    quantity: str,
) -> FloatArray:
    """Values at the rows of the grid: means around them where readings are closer than these."""
    if run.pause_s(quantity) > 0.6 * period_s:
        return np.asarray(values[rows])
    half = max(round(period_s / row_s / 2.0), 1)
    return means_over(values, np.maximum(rows - half, 0), np.minimum(rows + half, len(values)))


def _sinking(sunk_m: FloatArray, rows: IntArray, row_s: float, period_s: float) -> FloatArray:
    """Mean rate (m,) at which a depth grows in the period around each row of the grid."""
    half = max(round(period_s / row_s / 2.0), 1)
    last, first = np.minimum(rows + half, len(sunk_m) - 1), np.maximum(rows - half, 0)
    return np.asarray((sunk_m[last] - sunk_m[first]) / ((last - first) * row_s))


def _attitude(
    values: FloatArray, rows: IntArray, row_s: float, period_s: float, run: RunTable
) -> FloatArray:
    """Quaternions (m, 4) at the rows of the grid, of means as velocities are.

    The moment that rights a vehicle which hardly rolls is mostly noise of one reading, and it does
    not answer to that: it would seem heavier.
    """
    found = _about(continuous(values), rows, row_s, period_s, run, "attitude")
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])
