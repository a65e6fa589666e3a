r"""Departures too small to matter: what changes the prediction by far less than is ordinary.

With enough readings any departure becomes significant, a dead zone of half a code among them, and
so does every small flaw of the model that looks like one. What counts is size: a departure whose
consequence is a small share of what healthy vehicles differ by anyway is no effect. So each
departure of the library is given an ordinary width,

.. math:: \sigma_i = \rho \min_c \frac{floor_c}{rms_c(G_i)}

with the rms of what one unit of it moves channel c, and the channel's healthy floor (sensor noise,
stated uncertainties, outside forces), all in a window's reach.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.judging.hypotheses import Finding
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import LinearModel, Setting
from pipeline.types import FloatArray

#: Share of the healthy floor below which a consequence is nothing.
SMALL = 0.15
#: Share of the healthy floor from which on it is an effect.
LEAST = 0.4


def reach(model: LinearModel, prior: Prior) -> FloatArray:
    """Compute by what one unit of each departure moves the worst channel, over its floor (g,)."""
    stack = model.setting.bench.stack
    stated = np.diag(prior.covariance)
    found = np.zeros(len(stated))
    for number, rows in enumerate(stack.rows):
        if rows.channel.quantity == "voltage":
            # what matters is the motion
            continue
        own = stack.owner == number
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        moved = model.departures[own].reshape(-1, width, len(stated))
        squares = np.mean(moved**2, axis=0)
        outside = np.mean(model.local[own, 12:].reshape(len(moved), width, -1) ** 2, axis=0)
        floor = 1.0 + squares @ stated + outside.sum(axis=1)
        found = np.maximum(found, np.sqrt(np.max(squares / floor[:, None], axis=0)))
    return found


def with_small(prior: Prior, moved: FloatArray, setting: Setting) -> Prior:
    """Prior in which departures of which nothing is stated may be as large as does not matter."""
    covariance = prior.covariance.copy()
    width = small_widths(moved, setting.coordinates)
    for index in np.flatnonzero(np.diag(prior.covariance) == 0.0).tolist():
        covariance[index, index] = width[index] ** 2
    return Prior(prior.mean, covariance)


def small_widths(moved: FloatArray, every: Sequence[Coordinate]) -> FloatArray:
    """Departures (g,) that do not matter, by what a unit moves; those of a product are 0."""
    # what nothing shows of may be anything; the unit keeps numbers in bounds
    width = np.minimum(SMALL / np.maximum(moved, 1e-12), 0.3)
    return np.where([bool(one.leads) for one in every], 0.0, width)


def stated_alone(prior: Prior, every: Sequence[Coordinate]) -> Prior:
    """Prior with those departures of which nothing is stated held where they are most probable.

    Each of them is too small to matter; together they are not: a healthy floor with all of them is
    up to twice what healthy vehicles leave. So is what no vehicle file states held: it is not by
    that that a vehicle may differ from its file.
    """
    stated = np.array([one.ordinary > 0.0 and not one.effect.unstated for one in every])
    within, across = (
        prior.covariance[np.ix_(stated, stated)],
        prior.covariance[np.ix_(stated, ~stated)],
    )
    others = prior.covariance[np.ix_(~stated, ~stated)]
    covariance = np.zeros_like(prior.covariance)
    given = within - across @ np.linalg.pinv(others, hermitian=True) @ across.T
    covariance[np.ix_(stated, stated)] = (given + given.T) / 2.0
    return Prior(prior.mean, covariance)


def matters(finding: Finding, moved: FloatArray, all_coordinates: Sequence[Coordinate]) -> bool:
    """Whether every effect of a finding moves some channel by `LEAST` of its floor or more."""
    sizes: dict[str, float] = {}
    for place, index in enumerate(finding.which):
        name = all_coordinates[index].effect.id
        part = float(finding.mean[place] * moved[index])
        sizes[name] = float(np.hypot(sizes.get(name, 0.0), part))
    return all(size >= LEAST for size in sizes.values())
