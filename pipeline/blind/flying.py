"""Fly the runs of a case: the true vehicle with what is wrong with it, and read its instruments."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.blind.draws import Drawn, draw
from pipeline.blind.outside import TROUBLES, Hit, Trouble, draw_trouble
from pipeline.blind.subject import BlindSubject
from pipeline.blind.truth.craft import Craft, craft_of
from pipeline.blind.truth.faults import with_fault
from pipeline.blind.truth.flight import TruthFlight, fly_craft, still
from pipeline.blind.truth.kernel_flight import CONTROL_S, Belief
from pipeline.blind.truth.manoeuvres import Scene, belief_of, scene_of, wishes_of
from pipeline.blind.truth.sensors import Log, SensorReading, Weather, background, read_all
from pipeline.errors import CannotComputeError
from pipeline.records.run_table import OffRow, RunTable, mean_held
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.sensor_schema import Sensors

#: A gap of more than so many periods is not bridged.
BRIDGED_PERIODS = 2.5
#: Quantity -> instrument and its columns.
_PARTS = {
    "angular_velocity": ("imu", slice(0, 3)),
    "specific_force": ("imu", slice(3, 6)),
    "attitude": ("imu", slice(6, 10)),
    "velocity": ("dvl", slice(0, 3)),
    "depth": ("depth", slice(0, 1)),
    "position": ("position", slice(0, 3)),
    "shaft_speed": ("shaft_speed", slice(None)),
    "voltage": ("voltage", slice(0, 1)),
}

START_TIME_NS = 1_750_000_000_000_000_000
#: A vehicle that leans further is no longer under control. [rad]
LARGEST_TILT = 1.1
#: A vehicle that leaves its pool by so much has broken away. [m]
LARGEST_DRIFT_M = 30.0

Fault = Drawn | Trouble


def table_of(
    log: Log, thrusters: tuple[str, ...], name: str, start_time_ns: int, period_s: float = 0.02
) -> RunTable:
    """Put readings onto one time base; lines between readings, commands held.

    Not a number where nothing is valid. `thrusters` name the columns of the commands,
    `start_time_ns` is time zero on the clock of the log [ns].
    """
    command = log["command"]
    end = float(command.logged_s[-1])
    time_s = np.asarray(np.arange(int(end / period_s + 1e-6) + 1) * period_s, np.float64)
    held = mean_held(command.stamp_s, command.values, time_s, period_s)
    values: dict[str, FloatArray] = {"command": held}
    valid: dict[str, BoolArray] = {"command": time_s + 0.5 * period_s >= command.stamp_s[0]}
    reading: dict[str, BoolArray] = {"command": _nearest(command.stamp_s, time_s)}
    off_row: dict[str, OffRow] = {}
    for quantity, (instrument, columns) in _PARTS.items():
        if instrument not in log or log[instrument].stamp_s.size < 2:
            continue
        source = log[instrument]
        values[quantity], valid[quantity] = _placed(source, source.values[:, columns], time_s)
        if quantity == "attitude":
            values[quantity] /= np.linalg.norm(values[quantity], axis=1, keepdims=True)
        reading[quantity] = _nearest(source.stamp_s, time_s) & valid[quantity]
        off = OffRow.of(time_s, values[quantity], source.stamp_s, source.values[:, columns])
        if off is not None:
            off_row[quantity] = off
    return RunTable(
        name,
        time_s,
        values,
        valid,
        reading=reading,
        off_row=off_row,
        thrusters=thrusters,
        start_time_ns=start_time_ns,
    )


def _placed(
    source: SensorReading, columns: FloatArray, time_s: FloatArray
) -> tuple[FloatArray, BoolArray]:
    stamp = source.stamp_s
    if columns.shape[1] == 4:
        # the same turn with the other sign would be interpolated the long way round
        flips = np.where((columns[1:] * columns[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
        columns = columns * np.concatenate([[1.0], np.cumprod(flips)])[:, None]
    out = np.stack([np.interp(time_s, stamp, column) for column in columns.T], axis=1)
    after = np.searchsorted(stamp, time_s - 1e-9)
    there = (time_s >= stamp[0] - 1e-9) & (after < stamp.size)
    high = np.clip(after, 1, stamp.size - 1)
    usual = float(np.median(np.diff(stamp)))
    exact = np.abs(stamp[np.clip(after, 0, stamp.size - 1)] - time_s) < 1e-9
    there &= exact | (stamp[high] - stamp[high - 1] <= BRIDGED_PERIODS * usual)
    out[~there] = np.nan
    return out, np.asarray(there)


def _nearest(stamp: FloatArray, time_s: FloatArray) -> BoolArray:
    index = np.rint(stamp / (time_s[1] - time_s[0])).astype(int)
    out = np.zeros(time_s.size, np.bool_)
    out[index[(index >= 0) & (index < time_s.size)]] = True
    return out


class VehicleLost(Exception):  # noqa: N818 (it is the vehicle that is lost, no error of the program)
    """The vehicle went out of control."""


@dataclass(frozen=True)
class CaseWorld:
    """Everything that the runs of a case have in common."""

    stated: Craft
    belief: Belief
    scene: Scene
    sensors: Sensors
    weather: Weather


@dataclass(frozen=True)
class Patient:
    """The healthy vehicle, what is wrong with it, and how large each fault is."""

    well: Craft
    faults: tuple[Fault, ...] = ()
    sizes: tuple[float, ...] = ()

    def without(self, k: int) -> Craft:
        """Return the vehicle with all of its library faults but fault k."""
        craft = self.well
        for place, (fault, size) in enumerate(zip(self.faults, self.sizes, strict=True)):
            if place != k and isinstance(fault, Drawn):
                craft = with_fault(craft, fault.effect, fault.at(size), fault.thruster)
        return craft


@dataclass(frozen=True)
class FlownCase:
    """A run of the true vehicle: craft, motion, forces from outside."""

    craft: Craft
    flight: TruthFlight
    outside: FloatArray


def stage_of(subject: BlindSubject, missing: Sequence[str], weather: Weather) -> CaseWorld:
    """Set up a vehicle with some of its instruments missing."""
    vehicle = subject.vehicle
    if vehicle.model is None or vehicle.sensors is None:
        raise CannotComputeError(f"{vehicle.name} has no model: or no sensors: section")
    stated = craft_of(vehicle, subject.static)
    sensors = vehicle.sensors.model_copy(update=dict.fromkeys(missing))
    return CaseWorld(stated, belief_of(stated), scene_of(stated), sensors, weather)


def fault_of(
    what: str, stage: CaseWorld, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Fault:
    """Draw a fault, of the library or outside of it."""
    if what in TROUBLES:
        return draw_trouble(what, stage.stated, stage.scene, durations_s, rng)
    return draw(what, stage.stated, stage.scene, rng)


def _hit(craft: Craft, fault: Fault, size: float, run: int, count: int) -> Hit:
    if isinstance(fault, Trouble):
        return fault.hit(craft, size, run, count)
    return with_fault(craft, fault.effect, fault.at(size), fault.thruster), None, None


def children(seeds: np.random.SeedSequence, count: int) -> list[np.random.SeedSequence]:
    """Seeds of the parts, the same however often they are asked for."""
    return [
        np.random.SeedSequence(seeds.entropy, spawn_key=(*seeds.spawn_key, k)) for k in range(count)
    ]


def fly_all(
    stage: CaseWorld,
    patient: Patient,
    kinds: Sequence[str],
    duration_s: float,
    seeds: np.random.SeedSequence,
) -> list[FlownCase]:
    """Fly runs of the true vehicle with its faults.

    Raises `VehicleLost` when it does not stay under control.
    """
    return [
        fly_one(stage, patient, kind, run=run, duration_s=duration_s, seed=seed)
        for run, (kind, seed) in enumerate(zip(kinds, children(seeds, len(kinds)), strict=True))
    ]


def fly_one(
    stage: CaseWorld,
    patient: Patient,
    kind: str,
    *,
    run: int,
    duration_s: float,
    seed: np.random.SeedSequence,
) -> FlownCase:
    """Fly one run; as `fly_all`."""
    rng = np.random.default_rng(seed)
    wishes, heading = wishes_of(kind, stage.scene, duration_s, rng)
    count = len(wishes)
    craft = patient.well
    outside = background(craft, stage.weather, count + 1, CONTROL_S, rng)
    gains: FloatArray | None = None
    for fault, size in zip(patient.faults, patient.sizes, strict=True):
        craft, force, lost = _hit(craft, fault, size, run, count)
        if force is not None:
            outside = outside + force
        if lost is not None:
            gains = lost if gains is None else gains * lost
    start = still(np.array([0.0, 0.0, stage.scene.depth_m]), heading)
    flight = fly_craft(
        craft, stage.belief, wishes=wishes, outside=outside, gains=gains, start=start
    )
    if flight.turn[:, 2, 2].min() < np.cos(LARGEST_TILT) or flight.place[:, 2].min() < -1.0:
        raise VehicleLost
    if stage.scene.pool and np.abs(flight.place[:, :2]).max() > LARGEST_DRIFT_M:
        raise VehicleLost
    return FlownCase(craft, flight, outside)


def read_runs(
    stage: CaseWorld, flown: Sequence[FlownCase], name: str, seeds: np.random.SeedSequence
) -> tuple[list[RunTable], dict[str, Log]]:
    """Read the instruments on all runs: tables, and logs by name of the run."""
    tables: list[RunTable] = []
    logs: dict[str, Log] = {}
    # the first thousand seeds flew the runs
    noises = children(seeds, 1000 + len(flown))[1000:]
    for k, (one, seed) in enumerate(zip(flown, noises, strict=True)):
        called = f"{name}_{k + 1}"
        log = read_all(
            one.flight,
            one.craft,
            stage.sensors,
            weather=stage.weather,
            rng=np.random.default_rng(seed),
            supply=supply_of(one.craft, one.flight.commands),
        )
        logs[called] = log
        start = START_TIME_NS + (k + (10 if name == "run" else 0)) * 3_600_000_000_000
        tables.append(table_of(log, one.craft.names, called, start))
    return tables, logs


def supply_of(craft: Craft, commands: FloatArray) -> FloatArray:
    """Share of the nominal supply voltage at each command (m,)."""
    load = ((commands / craft.code_max) ** 2).mean(axis=1)
    return np.asarray(1.0 - craft.supply_drop - craft.load_drop * load)
