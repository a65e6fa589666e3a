"""What an answer leads to on the runs: the gap with it, and the force that it leaves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.conclude.leftover import forces_left, leftover
from pipeline.diagnose.gap.channel_gaps import worst_gap
from pipeline.diagnose.gap.forecast import (
    AHEAD_S,
    Forecast,
    Outlook,
    forecast,
    healthy_spread,
    outlook,
    rms,
    smoothed_starts,
)
from pipeline.diagnose.gap.healthy_floor import with_scatter
from pipeline.diagnose.gap.regimes import Regressor
from pipeline.diagnose.gap.shrink import shrink
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.inference.verdict import departures_of, effect_alone
from pipeline.diagnose.judging.nil import stated_alone
from pipeline.diagnose.judging.search import Search, force_prior
from pipeline.diagnose.linear.elimination import solve
from pipeline.diagnose.linear.evidence import Prior
from pipeline.diagnose.linear.linear_model import Setting, realisable, vector_of
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.rules.shares import Left
from pipeline.diagnose.rules.weighing import NONE, UNKNOWN
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.identify.window_derivatives import moved_starts
from pipeline.records.diagnosis import Leftover, Shrink
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: Share of the largest change of a channel, over its floor, from which on effects act in it; floors
#: by which they must change some channel for what took no part to say anything of them.
_ACTS = 0.4


@dataclass(frozen=True)
class Ahead:
    """The windows as they are predicted: by the vehicle file, and by healthy vehicles like it.

    Attributes
    ----------
    before, stated : Forecast
        Without any answer, and by the vehicle file: they differ by known errors of instruments.
    starts : ndarray, shape (windows, STATE)
        Best known starts of the windows.
    floors : Setting
        With the ordinary outside force.
    unstated : ndarray, shape (g,)
        Departures in what no vehicle file states, as the runs show them; all predictions have them.
    stated_vector : ndarray
        Parameters of the vehicle file, with these.
    healthy : Prior
        Departures of healthy vehicles.
    spread : mapping
        What healthy vehicles differ from `before` by: mean square (k,) by channel.
    well, well_spread
        `before` and `spread` of the vehicle that the healthy runs showed, where there are any: what
        it differed from its file by when it was well is in neither.
    within_s : float
        How far ahead of a held-out window nothing took part in choice and fit. [s]
    held : ndarray of bool, shape (windows,)
        Those that took no part in choice and fit; `held_told` says in words which.
    """

    runs: tuple[RunTable, ...]
    channels: tuple[ChannelNoise, ...]
    starts: FloatArray
    floors: Setting
    unstated: FloatArray
    stated_vector: FloatArray
    healthy: Prior
    near: Outlook
    before: Forecast
    stated: Forecast
    spread: dict[str, FloatArray]
    well: Forecast
    well_spread: dict[str, FloatArray]
    within_s: float
    held: BoolArray
    held_told: str
    seed: int


@dataclass(frozen=True)
class Consequence:
    """What one answer leads to.

    Attributes
    ----------
    added : ndarray, shape (g,)
        Departures of the effects alone: what goes into the corrected vehicle file.
    after : Forecast
        With them.
    closed : Shrink
        Held-out gap before and after.
    judged : Shrink
        The same with the ordinary departures that go with the answer: a turning rate that is off by
        what is ordinary is off by more at the end of a long lever arm, and that is no gap.
    left : Leftover
        Outside force that stays.
    left_by_window : ndarray, shape (windows,)
        Its mean square in each window, summed over the axes, in units of the ordinary force.
    gap_there, gap_since : float or None
        Gap of the worst channel among those in which the effects act, by the vehicle file, and
        since the healthy runs.
    tested : bool
        Whether the effects act in what took no part.
    """

    added: FloatArray
    after: Forecast
    closed: Shrink
    judged: Shrink
    left: Leftover
    left_by_window: FloatArray
    gap_there: float | None
    gap_since: float | None
    tested: bool

    def decides(self, alike: tuple[str, ...], held_out: float) -> Left:
        """As it is decided by, with the effects that are `alike` and the held-out evidence."""
        force = max(self.left.axes.values(), default=0.0)
        alone = self.closed.after / max(self.closed.before, 1e-12)
        one = self.judged
        return Left(
            force,
            one.before,
            one.after,
            one.gap_closed,
            alike,
            alone,
            self.gap_there,
            self.closed.after,
            held_out,
            gap_since=self.gap_since,
            tested=self.tested,
        )


def look_ahead(  # noqa: PLR0917 - one caller
    found: Search,
    answered: Answers,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    held_told: str,
    seed: int,
    *,
    within_s: float,
    healthy_known: bool,
    stated: FloatArray,
) -> Ahead:
    """Predict the windows from starts estimated with all readings.

    The forces are free enough for the starts to follow whatever happened. `stated` is the parameter
    vector of the vehicle file.
    """
    setting, top = found.setting, answered.ranking[0]
    wide = Level(np.full(6, max(4.0, 2.0 * answered.force_scale)), 1.0, False)
    best = departures_of(found, top, top.finding)
    state = solve(found.grams, force_prior(setting, wide), best)
    starts = smoothed_starts(
        setting.bench.stack.windows,
        moved_starts(setting.bench.stack.starts, state.starts * setting.problem.start_scales),
    )
    near = outlook(setting, runs, channels, starts, AHEAD_S)
    unstated = np.where([one.effect.unstated for one in setting.coordinates], best, 0.0)
    vector = vector_of(setting, unstated)
    before = forecast(near, vector, channels)
    stated = stated + (vector - setting.bench.stack.packed.vector)
    as_stated = before if np.array_equal(stated, vector) else forecast(near, stated, channels)
    ordinary = min((j.level.size for j in found.judged if j.level.ordinary), default=1.0)
    ordinary = float(np.clip(answered.force_scale, ordinary, 1.0 if healthy_known else 2.0))
    floors = replace(setting, force_unit=setting.force_unit * ordinary)
    healthy = stated_alone(found.prior, setting.coordinates)
    if healthy_known:
        # healthy runs showed by how much one run differs from another
        scatter = setting.scatter if found.floor_scatter is None else found.floor_scatter
        healthy = with_scatter(healthy, setting.coordinates, scatter)
    healthy = replace(healthy, mean=np.where(unstated != 0.0, unstated, healthy.mean))
    spread = healthy_spread(near, floors, healthy, channels, before, seed)
    well, well_spread = before, spread
    if healthy_known:
        was = vector_of(setting, realisable(setting.coordinates, healthy.mean))
        well = forecast(near, was, channels)
        well_spread = healthy_spread(near, floors, healthy, channels, well, seed)
    return Ahead(
        tuple(runs),
        tuple(channels),
        starts,
        floors,
        unstated,
        stated,
        healthy,
        near,
        before,
        as_stated,
        spread,
        well,
        well_spread,
        within_s,
        ~found.chosen,
        held_told,
        seed,
    )


def consequence(
    found: Search, ahead: Ahead, one: Candidate, force_scale: float, every: Sequence[Regressor]
) -> Consequence:
    """Predict the windows with an answer, and estimate the force that it leaves."""
    finding = one.finding if one.name not in {NONE, UNKNOWN} else None
    best = departures_of(found, one, one.finding)
    added = effect_alone(found, best, finding)
    setting, before = found.setting, ahead.before
    after, spread_after = before, None
    if added.any():
        vector = vector_of(setting, added + ahead.unstated)
        after = forecast(ahead.near, vector, ahead.channels)
        spread_after = healthy_spread(
            ahead.near, ahead.floors, ahead.healthy, ahead.channels, after, ahead.seed, added
        )
    try:
        vector = vector_of(setting, best)
    except CannotComputeError:
        # where nothing explains the runs, what is stated may be pulled to where no vehicle is
        best = added + ahead.unstated
        vector = vector_of(setting, best)
    fitted = forecast(ahead.near, vector, ahead.channels)
    forces = forces_left(found, found.grams, best, force_scale)
    told = (ahead.spread, ahead.held, ahead.held_told, ahead.seed)
    moved = _moved(before, after, ahead.spread, np.ones_like(ahead.held))
    most = max(moved.values(), default=0.0)
    there = tuple(name for name, value in moved.items() if value >= _ACTS * most > 0.0)
    moved_there = _moved(before, after, ahead.spread, ahead.held)
    return Consequence(
        added,
        after,
        shrink(ahead.stated, after, *told, spread_after, ahead.within_s),
        shrink(before, fitted, *told, within_s=ahead.within_s),
        leftover(found, forces, ahead.runs, every),
        (forces**2).mean(axis=1).sum(axis=1),
        worst_gap(before, ahead.spread, there) if there else None,
        worst_gap(ahead.well, ahead.well_spread, there) if there else None,
        max(moved_there.values(), default=0.0) >= _ACTS,
    )


def nothing_added(ahead: Ahead) -> Shrink:
    """Held-out gap where no effect is named: what no vehicle file states is all that is added."""
    told = (ahead.spread, ahead.held, ahead.held_told, ahead.seed)
    return shrink(ahead.stated, ahead.before, *told, within_s=ahead.within_s)


def _moved(
    before: Forecast, after: Forecast, spread: Mapping[str, FloatArray], windows: BoolArray
) -> dict[str, float]:
    """By how much effects change each channel in some windows, in healthy floors."""
    moved = {}
    for name, errors in before.errors.items():
        own = windows[before.window[name]]
        if own.any():
            floor = before.healthy_floor(name, spread, own)
            moved[name] = rms((after.errors[name] - errors)[own]) / max(floor, 1e-12)
    return moved
