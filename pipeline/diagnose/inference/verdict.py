"""The answer in the form of the record: verdict, ranking with parameters, what is added."""

from collections import Counter

import numpy as np

from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.judging.hypotheses import Finding, prior_of
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.linear.coordinates import Coordinate, specs_at
from pipeline.diagnose.linear.evidence import Prior, posterior
from pipeline.diagnose.linear.linear_model import plain, realisable
from pipeline.diagnose.rules.calibration import Calibration
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.effects.effect import AXES
from pipeline.effects.specification import EffectSpec
from pipeline.records.diagnosis import ParameterEstimate, RankedEffect, Shrink
from pipeline.types import FloatArray

_NORMAL_95 = 1.959964
#: Share of a departure by which the model, linear or not, is off besides the noise of the readings;
#: of an effect with k parameters times the root of k, as each takes up what is wrong of the others.
_MODEL_SHARE = 0.015
#: The same of what has a place: its mass is told by inertia, which is that of all the vehicle.
_PLACED_SHARE = 0.09
#: A healthy vehicle has at least this share of what its file states.
_LEAST_FACTOR = 0.1


def departures_of(found: Search, one: Candidate, finding: Finding | None) -> FloatArray:
    """Most probable departures of an answer, ordinary ones included."""
    total = posterior(one.judged.found, prior_of(found.prior, finding)).mean
    return realisable(found.setting.coordinates, total)


def effect_alone(found: Search, best: FloatArray, finding: Finding | None) -> FloatArray:
    """Departures of the effects alone: what is added to the vehicle file."""
    added = np.zeros(best.size)
    if finding is not None:
        added[list(finding.which)] = best[list(finding.which)]
    return realisable(found.setting.coordinates, added)


def specs_of(found: Search, added: FloatArray) -> tuple[EffectSpec, ...]:
    """Return the effects of departures as they are switched on."""
    every = found.setting.coordinates
    return specs_at(every, plain(every, added))


def ranking_of(
    found: Search, answered: Answers, closed: Shrink, top: Candidate, limits: Calibration
) -> tuple[RankedEffect, ...]:
    """Every answer with its parameters; those that were never probable have probability 0."""
    rows = []
    for one in answered.ranking:
        parameters, thrusters, axes = parameters_of(found, one, limits.interval_factor)
        rows.append(
            RankedEffect(
                effect=one.name,
                probability=one.probability,
                parameters=parameters,
                gap_closed=closed.gap_closed if one.name == top.name else None,
                thruster=next(iter(thrusters.values()), None),
                thrusters=thrusters,
                axes=axes,
                log_evidence=one.log_evidence,
                held_out_log_evidence=answered.held_out.get(one.name),
            )
        )
    named = {row.effect for row in rows}
    missing = {NONE, UNKNOWN, *(effect for effect, _ in found.groups)} - named
    rows.extend(
        RankedEffect(effect=name, probability=0.0, parameters={}, gap_closed=None, log_evidence=0.0)
        for name in sorted(missing)
    )
    return tuple(rows)


def idle_effects(found: Search, one: Candidate, factor: float) -> tuple[str, ...]:
    """Return effects of an answer of which every value may as well be what the vehicle file states.

    An effect is a departure from what is stated. Where a thing sits says nothing without its size.
    """
    if one.finding is None or one.name in {NONE, UNKNOWN}:
        return ()
    values, _, _ = parameters_of(found, one, factor)
    pair, departing = len(one.finding.effects) > 1, set[str]()
    for index in one.finding.which:
        coordinate = found.setting.coordinates[index]
        effect, name = coordinate.effect.id, coordinate.parameter.name
        low, high = values[f"{effect}.{name}" if pair else name].ci95
        if not coordinate.leads and not low <= coordinate.parameter.neutral <= high:
            departing.add(effect)
    return tuple(effect for effect in one.finding.effects if effect not in departing)


def parameters_of(
    found: Search, one: Candidate, factor: float
) -> tuple[dict[str, ParameterEstimate], dict[str, str], tuple[str, ...]]:
    """Values with intervals of an answer's parameters, thrusters by effect, and its axes.

    They are those since the vehicle was well: a drag of 1.3 times the file's on the healthy runs
    and 1.95 times now is a factor of 1.5. `factor` is that on the spread of the linear model; see
    `Calibration`.
    """
    # how what has no name is best imitated is neither its size nor its place
    if one.finding is None or one.name == UNKNOWN:
        return {}, {}, ()
    which = np.array(one.finding.which, int)
    left = posterior(one.judged.found, prior_of(found.prior, one.finding))
    every = found.setting.coordinates
    alone = plain(every, left.mean)
    parameters, axes = {}, []
    pair = len(one.finding.effects) > 1
    free = Counter(every[index].effect.id for index in which)
    placed = {one.effect.id for one in every if one.leads}
    for index in which:
        coordinate = every[index]
        neutral = coordinate.parameter.neutral
        # what the healthy runs showed of a stated parameter is not the effect's
        well = float(found.prior.mean[index]) if coordinate.ordinary else 0.0
        unit = coordinate.unit_size
        if neutral:
            # an effect is a factor on what the vehicle is, not on what its file states
            unit /= max(1.0 + coordinate.unit_size * well / neutral, _LEAST_FACTOR)
        departure = float(alone[index]) - well
        least, most = coordinate.parameter.possible
        # the mirror image of what can be is next to what can be
        value = min(max(neutral + unit * departure, least), most)
        # the vehicle's own ordinary departure cannot be told from the effect's; a factor's grows
        # with the factor
        own = float(np.sqrt(found.prior.covariance[index, index])) if coordinate.ordinary else 0.0
        own *= abs(value / neutral) if neutral else 1.0
        model_share = _MODEL_SHARE * float(np.sqrt(free[coordinate.effect.id]))
        if coordinate.effect.id in placed:
            model_share = _PLACED_SHARE
        read_off = float(np.hypot(_std_alone(coordinate, index, left), model_share * departure))
        spread = float(np.hypot(factor * read_off, own))
        half = _NORMAL_95 * unit * spread
        name = coordinate.parameter.name
        if coordinate.parameter.name in AXES:
            axes.append(name)
        parameters[f"{coordinate.effect.id}.{name}" if pair else name] = ParameterEstimate(
            value=value,
            unit=coordinate.parameter.unit,
            ci95=(max(value - half, least), min(value + half, most)),
        )
    thrusters = {effect: target for effect, target in one.finding.groups if target is not None}
    return parameters, thrusters, tuple(dict.fromkeys(axes))


def _std_alone(one: Coordinate, index: int, left: Prior) -> float:
    """Spread of a departure, of a product that of what is left of it without its lead.

    With c the product and s the size of its lead the place c / s has c's error and that of s.
    """
    mean, covariance = left.mean, left.covariance
    own = float(np.sqrt(max(float(covariance[index, index]), 0.0)))
    if not one.leads:
        return own
    size = one.lead_size(mean)
    if abs(size) < one.least_lead:
        return own / one.least_lead
    every = [index, *one.leads]
    slope = np.concatenate([[1.0], -mean[index] / size * one.lead_slope(mean)]) / size
    return float(np.sqrt(max(float(slope @ covariance[np.ix_(every, every)] @ slope), 0.0)))
