"""What the commands of a run claim along its motion, and what an effect would add to that.

What an effect would add is a wrench: with the parameters of the effect the thrusters give another
thrust for the same codes, and the hull another force for the same motion,

    more = [tau_s(c, V) - tau_0(c, V)] - [D_s(nu', nu, R) - D_0(nu', nu, R)]

with D what a motion demands of the thrusters (`kernel_alone`). The part that goes with the
acceleration is kept apart: an acceleration that was measured holds what it is to explain.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.misread import misread
from pipeline.diagnose.regression.supply import course_of_drop
from pipeline.effects.library import apply_effects
from pipeline.effects.specification import EffectSpec
from pipeline.measured.completed import completed
from pipeline.measured.demand import demanded, known_wrench, settled
from pipeline.measured.inject import READINGS, layout
from pipeline.measured.lagging import lagged
from pipeline.measured.motion import measured_motion, reckoned, velocity_of
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable, continuous
from pipeline.simulate.applied_wrench import thruster_wrench
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors


@dataclass(frozen=True)
class Late:
    """Of a velocity that is read late, along a run.

    `slip` (rows, 3) is the turning that a unit takes off too early. `read` and `true` (rows, 3) are
    the velocity that is read and the one that it is by then, with little noise, and `wrench`
    (rows, 6) what a unit makes thrusters do: the rates, which are not late, answer to what is true.
    """

    slip: FloatArray
    read: FloatArray
    true: FloatArray
    wrench: FloatArray


@dataclass(frozen=True)
class Departure:
    """Of a unit of a direction: wrench (rows, 6), mass (6, 6), and what is misread (3, 6).

    Of a velocity that is read `late` the wrench acts on the linear velocities as they are read.
    """

    wrench: FloatArray
    mass: FloatArray
    misread: FloatArray
    late: Late | None = None


class Claimed:
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
        self._sensors = sensors
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

    def departure(self, one: Coordinate, size: float) -> Departure:
        """Return what a unit of a direction makes, taken at a size."""
        if one.within is None:
            return self._departure(one, size)
        alone, whole = self._departure(replace(one, within=None), size), self._departure(one, size)
        # a heavier vehicle resists what the effect moves, too
        effect = -demanded(self.packed, self._with(one, {}), self.motion, still=True) - self._hull
        moved = effect @ np.linalg.inv(mass_of(self._nominal)).T
        wrench = whole.wrench - alone.wrench - moved @ alone.mass.T
        return Departure(wrench, whole.mass - alone.mass, whole.misread)

    def _departure(self, one: Coordinate, size: float) -> Departure:
        packed, as_read = self.packed, np.zeros((3, 6))
        if one.effect.id == "thruster_degraded" and one.target is not None:
            column = packed.thruster_names.index(one.target)
            thrust = one.unit_size * self._thrust[:, column, None]
            return Departure(thrust * self._lever[:, column], np.zeros((6, 6)), as_read)
        least, most = one.parameter.possible
        value = float(np.clip(one.parameter.neutral + size * one.unit_size, least, most))
        share = (value - one.parameter.neutral) / one.unit_size
        changed = self._with(one, {**dict(one.beside), one.parameter.name: value})
        beside = bool(one.beside or one.within)
        before = self._with(one, dict(one.beside)) if beside else self._nominal
        if one.effect.id == "dvl_delay" and self._reads:
            wrench, late = self._late(float(read(changed, "dvl_delay")), share)
            return Departure(wrench / share, np.zeros((6, 6)), as_read, late)
        if one.effect.id in READINGS:
            if not self._reads:
                return Departure(np.zeros_like(self.wrench), np.zeros((6, 6)), as_read)
            as_read = misread(self._dvl, changed) - misread(self._dvl, before)
            thrust = self._thrust_of_misread(as_read)
            return Departure(thrust / share, np.zeros((6, 6)), as_read / share)
        if one.effect.of_thrusters or one.target is not None:
            pushed, without = (
                _pushed(packed, vector, self._codes, self.motion.nu, self.row_s)[0]
                if vector is not self._nominal
                else self._pushed
                for vector in (changed, before)
            )
            added = pushed - without
            if one.effect.id == "voltage_sag" and one.parameter.name == "drop":
                added *= course_of_drop(self.run, self._sensors)[:, None]
        else:
            added = -demanded(packed, changed, self.motion, still=True) - self._hull
            if beside:
                added += demanded(packed, before, self.motion, still=True) + self._hull
        mass = (mass_of(changed) - mass_of(before)) / share
        return Departure(added / share, mass, as_read)

    def _with(self, one: Coordinate, values: Mapping[str, float]) -> FloatArray:
        """Parameter vector under values of the effect of a direction."""
        specs = [EffectSpec(one.effect.id, dict(values), one.target)]
        specs += [] if one.within is None else [one.within]
        return settled(apply_effects(self.packed.vector, specs, self.packed.context))

    def _thrust_of_misread(self, as_read: FloatArray) -> FloatArray:
        """Wrench (rows, 6) of commands at the velocity that is misread so (3, 6), less as read."""
        nu = self.motion.nu.copy()
        of_rates = nu[:, 3:] @ as_read[:, 3:].T
        nu[:, :3] = np.linalg.solve(np.eye(3) + as_read[:, :3], (nu[:, :3] - of_rates).T).T
        return _pushed(self.packed, self._nominal, self._codes, nu, self.row_s)[0] - self._pushed

    def _late(self, delay_s: float, units: float) -> tuple[FloatArray, Late]:
        """Wrench (rows, 6) of commands, rates and attitude so long ago, less that of now."""
        rows = np.arange(self.run.time_s.size, dtype=float)
        true = velocity_of(_read_earlier(self.run, delay_s), self._sensors, self.motion)

        def ago(values: FloatArray) -> FloatArray:
            before = rows - delay_s / self.row_s
            return np.stack([np.interp(before, rows, one) for one in values.T], axis=1)

        by_then = self.motion.state.copy()
        by_then[:, 3:7], by_then[:, 7:10] = continuous(by_then[:, 3:7]), true
        then, now = ago(by_then), by_then.copy()
        then[:, 3:7] /= np.linalg.norm(then[:, 3:7], axis=1)[:, None]
        now[:, 7:10] = then[:, 7:10]

        def hull(state: FloatArray) -> FloatArray:
            moved = replace(self.motion, state=state)
            return -demanded(self.packed, self._nominal, moved, still=True)

        def pushed(codes: FloatArray, state: FloatArray) -> FloatArray:
            own = _pushed(self.packed, self._nominal, codes, state[:, 7:13], self.row_s)[0]
            return own - self._pushed

        known, slip = self.wrench - self._pushed, ago(self.of_turning) - self.of_turning
        late = Late(slip / units, then[:, 7:10] + slip, true, pushed(self._codes, by_then) / units)
        wrench = pushed(ago(self._codes), then) + ago(known) - known + hull(then) - hull(now)
        return wrench, late


def _read_earlier(run: RunTable, late_s: float) -> RunTable:
    """Return a run whose readings of the velocity stand so much earlier."""
    rows = np.arange(run.time_s.size) + round(late_s / run.period_s)
    have = rows < run.time_s.size
    rows = np.minimum(rows, run.time_s.size - 1)
    marks = run.reading.get("velocity")
    return replace(
        run,
        values={**run.values, "velocity": run.values["velocity"][rows]},
        valid={**run.valid, "velocity": run.valid["velocity"][rows] & have},
        reading=run.reading if marks is None else {**run.reading, "velocity": marks[rows] & have},
    )


def _pushed(
    packed: PackedVehicle, vector: FloatArray, codes: FloatArray, nu: FloatArray, row_s: float
) -> tuple[FloatArray, FloatArray]:
    """Wrench (m, 6) and thrusts (m, n) of commands."""
    acting = lagged(vector, codes, row_s)
    return thruster_wrench(packed, acting, nu, vector=vector)
