"""What is believed of a vehicle before the runs in question are seen, and what sound runs add.

Every departure has a width that is ordinary: as the vehicle file states it, or else too small to
matter. Beside it stands by how much it differs from run to run. Both are learned where there are
sound runs (`reference.learn`) and are small where there are none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.asking.run_marginals import departure_count, of_curves
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import LinearModel, Setting
from pipeline.diagnose.linear.rest import RestTerm
from pipeline.diagnose.linear.scales import Level
from pipeline.types import FloatArray

#: Share of the healthy floor below which a consequence is nothing.
SMALL = 0.15
#: What nothing shows of may be anything; this keeps numbers in bounds.
_MOST_SMALL = 0.3
#: Share of what is ordinary by which runs differ before any were compared.
_BETWEEN_RUNS = 0.25


@dataclass(frozen=True)
class Beliefs:
    """What is believed of the vehicle in question.

    Attributes
    ----------
    prior : Prior
        Of its departures (d,), in the order of `Setting`.
    scatter : ndarray, shape (d,)
        Standard deviation between its runs.
    force_unit : ndarray, shape (6,)
        Ordinary outside force. [N, N m]
    levels : tuple of Level
        How much larger or smaller it may be.
    terms : tuple of RestTerm
        Forces that the vehicle file lacks.
    widen : mapping
        Factors on the noise of channels, by quantity; empty where nothing is known of them.
    learned_from : tuple of str
        Names of the sound runs.
    """

    prior: Prior
    scatter: FloatArray
    force_unit: FloatArray
    levels: tuple[Level, ...]
    terms: tuple[RestTerm, ...]
    widen: Mapping[str, float]
    learned_from: tuple[str, ...] = ()


def reach(model: LinearModel, stated: FloatArray) -> FloatArray:
    """Compute by what one unit of each coordinate moves the worst channel, over its floor (g,).

    The floor is of the sensors' noise, what is stated (g,), and the outside force.
    """
    stack, count = model.setting.bench.stack, len(model.setting.coordinates)
    found = np.zeros(count)
    for number, rows in enumerate(stack.rows):
        if rows.channel.quantity == "voltage":
            # what matters is the motion
            continue
        own = stack.owner == number
        width = 3 if rows.channel.quantity == "attitude" else rows.measured.shape[1]
        moved = model.departures[own][:, :count].reshape(-1, width, count)
        squares = np.mean(moved**2, axis=0)
        outside = np.mean(model.local[own, 12:].reshape(len(moved), width, -1) ** 2, axis=0)
        floor = 1.0 + squares @ stated**2 + outside.sum(axis=1)
        found = np.maximum(found, np.sqrt(np.max(squares / floor[:, None], axis=0)))
    return found


def ordinary_widths(setting: Setting, moved: FloatArray) -> FloatArray:
    r"""Return the standard deviations (d,) of what is ordinary on any vehicle.

    What the file states of a coordinate; else, by what a unit moves (g,), what does not matter,

    .. math:: \sigma_i = \rho \min_c floor_c / rms_c(G_i)

    Of the rest nothing, of the curves one standard deviation.
    """
    every = setting.coordinates
    stated = np.array([one.ordinary for one in every])
    small = np.minimum(SMALL / np.maximum(moved, 1e-12), _MOST_SMALL)
    # a place has no meaning where nothing is on board
    small = np.where([bool(one.leads) for one in every], 0.0, small)
    found = np.zeros(departure_count(setting))
    found[: len(every)] = np.where(stated > 0.0, stated, small)
    found[of_curves(setting)] = 1.0
    return found


def as_stated(
    setting: Setting, moved: FloatArray, levels: Sequence[Level], *, several_runs: bool
) -> Beliefs:
    """Return what the vehicle file alone lets believe."""
    width = ordinary_widths(setting, moved)
    scatter = _BETWEEN_RUNS * width if several_runs else np.zeros(width.size)
    scatter[of_curves(setting)] = 0.0
    return Beliefs(
        Prior(np.zeros(width.size), np.diag(width**2)),
        scatter,
        setting.force_unit,
        tuple(levels),
        setting.rest.terms,
        {},
    )
