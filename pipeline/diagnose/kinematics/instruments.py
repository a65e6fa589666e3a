"""Errors of the instruments that they show of each other, whatever moves the vehicle.

A model that does not fit the vehicle can hide an error of the DVL behind forces that are not there,
or its flaws behind such an error. Position, depth and attitude know better, and take no model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.judging.hypotheses import Finding, groups_of, screen, with_ordinary
from pipeline.diagnose.judging.pairs import pairs
from pipeline.diagnose.kinematics.dead_reckoning import ERRORS, MEASUREMENT, mount_of, track_of
from pipeline.diagnose.kinematics.dvl_errors import Reckoning, reckoning
from pipeline.diagnose.linear.coordinates import Coordinate, coordinates
from pipeline.diagnose.linear.elimination import Marginal
from pipeline.diagnose.linear.evidence import Prior, posterior
from pipeline.effects.effect import Effect
from pipeline.effects.library import candidates
from pipeline.effects.specification import EffectSpec
from pipeline.records.diagnosis import ParameterEstimate
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

#: Log evidence by which an error must lead none, and a second one the first alone.
_SURE = 10.0
#: Another error that is behind the first by less cannot be told from it.
_ALIKE = 5.0
#: What an instrument that is well may be off by, in the order of `ERRORS`: s, m, deg, 1. DVLs are
#: within 1 % and mounts within half a degree (Kinsey and Whitcomb 2007).
_TOLERANCE = np.array([0.02, 0.05, 0.05, 0.05, 0.5, 0.5, 0.5, 0.01])
#: Times that it may be when healthy runs show by how much it is.
_ON_HEALTHY_RUNS = 5.0
_NORMAL_95 = 1.959964
_MOST_EFFECTS = 4


@dataclass(frozen=True)
class InstrumentErrors:
    """What is wrong with the instruments.

    `specs` are the effects as they are switched on, `parameters` the values of each with intervals;
    `log_evidence` is over instruments that are well; `alike` are errors that could be it as well.
    """

    specs: tuple[EffectSpec, ...]
    parameters: Mapping[str, Mapping[str, ParameterEstimate]]
    log_evidence: float
    alike: tuple[str, ...] = ()

    @property
    def effects(self) -> tuple[str, ...]:
        """Ids, in alphabetical order."""
        return tuple(sorted(one.id for one in self.specs))


def instrument_errors(
    vehicle: Vehicle,
    packed: PackedVehicle,
    effects: Mapping[str, Effect],
    runs: Sequence[RunTable],
    healthy: Sequence[RunTable],
) -> InstrumentErrors | None:
    """Find errors of the DVL that dead reckoning is sure of.

    Parameters
    ----------
    vehicle, packed
        The vehicle as its file states it.
    effects : mapping of str to Effect
        Candidates. Of an error that is none of them nothing is said, but its traces are not taken
        for another's.
    runs, healthy : sequence of RunTable
        The runs to be explained, and those of the vehicle when it was well: what the instruments
        were off by then is not wrong.

    Returns
    -------
    InstrumentErrors or None
        None where nothing is wrong for sure, or nothing can be compared.
    """
    library = candidates(packed.context)
    sensors = vehicle.sensors if vehicle.sensors is not None else Sensors()
    through_water = sensors.dvl is not None and sensors.dvl.water_track
    if through_water or not set(library) >= MEASUREMENT:
        return None
    every = coordinates(packed, {name: library[name] for name in MEASUREMENT}, Uncertainty())
    order = [_place(one) for one in every]
    unit = np.array([one.unit_size for one in every])[np.argsort(order)]
    found = _marginal(runs, sensors, unit, order)
    if found is None:
        return None
    tolerance = (_TOLERANCE / unit)[order]
    prior = Prior(np.zeros(len(every)), np.diag(tolerance**2))
    well = _marginal(healthy, sensors, unit, order) if healthy else None
    if well is not None:
        wider = Prior(prior.mean, prior.covariance * _ON_HEALTHY_RUNS**2)
        prior = posterior(well, wider)
    groups = groups_of(every)
    absent = [k for k, one in enumerate(every) if one.effect.id not in effects]
    prior.covariance[absent, absent] += 1.0
    ground = with_ordinary(found, prior)
    tried = {group: own for group, own in groups.items() if group[0] in effects}
    singles = screen(ground, every, tried)
    best = _surest(singles, pairs(ground, every, tried, singles, _MOST_EFFECTS))
    return None if best is None else _told(best, singles, every)


def _place(one: Coordinate) -> int:
    """Place of a parameter among `ERRORS`."""
    names = [(effect, parameter) for effect, parameter, _, _ in ERRORS]
    return names.index((one.effect.id, one.parameter.name))


def _marginal(
    runs: Sequence[RunTable], sensors: Sensors, unit: FloatArray, order: Sequence[int]
) -> Marginal | None:
    """Sum up what runs say of the departures, in the order of the coordinates."""
    tracks = [one for one in (track_of(run, sensors) for run in runs) if one is not None]
    wander = 0.0 if sensors.imu is None else sensors.imu.attitude_wander_rad
    told: Reckoning | None = reckoning(tracks, mount_of(sensors), unit, wander) if tracks else None
    if told is None:
        return None
    index = np.array(order)
    return Marginal(told.information[np.ix_(index, index)], told.score[index], 0.0, 0.0)


def _surest(singles: Sequence[Finding], both: Sequence[Finding]) -> Finding | None:
    """Take the error, or the two errors, that lead by enough."""
    first = singles[0] if singles and singles[0].log_evidence >= _SURE else None
    second = both[0] if both else None
    alone = 0.0 if first is None else first.log_evidence
    if second is not None and second.log_evidence >= alone + _SURE:
        return second
    return first


def _told(
    best: Finding, singles: Sequence[Finding], every: Sequence[Coordinate]
) -> InstrumentErrors:
    parameters: dict[str, dict[str, ParameterEstimate]] = {}
    values: dict[str, dict[str, float]] = {}
    for index, mean, std in zip(best.which, best.mean, best.std, strict=True):
        one = every[index]
        value = one.parameter.neutral + one.unit_size * float(mean)
        half = _NORMAL_95 * one.unit_size * float(std)
        parameters.setdefault(one.effect.id, {})[one.parameter.name] = ParameterEstimate(
            value=value, unit=one.parameter.unit, ci95=(value - half, value + half)
        )
        least, most = one.parameter.possible
        values.setdefault(one.effect.id, {})[one.parameter.name] = min(max(value, least), most)
    specs = tuple(EffectSpec(name, found, None) for name, found in sorted(values.items()))
    alike = [
        one.effects[0]
        for one in singles
        if len(best.effects) == 1
        and one.effects != best.effects
        and one.log_evidence > best.log_evidence - _ALIKE
    ]
    return InstrumentErrors(specs, parameters, best.log_evidence, tuple(alike))
