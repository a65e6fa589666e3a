"""What "no gap" looks like on this vehicle, learned from runs when it was well, then frozen."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.gap.healthy_floor import borne_out
from pipeline.diagnose.judging.hypotheses import groups_of, screen, with_ordinary
from pipeline.diagnose.judging.nil import reach, with_small
from pipeline.diagnose.judging.scatter import scatter_between_runs
from pipeline.diagnose.judging.search import force_prior, ordinary_prior
from pipeline.diagnose.linear.elimination import (
    Grams,
    Marginal,
    force_posterior,
    grams,
    marginal,
    solve,
)
from pipeline.diagnose.linear.evidence import Prior, fit, posterior, widened
from pipeline.diagnose.linear.linear_model import Setting, realisable
from pipeline.diagnose.linear.most_probable import moving_freely
from pipeline.diagnose.linear.noise_check import noise_found, residual_with
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.types import FloatArray

_FORCE_STEPS = 5
#: The stated uncertainty that stays: from one day to the next a vehicle is not quite the same. One
#: run cannot show by how much, nor what belongs to its manoeuvres alone.
_DAY_TO_DAY, _ONE_RUN = 0.2, 1.0
#: Log evidence from which on an effect on healthy runs is what the simulation lacks, and how many.
_SEEN, _MOST_UNMODELLED = 10.0, 2
#: A departure beyond this (in units of half the plausible range) is no flaw but another model.
_MOST_SIZE = 2.0
#: A force below this share of the usual one is not believed.
_LEAST_FORCE = 0.1


@dataclass(frozen=True)
class Healthy:
    """Learned from healthy runs: prior of the departures, outside force [N, N m], noise factors.

    `scatter` (g,) is by how much the departures of a run differ from the vehicle's, and
    `floor_scatter` (g,) what of it the floor is made of; None where one run cannot show it.
    """

    prior: Prior
    force_unit: FloatArray
    widen: Mapping[str, float]
    scatter: FloatArray | None
    floor_scatter: FloatArray | None
    runs: tuple[str, ...]


def learn(case: Case, threads: int = 2) -> Healthy:
    """Learn from the healthy runs of a case.

    The departures are those of the same vehicle, so what the healthy runs say of them is the prior
    of the diagnosis (widened a little for what changes from day to day). The outside force is
    estimated by expectation maximisation: its variance along an axis is the mean of the squared
    estimate and of its own uncertainty.
    """
    channels = channels_of(case.vehicle, case.healthy)
    well = replace(case, packed=case.stated)
    setting = setting_of(well, case.healthy, channels, threads=threads)
    stated = ordinary_prior(setting)
    model = linear_model(setting, setting.origin())
    moved_by = reach(model, stated)
    stated = with_small(stated, moved_by, setting)
    normal = grams(model)
    factor, departures = _force_factor(setting, normal, stated, np.ones(6))
    forces = force_prior(setting, Level(factor, 1.0, True))
    departures = realisable(setting.coordinates, departures)
    freely = moving_freely(model, forces, departures)
    if freely is not None and freely.lost <= model.lost:
        model, normal = freely, grams(freely)
    factor, _ = _force_factor(setting, normal, stated, factor)
    forces = force_prior(setting, Level(factor, 1.0, True))
    scatter = scatter_between_runs(
        setting, normal, forces, stated, moved_by, groups_of(setting.coordinates)
    )
    left = marginal(replace(normal, scatter=scatter), forces)
    found = posterior(left, _with_unmodelled(setting, left, stated))
    # what is too small to matter is so from one day to the next as well
    nothing_stated = np.array([one.ordinary == 0.0 for one in setting.coordinates])
    differs = _DAY_TO_DAY if len(case.healthy) > 1 else _ONE_RUN
    share = np.where(nothing_stated, 1.0, differs)
    covariance = found.covariance + np.diag(share**2 * np.diag(stated.covariance))
    state = solve(normal, forces, found.mean)
    residual = residual_with(model, state, found.mean)
    widen = {name: one.widen for name, one in noise_found(model, residual).items()}
    vehicle, force_unit = Prior(found.mean, covariance), setting.force_unit * factor
    of_floor: FloatArray | None = None
    if len(case.healthy) > 1:
        moved = state.starts * setting.problem.start_scales
        quiet = replace(setting, force_unit=force_unit)
        of_floor = borne_out(quiet, case.healthy, channels, moved, vehicle, scatter)
    return Healthy(
        vehicle,
        force_unit,
        widen,
        scatter if len(case.healthy) > 1 else None,
        of_floor,
        tuple(run.name for run in case.healthy),
    )


def _force_factor(
    setting: Setting, normal: Grams, stated: Prior, factor: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Outside force by axis (6,) over the usual one, and the departures (g,) that go with it."""
    departures = stated.mean
    for _ in range(_FORCE_STEPS):
        forces = force_prior(setting, Level(factor, 1.0, True))
        departures = fit(marginal(normal, forces), stated).mean
        mean, std = force_posterior(normal, forces, departures)
        energy = np.mean((mean**2 + std**2).reshape(-1, 6), axis=0)
        factor = np.maximum(np.sqrt(energy), _LEAST_FORCE)
    return factor, departures


def _with_unmodelled(setting: Setting, found: Marginal, stated: Prior) -> Prior:
    """Prior in which a healthy vehicle may differ by what its runs show against the vehicle file.

    What the simulation lacks is there when the vehicle is well, too. It is the effect that stands
    in its place at that time, and none for which the vehicle is to be called ill.
    """
    groups, prior = groups_of(setting.coordinates), stated
    for _ in range(_MOST_UNMODELLED):
        best = screen(with_ordinary(found, prior), setting.coordinates, groups)[0]
        if best.log_evidence < _SEEN or float(np.abs(best.mean).max()) > _MOST_SIZE:
            break
        prior = widened(prior, np.array(best.which, int), best.variance)
    return prior
