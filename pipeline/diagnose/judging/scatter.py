r"""By how much the departures of one run differ from those of another.

A model that lacks something, the foot of a thruster's characteristic or drag that grows with speed,
acts like other values of its parameters, and like other ones in each manoeuvre. With enough
readings one set of values for all runs is then told to many digits, and so is whatever effect makes
up for the rest: on generated vehicles whose bench curve was fitted to a percent, four healthy ones
of five were ill, surely. An effect is what all runs agree on. So the departures of a run are those
of the vehicle and a share of what is ordinary more,

.. math:: x_r = x + d_r, \qquad d_r \sim N(0, \lambda^2 C)

with that share as the readings have it (type II maximum likelihood; MacKay 1992, "Bayesian
interpolation"). Of a single run, and where the model is right, it is 0.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.diagnose.judging.hypotheses import (
    Finding,
    Group,
    judge,
    log_evidence_of,
    screen,
    with_ordinary,
)
from pipeline.diagnose.judging.nil import small_widths
from pipeline.diagnose.linear.elimination import ForcePrior, Grams, marginal
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.types import FloatArray

#: Shares of what is ordinary that are tried, and what is believed of them.
SHARES = {0.0: 0.5, 0.25: 0.15, 0.5: 0.15, 1.0: 0.1, 2.0: 0.1}


def scatter_between_runs(  # noqa: PLR0917 - two callers
    setting: Setting,
    normal: Grams,
    forces: ForcePrior,
    prior: Prior,
    reach: FloatArray,
    groups: dict[Group, tuple[int, ...]],
    findings: Sequence[Finding] = (),
) -> FloatArray:
    """Find by how much the departures (g,) of a run differ from the vehicle's, in deviations.

    Parameters
    ----------
    setting : Setting
        With the coordinates.
    normal : Grams
        Of the windows that speak.
    forces : ForcePrior
        What is believed of the outside forces.
    prior : Prior
        Of the ordinary departures.
    reach : ndarray, shape (g,)
        As of `nil.reach`.
    groups : dict
        Effects, each of which may be what the runs agree on.
    findings : sequence of Finding
        Further hypotheses of which the same holds: pairs.
    """
    every = setting.coordinates
    stated = np.array([one.ordinary for one in every])
    unit = np.hypot(stated, small_widths(reach, every))
    if np.unique(normal.run).size < 2:
        return np.zeros(unit.size)

    def value(share: float) -> float:
        found = marginal(replace(normal, scatter=share * unit), forces)
        ground = with_ordinary(found, prior)
        gains = [one.log_evidence for one in screen(ground, every, groups)]
        gains += [judge(ground, every, one.which)[0] for one in findings if one.which]
        best = max((gain for gain in gains if np.isfinite(gain)), default=0.0)
        return log_evidence_of(ground) + max(best, 0.0) + float(np.log(SHARES[share]))

    values = setting.bench.workers.each([partial(value, share) for share in SHARES])
    return np.asarray(list(SHARES)[int(np.argmax(values))] * unit)
