"""A run on an even grid: velocities, attitude, and the wrench that its commands claim.

What an effect would add is a wrench, too: with the parameters of the effect the thrusters give
another thrust for the same codes, and the hull another force for the same motion,

    more = [tau_s(c, V) - tau_0(c, V)] - [D_s(nu', nu, R) - D_0(nu', nu, R)]

with D what a motion demands of the thrusters (`kernel_demand`). The part that goes with the
acceleration is kept apart: an acceleration that was measured holds what it is to explain.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.effects.library import apply_effects
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.measured.inject import layout
from pipeline.measured.lagging import lagged
from pipeline.measured.motion import channel_of, measured_motion
from pipeline.physics.parameters import write
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.kernel_demand import demand_along
from pipeline.simulate.kernel_hull import mass_matrix
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

CHANNELS = ("u", "v", "w", "p", "q", "r")
#: Rows of the grid are so far apart as the readings, but no nearer and no farther. [s]
SHORTEST_S, LONGEST_S = 0.1, 0.25
#: Departure, in units of half the plausible range, at which a wrench is taken.
_STEP = 1.0


@dataclass(frozen=True)
class GridRun:
    """A run at times `period_s` apart.

    `channels` are the velocities that were measured, in the order of `velocity` (m, v); `down`
    (m, 3) is the direction of gravity in body axes, `wrench` (m, 6) the mean wrench of the
    thrusters over the period that ends at a row. For each direction `more` (m, d, 6) is the mean
    wrench of a unit of it but for what goes with the acceleration, and `heavier` (d, 6, 6) the mass
    that a unit adds. `attitude` (m, 4) is the quaternion from body to NED.
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


def grid_period(runs: Sequence[RunTable]) -> float:
    """Return the spacing of the slowest velocity readings of some runs, within limits [s]."""
    found = [SHORTEST_S]
    for run in runs:
        for quantity in ("velocity", "angular_velocity"):
            marks = run.reading.get(quantity)
            if marks is not None and marks.sum() > 2:
                found.append(float(np.median(np.diff(run.time_s[marks]))))
    return float(np.clip(max(found), SHORTEST_S, LONGEST_S))


def on_grid(
    packed: PackedVehicle,
    run: RunTable,
    sensors: Sensors | None,
    directions: Sequence[Coordinate],
    period_s: float,
) -> GridRun:
    """Put a run on a grid, with the wrench of each direction.

    Raises
    ------
    CannotComputeError
        Without rates of turn or attitude, or for a run shorter than a second.
    """
    motion = measured_motion(run, sensors)
    row_s = float(np.median(np.diff(run.time_s)))
    edges = np.arange(run.time_s[0], run.time_s[-1] + 1e-9, period_s)
    if edges.size < 1.0 / period_s:
        raise CannotComputeError(f"{run.name} is shorter than a second; nothing can be told of it.")
    rows = np.minimum(np.round((edges - edges[0]) / row_s).astype(int), run.time_s.size - 1)

    def mean(values: FloatArray) -> FloatArray:
        """Mean over the period that ends at each row; the first row has the second's."""
        total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
        steps = np.maximum(np.diff(rows), 1).reshape(-1, *[1] * (values.ndim - 1))
        found = (total[rows[1:]] - total[rows[:-1]]) / steps
        return np.concatenate([found[:1], found])

    names: list[str] = []
    columns = []
    for quantity, own in (("velocity", CHANNELS[:3]), ("angular_velocity", CHANNELS[3:])):
        values = channel_of(run, quantity)
        if values is None:
            continue
        names += own
        columns.append(_about(values, rows, row_s, period_s, run, quantity))
    w, x, y, z = motion.state[rows, 3:7].T
    down = np.stack(
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)], axis=1
    )
    nominal = _settled(packed.vector)
    codes = np.nan_to_num(np.array(run.values["command"], float))
    wrench, thrust = _pushed(packed, nominal, codes, motion.nu, row_s)
    still = np.zeros_like(motion.nu_dot)
    hull = -_demand(packed, nominal, motion.state, still)
    lever = layout(packed, nominal)
    more, heavier = [], []
    for one in directions:
        if one.effect.id == "thruster_degraded" and one.target is not None:
            column = packed.thruster_names.index(one.target)
            more.append(mean(one.unit_size * thrust[:, column, None] * lever[:, column]))
            heavier.append(np.zeros((6, 6)))
            continue
        step = np.sign(one.step) * _STEP
        value = one.parameter.neutral + step * one.unit_size
        least, most = one.parameter.possible
        value = float(np.clip(value, least, most))
        share = (value - one.parameter.neutral) / one.unit_size
        spec = EffectSpec(one.effect.id, {one.parameter.name: value}, one.target)
        changed = _settled(apply_effects(packed.vector, [spec], packed.context))
        added = np.zeros_like(wrench)
        if one.effect.of_thrusters or one.target is not None:
            added += _pushed(packed, changed, codes, motion.nu, row_s)[0] - wrench
        else:
            added -= _demand(packed, changed, motion.state, still) + hull
        more.append(mean(added / share))
        heavier.append((_mass(changed) - _mass(nominal)) / share)
    return GridRun(
        name=run.name,
        period_s=period_s,
        time_s=edges - run.time_s[0],
        channels=tuple(names),
        velocity=np.concatenate(columns, axis=1),
        attitude=motion.state[rows, 3:7],
        down=down,
        wrench=mean(wrench),
        more=np.stack(more, axis=1) if more else np.zeros((edges.size, 0, 6)),
        heavier=np.stack(heavier) if heavier else np.zeros((0, 6, 6)),
    )


def mass_of_file(packed: PackedVehicle) -> FloatArray:
    """Mass matrix (6, 6) of the vehicle file, the water that moves with it included."""
    return _mass(packed.vector)


def _about(  # noqa: PLR0917 - one caller
    values: FloatArray,
    rows: IntArray,
    row_s: float,
    period_s: float,
    run: RunTable,
    quantity: str,
) -> FloatArray:
    """Values at the rows of the grid: means around them where readings are closer than these."""
    marks = run.reading.get(quantity)
    spacing = row_s
    if marks is not None and marks.sum() > 2:
        spacing = float(np.median(np.diff(run.time_s[marks])))
    if spacing > 0.6 * period_s:
        return np.asarray(values[rows])
    half = max(round(period_s / row_s / 2.0), 1)
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    last = np.minimum(rows + half, len(values))
    first = np.maximum(rows - half, 0)
    return np.asarray((total[last] - total[first]) / (last - first)[:, None])


def _settled(vector: FloatArray) -> FloatArray:
    """Parameters of thrusters whose shafts have settled."""
    found = vector.copy()
    write(found, "rotor_inertia", 0.0)
    return found


def _pushed(
    packed: PackedVehicle, vector: FloatArray, codes: FloatArray, nu: FloatArray, row_s: float
) -> tuple[FloatArray, FloatArray]:
    """Wrench (m, 6) and thrusts (m, n) of commands."""
    acting = lagged(packed, vector, codes, row_s)
    return thruster_wrench(packed, acting, nu, vector=vector)


def _demand(
    packed: PackedVehicle, vector: FloatArray, state: FloatArray, rate: FloatArray
) -> FloatArray:
    out = np.zeros((len(state), 6))
    demand_along(vector, np.ascontiguousarray(state), rate, packed.strips, out)
    return out


def _mass(vector: FloatArray) -> FloatArray:
    found = np.zeros((6, 6))
    mass_matrix(vector, 1.0, found)
    return found
