"""Where runs differ from sound ones: channels, regimes and times, and what the force goes with."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.gap.course import dependence, time_course
from pipeline.diagnose.gap.regimes import (
    Regressor,
    regime_gaps,
    regime_shares,
    regressors,
    time_shares,
)
from pipeline.diagnose.regression.ahead import channel_gaps, error_of, errors_of, rms_of
from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.grid import CHANNELS
from pipeline.diagnose.regression.known import Learned, ToldRun
from pipeline.effects.effect import AXES
from pipeline.records.diagnosis import Gap, Leftover, Where
from pipeline.types import BoolArray, FloatArray, IntArray

#: Pieces that a run is cut into. [s]
STRETCH_S = 5.0
#: Error over that of sound runs from which on a channel carries the gap, and share of what the
#: change does in its worst channel from which on it acts in another.
_CARRIES, _ACTS = 1.2, 0.5
#: Fewer errors than this say nothing of a regime.
_FEWEST = 8


@dataclass(frozen=True)
class _Stretch:
    """A piece of a run."""

    run: int
    begin_s: float
    duration_s: float
    command: FloatArray


def gap_and_leftover(
    case: Case, learned: Learned, runs: Sequence[ToldRun], change: Change | None
) -> tuple[Gap, Leftover]:
    """Tell where the gap lies, and what a change (None: nothing) leaves of it.

    Regimes are those in which the change acts; without one those in which the errors lie, first
    what the force goes with.
    """
    errors = errors_of(learned, runs)
    after = _after(learned, runs, change)
    stretches = _stretches(case)
    place = _places(runs, errors.each, stretches)
    every = regressors(case.packed, stretches, case.runs)
    first, second = (np.concatenate(list(one)) / errors.floors for one in (errors.each, after))
    owner, count = np.concatenate(place), len(stretches)
    carried = np.maximum(_mean_by(owner, np.square(first), count) - 1.0, 0.0).sum(axis=1)
    left = _leftover(case, learned.response.channels, second, owner, stretches, every)
    gaps = channel_gaps(errors, learned, runs, case.vehicle.sensors)
    channels = sorted(gaps, key=lambda name: -gaps[name].ratio)
    channels = [name for name in channels if gaps[name].ratio > _CARRIES]
    by_regime, goes_with = carried, dict[str, float]()
    if change is not None:
        acts = _mean_by(owner, np.square(second - first), count)
        size = dict(zip(learned.response.channels, acts.sum(axis=0).tolist(), strict=True))
        most = max(*size.values(), 1e-12)
        acted = sorted((name for name in size if name not in channels), key=lambda c: -size[c])
        channels += [name for name in acted if size[name] >= _ACTS**2 * most]
        by_regime = acts.sum(axis=1)
    elif left.depends_on is not None and left.correlation is not None:
        goes_with[left.depends_on] = left.correlation

    def ratios_in(inside: BoolArray) -> dict[str, float]:
        own = first[inside[owner]]
        if len(own) < _FEWEST:
            return {}
        found = np.sqrt(np.mean(np.square(own), axis=0))
        return dict(zip(learned.response.channels, found.tolist(), strict=True))

    where = Where(
        channels=tuple(channels),
        regimes=regime_shares(every, by_regime, goes_with),
        times=time_shares(stretches, case.runs, carried) if channels else (),
    )
    return Gap(channels=gaps, where=where, by_regime=regime_gaps(every, ratios_in)), left


def _after(
    learned: Learned, runs: Sequence[ToldRun], change: Change | None
) -> tuple[FloatArray, ...]:
    """Errors of each run (k, c) with the change."""
    found = []
    for k, run in enumerate(runs):
        size = np.zeros(learned.ordinary.width.size)
        if change is not None and k in change.runs:
            size[list(change.which)] = change.mean
        found.append(error_of(learned, run, size))
    return tuple(found)


def _stretches(case: Case) -> list[_Stretch]:
    found = []
    for number, run in enumerate(case.runs):
        time_s = run.time_s - run.time_s[0]
        count = max(int(time_s[-1] / STRETCH_S), 1)
        edges = np.searchsorted(time_s, STRETCH_S * np.arange(count + 1))
        edges[-1] = time_s.size
        commands = np.nan_to_num(np.array(run.values["command"], float))
        found += [
            _Stretch(number, float(run.time_s[a]), (b - a) * run.period_s, commands[a:b])
            for a, b in pairwise(edges.tolist())
        ]
    return found


def _places(
    runs: Sequence[ToldRun], errors: Sequence[FloatArray], stretches: Sequence[_Stretch]
) -> list[IntArray]:
    """Return the stretch of each error (k,) of each run."""
    found = []
    for number, (run, error) in enumerate(zip(runs, errors, strict=True)):
        time_s = run.run.time_s[run.run.first :][: len(error)]
        own = [k for k, one in enumerate(stretches) if one.run == number]
        begins = np.array([stretches[k].begin_s - stretches[own[0]].begin_s for k in own])
        found.append(own[0] + np.searchsorted(begins, time_s + 1e-9, side="right") - 1)
    return found


def _mean_by(owner: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Mean (count, c) of values (k, c) over those that belong together."""
    sums = np.stack([np.bincount(owner, one, minlength=count) for one in values.T], axis=1)
    return np.asarray(sums / np.maximum(np.bincount(owner, minlength=count), 1)[:, None])


def _leftover(  # noqa: PLR0917 - one caller
    case: Case,
    channels: Sequence[str],
    left: FloatArray,
    owner: IntArray,
    stretches: Sequence[_Stretch],
    every: Sequence[Regressor],
) -> Leftover:
    """Tell which axis is off most, over sound runs, how in time, and what that goes with."""
    axis = dict(zip(CHANNELS, AXES, strict=True))
    ratios = rms_of([left])
    worst = int(np.argmax(ratios))
    own = left[:, worst : worst + 1]
    count = len(stretches)
    means = _mean_by(owner, own, count)[:, 0]
    size = _mean_by(owner, np.square(own), count)[:, 0]
    name, value = dependence(means, size, every)
    return Leftover(
        axes={axis[channels[c]]: float(one) for c, one in enumerate(ratios)},
        worst_axis=axis[channels[worst]],
        time_course=time_course(stretches, size, means, case.runs),
        depends_on=name,
        correlation=value,
    )
