"""A run on an even grid: velocities, attitude, and the wrench that its commands claim.

What an effect would add is a wrench, too: with the parameters of the effect the thrusters give
another thrust for the same codes, and the hull another force for the same motion,

    more = [tau_s(c, V) - tau_0(c, V)] - [D_s(nu', nu, R) - D_0(nu', nu, R)]

with D what a motion demands of the thrusters (`kernel_alone`). The part that goes with the
acceleration is kept apart: an acceleration that was measured holds what it is to explain.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.diagnose.coordinates import Added, Coordinate
from pipeline.diagnose.regression.misread import misread
from pipeline.diagnose.regression.place import place_told
from pipeline.diagnose.regression.supply import supply_told
from pipeline.effects.library import apply_effects
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.measured.completed import completed
from pipeline.measured.demand import demanded, known_wrench, settled
from pipeline.measured.inject import READINGS, layout
from pipeline.measured.lagging import lagged
from pipeline.measured.motion import channel_of, measured_motion, reckoned
from pipeline.physics.parameters import read
from pipeline.physics.window_sums import means_over
from pipeline.records.run_table import RunTable, continuous, down_axis
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

CHANNELS = ("u", "v", "w", "p", "q", "r")
#: Rows of the grid may be so far apart. [s]
PERIODS_S = (1 / 10, 1 / 5, 1 / 4, 1 / 3, 1 / 2)
#: Departure, in units of half the plausible range, at which a wrench is taken.
_STEP = 1.0


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
    the module; `late` is the slip (m, 3) by turning of a unit of each direction that makes readings
    late; `claimed` is what they are taken from.
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
    late: Mapping[int, FloatArray] = field(default_factory=dict)
    taken: Mapping[int, float] = field(default_factory=dict)
    claimed: "_Claimed | None" = field(default=None, repr=False)
    base: "GridRun | None" = field(default=None, repr=False)

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
    claimed = _Claimed(packed, run, sensors)
    departures = [claimed.departure(one, one.side * _STEP) for one in directions]
    beside = (
        supply_told(packed, run, sensors, directions),
        place_told(run, sensors, directions),
    )
    return [
        replace(_gridded(claimed, departures, period_s), beside=beside, claimed=claimed)
        for period_s in periods_s
    ]


def _gridded(
    claimed: "_Claimed",
    departures: Sequence["_Departure"],
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
    late = {k: one.slip[rows] for k, one in enumerate(departures) if one.slip is not None}
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
    known: dict[int, list[_Departure]] = {}
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
    claimed: "_Claimed",
    departures: Sequence["_Departure"],
    added: Sequence[Added],
) -> GridRun:
    _, rows = _rows_of(claimed.run, grid.period_s, claimed.row_s)
    count = grid.more.shape[1]
    # a supply or a place says nothing of what has no place among the others: a row of zeros
    places = [*range(count), *(-1 if one.of is None else one.of for one in added)]
    padded = [(np.pad(one, (0, 1)), np.pad(score, (0, 1))) for one, score in grid.beside]
    more = [_mean(one.wrench, rows)[:, None] for one in departures]
    late = {k: one.slip[rows] for k, one in enumerate(departures, count) if one.slip is not None}
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


@dataclass(frozen=True)
class _Departure:
    """Of a unit of a direction: wrench (rows, 6), mass (6, 6), and what is misread (3, 6).

    Of a velocity that is read late `slip` (rows, 3) is the turning that is taken off too early; the
    wrench then acts on the linear velocities as they are read, and on no moment.
    """

    wrench: FloatArray
    mass: FloatArray
    misread: FloatArray
    slip: FloatArray | None = None


class _Claimed:
    """What the commands of a run claim along its motion, and what an effect would add.

    `of_turning` (rows, 3) is what the DVL reads of the turning alone, away from the origin.
    """

    def __init__(self, packed: PackedVehicle, run: RunTable, sensors: Sensors | None) -> None:
        self._reads = "velocity" in run.values
        run = completed(run)
        self.packed, self.run = packed, run
        self._dvl = sensors.dvl if sensors and self._reads else None
        if sensors is not None and not self._reads:
            sensors = sensors.model_copy(update={"dvl": None})
        self.motion = reckoned(measured_motion(run, sensors))
        self.row_s = run.period_s
        place = self._dvl.position_m if self._dvl else (0.0, 0.0, 0.0)
        self.of_turning = np.cross(self.motion.nu[:, 3:], np.array(place))
        self._nominal = settled(packed.vector)
        self._codes = np.nan_to_num(np.array(run.values["command"], float))
        self._pushed, self._thrust = _pushed(
            packed, self._nominal, self._codes, self.motion.nu, self.row_s
        )
        self.wrench = self._pushed + known_wrench(packed, run, self.motion)
        self._hull = -demanded(packed, self._nominal, self.motion, still=True)
        self._lever = layout(packed, self._nominal)

    def departure(self, one: Coordinate, size: float) -> _Departure:
        """Return what a unit of a direction makes, taken at a size."""
        packed, as_read = self.packed, np.zeros((3, 6))
        if one.effect.id == "thruster_degraded" and one.target is not None:
            column = packed.thruster_names.index(one.target)
            thrust = one.unit_size * self._thrust[:, column, None]
            return _Departure(thrust * self._lever[:, column], np.zeros((6, 6)), as_read)
        least, most = one.parameter.possible
        value = float(np.clip(one.parameter.neutral + size * one.unit_size, least, most))
        share = (value - one.parameter.neutral) / one.unit_size
        changed = self._with(one, {**dict(one.beside), one.parameter.name: value})
        before = self._with(one, dict(one.beside)) if one.beside else self._nominal
        if one.effect.id == "dvl_delay" and self._reads:
            wrench, slip = self._late(float(read(changed, "dvl_delay")))
            return _Departure(wrench / share, np.zeros((6, 6)), as_read, slip / share)
        if one.effect.id in READINGS:
            if not self._reads:
                return _Departure(np.zeros_like(self.wrench), np.zeros((6, 6)), as_read)
            as_read = misread(self._dvl, changed) - misread(self._dvl, before)
            thrust = self._thrust_of_misread(as_read)
            return _Departure(thrust / share, np.zeros((6, 6)), as_read / share)
        if one.effect.of_thrusters or one.target is not None:
            pushed, without = (
                _pushed(packed, vector, self._codes, self.motion.nu, self.row_s)[0]
                if vector is not self._nominal
                else self._pushed
                for vector in (changed, before)
            )
            added = pushed - without
        else:
            added = -demanded(packed, changed, self.motion, still=True) - self._hull
            if one.beside:
                added += demanded(packed, before, self.motion, still=True) + self._hull
        mass = (mass_of(changed) - mass_of(before)) / share
        return _Departure(added / share, mass, as_read)

    def _with(self, one: Coordinate, values: Mapping[str, float]) -> FloatArray:
        """Parameter vector under values of the effect of a direction."""
        spec = EffectSpec(one.effect.id, dict(values), one.target)
        return settled(apply_effects(self.packed.vector, [spec], self.packed.context))

    def _thrust_of_misread(self, as_read: FloatArray) -> FloatArray:
        """Wrench (rows, 6) of commands at the velocity that is misread so (3, 6), less as read."""
        nu = self.motion.nu.copy()
        of_rates = nu[:, 3:] @ as_read[:, 3:].T
        nu[:, :3] = np.linalg.solve(np.eye(3) + as_read[:, :3], (nu[:, :3] - of_rates).T).T
        return _pushed(self.packed, self._nominal, self._codes, nu, self.row_s)[0] - self._pushed

    def _late(self, delay_s: float) -> tuple[FloatArray, FloatArray]:
        """Wrench (rows, 6) of commands, rates and attitude so long ago, less that of now.

        Besides, what the DVL's place makes of the rates (rows, 3), then less now.
        """
        rows = np.arange(self.run.time_s.size)
        before = np.clip(rows - delay_s / self.row_s, 0.0, rows[-1])

        def ago(values: FloatArray) -> FloatArray:
            return np.stack([np.interp(before, rows, one) for one in values.T], axis=1)

        state = self.motion.state.copy()
        state[:, 3:7] = ago(continuous(state[:, 3:7]))
        state[:, 3:7] /= np.linalg.norm(state[:, 3:7], axis=1)[:, None]
        state[:, 10:13] = ago(state[:, 10:13])
        # the velocity that was read goes with them
        hull = -demanded(self.packed, self._nominal, replace(self.motion, state=state), still=True)
        pushed, _ = _pushed(
            self.packed, self._nominal, ago(self._codes), state[:, 7:13], self.row_s
        )
        known = self.wrench - self._pushed
        slip = ago(self.of_turning) - self.of_turning
        return pushed - self._pushed + ago(known) - known + hull - self._hull, slip


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


def _pushed(
    packed: PackedVehicle, vector: FloatArray, codes: FloatArray, nu: FloatArray, row_s: float
) -> tuple[FloatArray, FloatArray]:
    """Wrench (m, 6) and thrusts (m, n) of commands."""
    acting = lagged(vector, codes, row_s)
    return thruster_wrench(packed, acting, nu, vector=vector)
