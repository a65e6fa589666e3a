"""Departures that are believed to lie where they have no meaning."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.evidence import Prior, held_at
from pipeline.types import FloatArray

#: A departure is at its bound when it is beyond by less.
_AT_BOUND = 1e-6


def limits_of(all_coordinates: Sequence[Coordinate]) -> FloatArray:
    """Where departures have a meaning (g, 2); a product has none of its own."""
    none = (-np.inf, np.inf)
    return np.array([none if one.leads else one.limits for one in all_coordinates]).reshape(-1, 2)


def held_within(prior: Prior, limits: FloatArray) -> Prior:
    """Hold departures where they have a meaning, if they are believed to lie beyond.

    A normal distribution knows no bounds. Beyond them the linear model promises what no vehicle
    has: the others are what they are with those at their bound.

    Parameters
    ----------
    prior : Prior
        Of the departures (d,).
    limits : ndarray, shape (k, 2)
        Bounds of the first k.
    """
    for _ in range(len(limits)):
        beyond = prior.mean[: len(limits)] - np.clip(
            prior.mean[: len(limits)], limits[:, 0], limits[:, 1]
        )
        worst = int(np.argmax(np.abs(beyond))) if len(limits) else 0
        if not len(limits) or abs(beyond[worst]) < _AT_BOUND:
            break
        prior = held_at(prior, worst, float(prior.mean[worst] - beyond[worst]))
    return prior
