"""Ask the runs: which answer makes them most probable, each at its own point."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.asking.answer import Answer, answer_in, settled
from pipeline.diagnose.asking.hypotheses import Group, groups_of, with_wide, screen
from pipeline.diagnose.asking.pairs import pairs
from pipeline.diagnose.asking.view import View
from pipeline.diagnose.case import Case, led_by, setting_of
from pipeline.diagnose.linear.beliefs import Beliefs, as_stated, reach
from pipeline.diagnose.linear.coordinates import may_bend
from pipeline.diagnose.linear.linear_model import Setting, realisable, vector_of
from pipeline.diagnose.linear.most_probable import linear_near
from pipeline.diagnose.linear.noise_check import NoiseFound, noise_found, residual_with, widened
from pipeline.diagnose.linear.scales import Level, force_prior, levels
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: Single effects that are gone to, and pairs.
_SINGLES, _PAIRS = 6, 3
#: Log evidence by which an answer is too far behind to be gone to.
_BEHIND = 50.0
#: Times that all are judged anew at the point of the best one.
_ANEW = 2
#: Departure from which on the best answer's own point is another place than where all were judged.
_ELSEWHERE = 0.1
#: Sizes at which signatures are taken of what has none at neutral: weak and strong.
_WEAK, _STRONG = 0.1, 1.0
#: Share of the time in which the simulation may run away.
_MOST_LOST = 0.3


@dataclass(frozen=True)
class Asked:
    """All answers that were looked at, most probable first, and the view of the first."""

    answers: tuple[Answer, ...]
    view: View
    groups: dict[Group, tuple[int, ...]]
    noise: dict[str, NoiseFound]
    linearisations: int

    @property
    def setting(self) -> Setting:
        """What stayed the same."""
        return self.view.setting


def ask(  # noqa: PLR0917 - one caller
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    beliefs: Beliefs | None,
    chosen: BoolArray | None,
    threads: int,
) -> Asked:
    """Weigh all answers.

    Parameters
    ----------
    case : Case
        Vehicle and candidates.
    runs, channels
        What was measured.
    beliefs : Beliefs or None
        Learned from sound runs; None: those of the vehicle file.
    chosen : callable
        Of windows, those that take part in the fit.
    threads : int
        Simulations side by side.
    """
    setting = setting_of(
        case,
        runs,
        channels,
        threads=threads,
        force_unit=None if beliefs is None else beliefs.force_unit,
        terms=() if beliefs is None else beliefs.terms,
    )
    taking = chosen(setting) if callable(chosen) else np.ones(setting.bench.window_count, bool)
    if beliefs is not None:
        mean = realisable(setting.coordinates, beliefs.prior.mean)
        setting = led_by(setting, case.packed, runs, channels, vector_of(setting, mean))
    origin = setting.origin()
    if beliefs is not None:
        origin = replace(origin, departures=mean)
    led = linear_model(setting, origin, wide=_WEAK)
    if led.lost > _MOST_LOST:
        raise CannotComputeError(
            f"the simulation runs away in {led.lost:.0%} of the time, whatever the effect. Check "
            "that the vehicle file belongs to these runs: masses, thruster positions and signs."
        )
    if beliefs is None:
        stated = np.array([one.ordinary for one in setting.coordinates])
        several = len({w.run for w in setting.bench.stack.windows}) > 1
        beliefs = as_stated(
            setting, reach(led, stated), levels(healthy_known=False), several_runs=several
        )
    groups = groups_of(setting.coordinates)
    begun = View.of(led, beliefs, taking)
    first = _first(begun, groups)
    view, noise = _with_noise(begun, first, beliefs)
    strong = linear_model(
        view.setting, view.model.point, wide=_STRONG, known=view.model, renew=sorted(may_bend(setting.coordinates))
    )
    found: dict[tuple[Group, ...], Answer] = {}
    _judge_all(view, groups, found)
    _judge_all(View.of(strong, beliefs, taking), groups, found, pairs_too=False)
    rounds = 2
    for _ in range(_ANEW):
        best = _best(found)
        departures = best.estimate()[0]
        at = realisable(setting.coordinates, departures)
        moved = np.abs(at - view.model.point.departures)[list(best.which)] if best.which else np.zeros(1)
        if moved.max() < _ELSEWHERE and rounds > 2:
            break
        there = _linear_at(case, runs, channels, view, best, at)
        rounds += 1
        if there is None:
            break
        view = View.of(there, beliefs, taking)
        before = best.groups
        found.pop(best.groups)
        _judge_all(view, groups, found, always=(best.groups,))
        if _best(found).groups == before and rounds > 2:
            break
    ordered = sorted(found.values(), key=lambda one: -one.value)
    return Asked(tuple(ordered), view, groups, noise, rounds)


def _first(view: View, groups: dict[Group, tuple[int, ...]]) -> Answer:
    found = answer_in(view, groups, ())
    assert found is not None
    return found


def _best(found: dict[tuple[Group, ...], Answer]) -> Answer:
    return max(found.values(), key=lambda one: one.value)


def _with_noise(view: View, none: Answer, beliefs: Beliefs) -> tuple[View, dict[str, NoiseFound]]:
    """Weigh channels by their noise, judged where the force may explain all that is slow."""
    high = Level(np.maximum(2.0 * none.level.factor, 2.0), 1.0, False)
    departures = none.estimate()[0]
    motion = view.motion(high, departures)
    residual = residual_with(view.model, motion, departures)
    noise = noise_found(view.model, residual)
    widen = {name: max(one.widen, beliefs.widen.get(name, 1.0)) for name, one in noise.items()}
    return View.of(widened(view.model, residual, widen), beliefs, view.chosen), noise


def _judge_all(
    view: View,
    groups: dict[Group, tuple[int, ...]],
    found: dict[tuple[Group, ...], Answer],
    always: Sequence[tuple[Group, ...]] = (),
    *,
    pairs_too: bool = True,
) -> None:
    """Judge all answers from a view, go to the most probable ones, and keep what is better."""
    workers = view.setting.bench.workers
    every = view.setting.coordinates
    none = _first(view, groups)
    singles = [
        one for one in workers.each([partial(answer_in, view, groups, (g,)) for g in groups]) if one
    ]
    singles.sort(key=lambda one: -one.value)
    strongest: list[Answer] = []
    for one in singles:
        if len({other.effects for other in strongest}) >= _SINGLES and one.effects not in {
            other.effects for other in strongest
        }:
            continue
        if sum(other.effects == one.effects for other in strongest) < 2:
            strongest.append(one)
    both: list[Answer] = []
    if pairs_too:
        level = singles[0].level if singles else none.level
        ground = view.told(level, held_out=True).ground
        each = [one.finding for one in singles[:4] if one.finding is not None]
        for pair in pairs(ground, every, groups, each, 4)[: 2 * _PAIRS]:
            answer = answer_in(view, groups, pair.groups, pair.which)
            if answer is not None:
                both.append(answer)
        both.sort(key=lambda one: -one.value)
        both = both[:_PAIRS]
    again = [one for one in singles if (one.groups,) and one.groups in always]
    if found:
        # what is far behind an answer that was gone to will not come first
        least = _best(found).value - _BEHIND
        strongest = [one for one in strongest if one.value > least]
        both = [one for one in both if one.value > least]
    tried = {one.groups: one for one in [none, *strongest, *again, *both]}
    for groups_ in always:
        if groups_ not in tried and groups_:
            old = [k for g in groups_ for k in groups[g]]
            answer = answer_in(view, groups, groups_, old)
            if answer is not None:
                tried[groups_] = answer
    for one in workers.each([partial(settled, one, groups) for one in tried.values()]):
        known = found.get(one.groups)
        if known is None or one.value > known.value:
            found[one.groups] = one
    for one in singles:
        found.setdefault(one.groups, one)


def _linear_at(  # noqa: PLR0917 - one caller
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    view: View,
    best: Answer,
    at: FloatArray,
) -> "object | None":
    """Linearise at an answer's own point, with derivatives of all departures."""
    try:
        led = led_by(view.setting, case.packed, runs, channels, vector_of(view.setting, at))
        return linear_near(led, force_prior(view.setting, best.level), at)
    except CannotComputeError:
        return None
