"""What "no gap" looks like on this vehicle, learned from runs when it was well, then frozen."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.case import Case, channels_of, led_by, setting_of
from pipeline.diagnose.elimination import force_posterior, grams, marginal, solve
from pipeline.diagnose.evidence import Prior, fit, posterior
from pipeline.diagnose.linear_model import realisable, vector_of
from pipeline.diagnose.nil import reach, with_small
from pipeline.diagnose.noise_check import noise_found, residual_with
from pipeline.diagnose.scales import Level
from pipeline.diagnose.search import force_prior, ordinary_prior
from pipeline.diagnose.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

_ROUNDS, _FORCE_STEPS = 2, 5
#: The stated uncertainty that stays: from one day to the next a vehicle is not quite the same. One
#: run cannot show by how much, nor what belongs to its manoeuvres alone.
_DAY_TO_DAY, _ONE_RUN = 0.2, 1.0
#: A force below this share of the usual one is not believed.
_LEAST_FORCE = 0.1


@dataclass(frozen=True)
class Healthy:
    """Learned from healthy runs: prior of the departures, outside force [N, N m], noise factors."""

    prior: Prior
    force_unit: FloatArray
    widen: Mapping[str, float]
    runs: tuple[str, ...]


def learn(case: Case, threads: int = 2) -> Healthy:
    """Learn from the healthy runs of a case.

    The departures are those of the same vehicle, so what the healthy runs say of them is the prior
    of the diagnosis (widened a little for what changes from day to day). The outside force is
    estimated by expectation maximisation: its variance along an axis is the mean of the squared
    estimate and of its own uncertainty.
    """
    channels = channels_of(case.vehicle, case.healthy)
    setting = setting_of(case, case.healthy, channels, threads=threads)
    stated = ordinary_prior(setting)
    factor = np.ones(6)
    point = setting.origin()
    for round_number in range(_ROUNDS):
        model = linear_model(setting, point)
        if round_number == 0:
            stated = with_small(stated, reach(model, stated), setting)
        normal = grams(model)
        for _ in range(_FORCE_STEPS):
            forces = force_prior(setting, Level(factor, 1.0, True))
            departures = fit(marginal(normal, forces), stated).mean
            mean, std = force_posterior(normal, forces, departures)
            energy = np.mean((mean**2 + std**2).reshape(-1, 6), axis=0)
            factor = np.maximum(np.sqrt(energy), _LEAST_FORCE)
        if round_number + 1 < _ROUNDS:
            departures = realisable(setting.coordinates, departures)
            try:
                vector = vector_of(setting, departures)
            except CannotComputeError:
                # values that no vehicle can have: the healthy runs are judged around the nominal
                break
            setting = led_by(setting, case.packed, case.healthy, channels, vector)
            point = replace(setting.origin(), departures=departures)
    forces = force_prior(setting, Level(factor, 1.0, True))
    found = posterior(marginal(normal, forces), stated)
    # what is too small to matter is so from one day to the next as well
    nothing_stated = np.array([one.ordinary == 0.0 for one in setting.coordinates])
    differs = _DAY_TO_DAY if len(case.healthy) > 1 else _ONE_RUN
    share = np.where(nothing_stated, 1.0, differs)
    covariance = found.covariance + np.diag(share**2 * np.diag(stated.covariance))
    residual = residual_with(model, solve(normal, forces, found.mean), found.mean)
    widen = {name: one.widen for name, one in noise_found(model, residual).items()}
    return Healthy(
        Prior(found.mean, covariance),
        setting.force_unit * factor,
        widen,
        tuple(run.name for run in case.healthy),
    )
