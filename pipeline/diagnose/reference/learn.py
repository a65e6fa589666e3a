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

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.asking.beliefs import Beliefs, ordinary_widths, reach
from pipeline.diagnose.asking.held import held_within, limits_of
from pipeline.diagnose.asking.levels import force_prior, time_course, usual_levels
from pipeline.diagnose.asking.run_marginals import (
    Factored,
    RunGrams,
    departure_count,
    factored,
    force_energy,
    grams,
    marginals,
    of_curves,
    of_rest,
    point_at,
    possible,
    solve,
    together,
    without_scatter,
)
from pipeline.diagnose.asking.window_noise import residual_left, widened_by_window
from pipeline.diagnose.linear.elimination import Marginal
from pipeline.diagnose.linear.evidence import Prior, fit, posterior
from pipeline.diagnose.linear.linear_model import LinearModel, Setting
from pipeline.diagnose.linear.noise_check import noise_found
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.types import FloatArray

#: Widths that do not matter, of each kind of force of the rest: of the vehicle and between runs.
_REST = {
    "constant": (1.0, 0.5),
    "earth": (1.0, 0.5),
    "thrust": (0.03, 0.02),
    "late": (0.3, 0.1),
    "damping": (0.1, 0.03),
}
#: The same of coordinates, as a share of what is ordinary, between runs, and the most it may be:
#: what is stated with a width has it, and beyond it is a finding.
_BETWEEN_RUNS, _MOST_BETWEEN = 0.2, 0.5
#: Forces of the rest that differ from run to run by as much as the runs show (ballast, cables).
#: How thrusters push where they should not, and what couples axes, stays.
_DIFFERS = ("constant", "earth")
#: What differs from run to run without anybody logging it, by as much as it does: the scale of all
#: thrusters (a pilot's gain, the supply).
_COMMON = "thrust_deduction"
#: Observations that these widths count as.
_BEFORE = 1.0
#: Motions about which it is learned: the measured one, then the most probable ones.
_MOTIONS = 3
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
    gain: float
    """Log evidence of the runs over that of the file's own widths, both with the learned force."""


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
    widths, factor = _begun(setting, width), np.ones(6)
    widen: dict[str, float] = {}
    model = led
    for number in range(_MOTIONS):
        model, told = _with_noise(model, widths, factor)
        widen = told or widen
        normal = grams(model)
        vehicle, of_runs, widths, factor = _maximised(setting, normal, widths, factor)
        if number < _MOTIONS - 1:
            # once more at the motion that is most probable with what was learned
            equations = factored(normal, force_prior(setting, Level(factor, 1.0, True)))
            point = point_at(setting, solve(normal, equations, of_runs), possible(setting, vehicle))
            found = linear_model(model.setting, point, known=model, renew=())
            if found.lost <= model.lost:
                model = found
    equations = factored(normal, force_prior(setting, Level(factor, 1.0, True)))
    stats = marginals(normal, equations)
    limits = limits_of(setting.coordinates)
    vehicle_of = held_within(
        posterior(_pooled(stats, np.sqrt(widths.runs)), _prior(widths)), limits
    )
    unit = setting.force_unit * factor
    beliefs = Beliefs(
        Prior(vehicle_of.mean, vehicle_of.covariance),
        np.sqrt(widths.runs),
        unit,
        usual_levels(_spread_of_levels(setting, normal, equations, of_runs)),
        setting.rest.terms,
        widen,
    )
    gain = _log_evidence(stats, widths) - _log_evidence(stats, _begun(setting, width))
    return Learned(beliefs, model, vehicle_of.mean, of_runs, gain)


def _log_evidence(stats: Sequence[Marginal], widths: _Widths) -> float:
    """Log evidence of the runs if the departures have these widths."""
    return fit(_pooled(stats, np.sqrt(widths.runs)), _prior(widths)).log_evidence


def _with_noise(
    model: LinearModel, widths: _Widths, factor: FloatArray
) -> tuple[LinearModel, dict[str, float]]:
    """Weigh readings by what a free force leaves of them; with the factors on channels."""
    setting, normal = model.setting, grams(model)
    free = factored(normal, force_prior(setting, Level(_FREE * np.maximum(factor, 1.0), 1.0, True)))
    _, of_runs, _ = _expected(setting, marginals(normal, free), widths)
    residual = residual_left(model, solve(normal, free, of_runs), of_runs)
    noise = noise_found(model, residual)
    widen = {name: one.widen for name, one in noise.items()}
    if (setting.row_scale < 1.0).any():
        return widened_by_window(model, residual, dict.fromkeys(widen, 1.0)), {}
    return widened_by_window(model, residual, widen), widen


def _stated(setting: Setting) -> FloatArray:
    return np.array([0.0 if one.effect.unstated else one.ordinary for one in setting.coordinates])


def groups_of_widths(setting: Setting) -> list[list[int]]:
    """Departures whose widths are alike: an effect's, or a kind of force along one axis."""
    found: dict[object, list[int]] = {}
    for k, one in enumerate(setting.coordinates):
        found.setdefault(one.effect.id, []).append(k)
    first = len(setting.coordinates)
    for k, term in enumerate(setting.rest.terms):
        found.setdefault(term.group, []).append(first + k)
    return [*found.values(), list(range(departure_count(setting)))[of_curves(setting)]]


def _begun(setting: Setting, width: FloatArray) -> _Widths:
    vehicle, runs = width**2, (_BETWEEN_RUNS * width) ** 2
    runs[of_curves(setting)] = 0.0
    for k, term in enumerate(setting.rest.terms, len(setting.coordinates)):
        own = _REST[term.kind]
        vehicle[k], runs[k] = own[0] ** 2, own[1] ** 2
    return _Widths(vehicle, runs)


def _prior(widths: _Widths) -> Prior:
    return Prior(np.zeros(widths.vehicle.size), np.diag(widths.vehicle))


def _pooled(stats: Sequence[Marginal], scatter: FloatArray) -> Marginal:
    return together([without_scatter(one, scatter) for one in stats])


def _maximised(
    setting: Setting, normal: RunGrams, widths: _Widths, factor: FloatArray
) -> tuple[FloatArray, FloatArray, _Widths, FloatArray]:
    """Find departures of vehicle (d,) and runs (runs, d), their widths, and the force (6,)."""
    begun, groups = widths, groups_of_widths(setting)
    rest = np.zeros(departure_count(setting), bool)
    # errors of curves as well: how a controller makes thrust of a stick is in no file
    rest[of_rest(setting)], rest[of_curves(setting)] = True, True
    free, fixed = np.zeros(rest.size, bool), np.ones(rest.size, bool)
    for k, one in enumerate(setting.coordinates):
        free[k] = one.effect.id == _COMMON
        of_one = one.effect.scope == "thruster" and one.ordinary == 0.0
        fixed[k] = one.effect.unstated or bool(one.leads) or of_one
    for k, term in enumerate(setting.rest.terms, len(setting.coordinates)):
        free[k] = term.kind in _DIFFERS
        fixed[k] = not free[k]
    time = time_course(setting)
    stated = np.concatenate(
        [_stated(setting), np.zeros(departure_count(setting) - len(setting.coordinates))]
    )
    for _ in range(_ROUNDS):
        equations = factored(normal, force_prior(setting, Level(factor, 1.0, True)))
        stats = marginals(normal, equations)
        for _ in range(_WITHIN):
            vehicle, of_runs, squares = _expected(setting, stats, widths)
            runs, wide = widths.runs.copy(), widths.vehicle.copy()
            for own in groups:
                moving = [k for k in own if begun.runs[k] > 0.0 and not fixed[k]]
                if moving and len(stats) > 1:
                    ratio = _ratio(squares[1][:, moving], begun.runs[moving])
                    runs[moving] = begun.runs[moving] * ratio
                if rest[own[0]]:
                    ratio = _ratio(squares[0][None, own], begun.vehicle[own])
                    wide[own] = begun.vehicle[own] * ratio
            most = np.where(stated > 0.0, _MOST_BETWEEN * stated, _MOST_BETWEEN)
            runs = np.where(free | fixed, runs, np.minimum(runs, most**2))
            widths = _Widths(wide, runs)
        energy = force_energy(normal, equations, of_runs, time)
        factor = np.maximum(np.sqrt(energy.mean(axis=0)), _LEAST_FORCE)
    return vehicle, of_runs, widths, factor


def _ratio(squares: FloatArray, before: FloatArray) -> float:
    """Say by how much larger than before the variance of a group is, (n, k) expected squares."""
    each = squares / before
    return float((_BEFORE + each.sum()) / (_BEFORE + each.size))


def _expected(
    setting: Setting, stats: Sequence[Marginal], widths: _Widths
) -> tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray]]:
    """Expect departures of vehicle (d,) and runs (r, d); squares of the vehicle's, of runs' own."""
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


def _spread_of_levels(
    setting: Setting, normal: RunGrams, equations: Factored, of_runs: FloatArray
) -> float:
    """Return the standard deviation between runs of the logarithm of the outside force."""
    time = time_course(setting)
    energy = force_energy(normal, equations, of_runs, time)
    energy = energy / energy.mean(axis=0)
    each = [0.5 * np.log(energy[normal.run == number].mean()) for number in np.unique(normal.run)]
    return float(np.std(each, ddof=1)) if len(each) > 1 else 0.0
