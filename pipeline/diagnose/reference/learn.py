r"""Learn from sound runs what the vehicle file lacks, and by how much runs differ.

The departures of run r are x_r = x + d_r. Vehicle and runs are pooled in part,

.. math:: x \sim N(0, T), \qquad d_r \sim N(0, \Lambda), \qquad f_w \sim N(0, \sigma_a^2 K)

with T what the file states (and, of the rest, one width for each kind of force and axis), Lambda
one width for each effect or kind and axis, and sigma_a the outside force along axis a. The widths
are those that make the runs most probable, found by expectation maximisation (Laird and Ware 1982,
Biometrics 38, 963-974; Dempster, Laird and Rubin 1977), each begun with the weight of `_BEFORE`
observations of what does not matter. With one run the vehicle is nearly that of its file; with ten
it is nearly what was measured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.linear.beliefs import Beliefs, ordinary_widths, reach
from pipeline.diagnose.linear.elimination import (
    Factored,
    Grams,
    Marginal,
    factored,
    force_energy,
    grams,
    marginals,
    solve,
    together,
    without_scatter,
)
from pipeline.diagnose.linear.coordinates import limits_of
from pipeline.diagnose.linear.evidence import Prior, held_within, posterior
from pipeline.diagnose.linear.linear_model import LinearModel, Setting, realisable
from pipeline.diagnose.linear.most_probable import moving_freely
from pipeline.diagnose.linear.noise_check import noise_found, residual_with, widened
from pipeline.diagnose.linear.scales import Level, force_prior, time_covariance, usual_levels
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.types import FloatArray

#: Widths that do not matter, of each kind of force of the rest: of the vehicle and between runs.
_REST = {
    "constant": (1.0, 0.5),
    "earth": (1.0, 0.5),
    "thrust": (0.03, 0.02),
    "late": (0.3, 0.2),
    "damping": (0.1, 0.05),
}
#: The same of coordinates, as a share of what is ordinary, between runs, and the most it may be:
#: what is stated with a width has it, and beyond it is a finding.
_BETWEEN_RUNS, _MOST_BETWEEN = 0.2, 1.0
#: What differs from run to run without anybody logging it, by as much as it does: the scale of all
#: thrusters (a pilot's gain, the supply).
_COMMON = "thrust_deduction"
#: Observations that these widths count as.
_BEFORE = 1.0
#: Rounds of the expectation maximisation, and of the widths within each.
_ROUNDS, _WITHIN = 5, 3
#: Force, over the ordinary, that follows whatever is slow: what is left is noise.
_FREE = 8.0
#: No axis has an outside force below this share of the usual one.
_LEAST_FORCE = 0.1


@dataclass(frozen=True)
class Learned:
    """What sound runs showed: beliefs, the model at which it was learned, and runs' own departures.

    `of_runs` (runs, d) are the departures of each run, `vehicle` (d,) those of all.
    """

    beliefs: Beliefs
    model: LinearModel
    vehicle: FloatArray
    of_runs: FloatArray


@dataclass(frozen=True)
class _Widths:
    """Variances (d,) of the vehicle and between runs; `group` (d,) numbers those that are alike."""

    vehicle: FloatArray
    runs: FloatArray


def learn(setting: Setting) -> Learned:
    """Learn from the sound runs of a setting, which has the forces of the rest.

    Parameters
    ----------
    setting : Setting
        Windows of the sound runs, led along the measured motion by the vehicle file's model.
    """
    led = linear_model(setting, setting.origin())
    width = ordinary_widths(setting, reach(led, _stated(setting)))
    widths, factor, widen = _begun(setting, width), np.ones(6), {}
    model = led
    for number in range(2):
        model, told = _with_noise(model, widths, factor)
        widen = told or widen
        normal = grams(model)
        vehicle, of_runs, widths, factor = _maximised(setting, normal, widths, factor)
        if number == 0:
            # once more at the motion that is most probable with what was learned
            forces = force_prior(setting, Level(factor, 1.0, True))
            at = realisable(setting.coordinates, vehicle)
            freely = moving_freely(model, forces, at, model, ())
            if freely is not None and freely.lost <= model.lost:
                model = freely
    equations = factored(normal, force_prior(setting, Level(factor, 1.0, True)))
    stats = marginals(normal, equations)
    limits = limits_of(setting.coordinates)
    found = held_within(posterior(_pooled(stats, np.sqrt(widths.runs)), _prior(widths)), limits)
    unit = setting.force_unit * factor
    beliefs = Beliefs(
        Prior(found.mean, found.covariance),
        np.sqrt(widths.runs),
        unit,
        usual_levels(_spread_of_levels(setting, normal, equations, of_runs)),
        setting.rest.terms,
        widen,
    )
    return Learned(beliefs, model, found.mean, of_runs)


def _with_noise(
    model: LinearModel, widths: _Widths, factor: FloatArray
) -> tuple[LinearModel, dict[str, float]]:
    """Weigh readings by what is left of them where the force is free; with the factors on channels."""
    setting, normal = model.setting, grams(model)
    free = factored(normal, force_prior(setting, Level(_FREE * np.maximum(factor, 1.0), 1.0, True)))
    _, of_runs, _ = _expected(setting, marginals(normal, free), widths)
    residual = _residual(model, solve(normal, free, of_runs), of_runs)
    noise = noise_found(model, residual)
    widen = {name: one.widen for name, one in noise.items()}
    if (setting.row_scale < 1.0).any():
        return widened(model, residual, dict.fromkeys(widen, 1.0)), {}
    return widened(model, residual, widen), widen


def _stated(setting: Setting) -> FloatArray:
    return np.array(
        [0.0 if one.effect.unstated else one.ordinary for one in setting.coordinates]
    )


def groups_of_widths(setting: Setting) -> list[list[int]]:
    """Departures whose widths are alike: an effect's, or a kind of force along one axis."""
    found: dict[object, list[int]] = {}
    for k, one in enumerate(setting.coordinates):
        found.setdefault(one.effect.id, []).append(k)
    first = len(setting.coordinates)
    for k, term in enumerate(setting.rest.terms):
        found.setdefault(term.group, []).append(first + k)
    return [*found.values(), list(range(setting.size))[setting.of_curves]]


def _begun(setting: Setting, width: FloatArray) -> _Widths:
    vehicle, runs = width**2, (_BETWEEN_RUNS * width) ** 2
    runs[setting.of_curves] = _BETWEEN_RUNS**2
    for k, term in enumerate(setting.rest.terms, len(setting.coordinates)):
        own = _REST[term.kind]
        vehicle[k], runs[k] = own[0] ** 2, own[1] ** 2
    return _Widths(vehicle, runs)


def _prior(widths: _Widths) -> Prior:
    return Prior(np.zeros(widths.vehicle.size), np.diag(widths.vehicle))


def _pooled(stats: Sequence[Marginal], scatter: FloatArray) -> Marginal:
    return together([without_scatter(one, scatter) for one in stats])


def _maximised(
    setting: Setting, normal: Grams, widths: _Widths, factor: FloatArray
) -> tuple[FloatArray, FloatArray, _Widths, FloatArray]:
    """Departures of the vehicle (d,) and of the runs (runs, d), their widths, and the force (6,)."""
    begun, groups = widths, groups_of_widths(setting)
    rest = np.zeros(setting.size, bool)
    # errors of curves as well: how a controller makes thrust of a stick is in no file
    rest[setting.of_rest], rest[setting.of_curves] = True, True
    free = rest.copy()
    free[[k for k, one in enumerate(setting.coordinates) if one.effect.id == _COMMON]] = True
    window = max(w.duration_s for w in setting.bench.stack.windows)
    time = time_covariance(setting.bench.pieces, window / setting.bench.pieces)
    stated = np.concatenate([_stated(setting), np.zeros(setting.size - len(setting.coordinates))])
    for _ in range(_ROUNDS):
        equations = factored(normal, force_prior(setting, Level(factor, 1.0, True)))
        stats = marginals(normal, equations)
        for _ in range(_WITHIN):
            vehicle, of_runs, squares = _expected(setting, stats, widths)
            runs, wide = widths.runs.copy(), widths.vehicle.copy()
            for own in groups:
                moving = [k for k in own if begun.runs[k] > 0.0 and (rest[k] or stated[k] > 0.0)]
                if moving and len(stats) > 1:
                    ratio = _ratio(squares[1][:, moving], begun.runs[moving])
                    runs[moving] = begun.runs[moving] * ratio
                if rest[own[0]]:
                    ratio = _ratio(squares[0][None, own], begun.vehicle[own])
                    wide[own] = begun.vehicle[own] * ratio
            runs = np.where(free, runs, np.minimum(runs, (_MOST_BETWEEN * stated) ** 2))
            runs = np.where(rest | (stated > 0.0), runs, begun.runs)
            widths = _Widths(wide, runs)
        energy = force_energy(normal, equations, of_runs, time)
        factor = np.maximum(np.sqrt(energy.mean(axis=0)), _LEAST_FORCE)
    return vehicle, of_runs, widths, factor


def _ratio(squares: FloatArray, before: FloatArray) -> float:
    """By how much larger than before the variance of a group is, (n, k) expected squares."""
    each = squares / before
    return float((_BEFORE + each.sum()) / (_BEFORE + each.size))


def _expected(
    setting: Setting, stats: Sequence[Marginal], widths: _Widths
) -> tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray]]:
    """Expected departures of vehicle (d,) and runs (r, d); squares of the vehicle's, of runs' own."""
    scatter = np.sqrt(widths.runs)
    limits = limits_of(setting.coordinates)
    found = held_within(posterior(_pooled(stats, scatter), _prior(widths)), limits)
    free = np.flatnonzero(scatter)
    of_runs, squares = [], []
    for one in stats:
        block = one.information[np.ix_(free, free)] * np.outer(scatter[free], scatter[free])
        inner = np.linalg.inv(np.eye(free.size) + block)
        own = np.zeros(scatter.size)
        gain = scatter[free, None] * inner * scatter[free]
        own[free] = gain @ (one.score - one.information @ found.mean)[free]
        follows = gain @ one.information[free]
        variance = np.zeros(scatter.size)
        variance[free] = np.diag(gain) + np.einsum(
            "ij,jk,ik->i", follows, found.covariance, follows
        )
        of_runs.append(found.mean + own)
        squares.append(own**2 + variance)
    vehicle = found.mean**2 + np.diag(found.covariance)
    return found.mean, np.stack(of_runs), (vehicle, np.stack(squares))


def _residual(model: LinearModel, state: object, of_runs: FloatArray) -> FloatArray:
    run = np.array([window.run for window in model.setting.bench.stack.windows])
    numbers = np.unique(run)
    row_run = np.searchsorted(numbers, run)[model.setting.shared.window]
    found = residual_with(model, state, np.zeros(of_runs.shape[1]))
    for number in range(numbers.size):
        own = row_run == number
        found[own] -= model.departures[own] @ of_runs[number]
    return found


def _spread_of_levels(
    setting: Setting, normal: Grams, equations: Factored, of_runs: FloatArray
) -> float:
    """Standard deviation between runs of the logarithm of the outside force."""
    window = max(w.duration_s for w in setting.bench.stack.windows)
    time = time_covariance(setting.bench.pieces, window / setting.bench.pieces)
    energy = force_energy(normal, equations, of_runs, time)
    energy = energy / energy.mean(axis=0)
    each = [
        0.5 * np.log(energy[normal.run == number].mean()) for number in np.unique(normal.run)
    ]
    return float(np.std(each, ddof=1)) if len(each) > 1 else 0.0
