"""Ask the runs: which answer makes them most probable, each at its own point."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeline.diagnose.asking.answer import Answer, answer_in, settled
from pipeline.diagnose.asking.beliefs import Beliefs, as_stated, reach
from pipeline.diagnose.asking.run_marginals import possible, solve
from pipeline.diagnose.asking.view import View
from pipeline.diagnose.asking.window_noise import residual_left, widened_by_window
from pipeline.diagnose.case import Case, led_by, setting_of, with_rest
from pipeline.diagnose.judging.hypotheses import Group, groups_of
from pipeline.diagnose.judging.pairs import pairs
from pipeline.diagnose.linear.coordinates import may_bend
from pipeline.diagnose.linear.linear_model import Setting, vector_of
from pipeline.diagnose.linear.noise_check import NoiseFound, noise_found
from pipeline.diagnose.linear.scales import Level, levels
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import ChannelNoise
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: Single effects that are gone to, and pairs.
_SINGLES, _PAIRS = 5, 3
#: Targets of an effect that are gone to; single effects from which pairs are built.
_TARGETS, _FROM = 2, 4
#: How often `none` is made linear again on the way to its own point.
_RELINEARISED = 3
#: Log evidence by which an answer is too far behind to be gone to.
_BEHIND = 50.0
#: Times that all are judged anew at the point of the best one.
_ANEW = 2
#: Sizes at which signatures are taken of what has none at neutral: weak and strong.
_WEAK, _STRONG = 0.1, 1.0
#: Force, over what is most probable, that is free to follow whatever is slow.
_FREE = 4.0
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
    reach: FloatArray
    """(g,) what a unit of each coordinate moves the worst channel by, over its floor."""

    @property
    def setting(self) -> Setting:
        """What stayed the same."""
        return self.view.setting


def ask(  # noqa: PLR0917 - one caller
    case: Case,
    runs: Sequence[RunTable],
    channels: Sequence[ChannelNoise],
    beliefs: Beliefs | None,
    chosen: Callable[[Setting], BoolArray] | None,
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
    )
    taking = np.ones(setting.bench.window_count, bool) if chosen is None else chosen(setting)
    origin = setting.origin()
    if beliefs is not None:
        mean = possible(setting, beliefs.prior.mean)[: len(setting.coordinates)]
        setting = led_by(setting, case.packed, runs, channels, vector_of(setting, mean))
        setting = with_rest(setting, beliefs.terms)
        origin = replace(setting.origin(), departures=mean)
    led = linear_model(setting, origin, wide=_WEAK)
    if led.lost > _MOST_LOST:
        raise CannotComputeError(
            f"the simulation runs away in {led.lost:.0%} of the time, whatever the effect. Check "
            "that the vehicle file belongs to these runs: masses, thruster positions and signs."
        )
    stated = np.array([one.ordinary for one in setting.coordinates])
    moved = reach(led, stated)
    if beliefs is None:
        several = len({w.run for w in setting.bench.stack.windows}) > 1
        beliefs = as_stated(setting, moved, levels(healthy_known=False), several_runs=several)
    groups = groups_of(setting.coordinates)
    view = View.of(led, beliefs, taking)
    noise: dict[str, NoiseFound] = {}
    for _ in range(2):
        view, noise = _with_noise(view, groups)
        # along the measured motion the evidence is off by the square of its noise
        none = settled(_first(view, groups), groups, _RELINEARISED)
        if not np.isfinite(none.value):
            raise CannotComputeError(
                f"{case.name}: no motion of the model comes near what was measured in these runs, "
                "whatever the outside force. Identify the vehicle first (rig2sea identify), or "
                "check that the vehicle file belongs to these runs."
            )
        view = View.of(
            linear_model(view.setting, none.view.model.point, known=view.model, renew=()),
            beliefs,
            taking,
        )
    bending = sorted(may_bend(setting.coordinates))
    strong = View.of(
        linear_model(view.setting, view.model.point, wide=_STRONG, known=view.model, renew=bending),
        beliefs,
        taking,
    )
    found: dict[tuple[Group, ...], Answer] = {(): none}
    _judge_all(view, groups, found)
    _judge_all(strong, groups, found, only={setting.coordinates[k].effect.id for k in bending})
    rounds = 3
    for _ in range(_ANEW):
        best = _best(found)
        if not best.groups:
            break
        point = best.view.model.point
        try:
            model = linear_model(view.setting, point)
        except CannotComputeError:
            break
        rounds += 1
        before = best.groups
        _judge_all(View.of(model, beliefs, taking), groups, found, anchor=best)
        if _best(found).groups == before:
            break
    possible_ones = [one for one in found.values() if np.isfinite(one.value)]
    ordered = sorted(possible_ones, key=lambda one: -one.value)
    return Asked(tuple(ordered), ordered[0].view, groups, noise, rounds, moved)


def _first(view: View, groups: dict[Group, tuple[int, ...]]) -> Answer:
    found = answer_in(view, groups, ())
    if found is None:
        raise CannotComputeError("the runs say nothing under any outside force")
    return found


def _best(found: dict[tuple[Group, ...], Answer]) -> Answer:
    return max(found.values(), key=lambda one: one.value)


def _with_noise(
    view: View, groups: dict[Group, tuple[int, ...]]
) -> tuple[View, dict[str, NoiseFound]]:
    """Weigh channels by their noise, judged where the force may explain all that is slow."""
    none = _first(view, groups)
    high = Level(np.maximum(_FREE * none.level.factor, _FREE), 1.0, False)
    departures = none.within()
    best = solve(view.normal, view.factor(high), departures)
    residual = residual_left(view.model, best, departures)
    noise = noise_found(view.model, residual)
    known = view.beliefs.widen
    widen = {name: min(known.get(name, one.widen), one.widen) for name, one in noise.items()}
    if (view.setting.row_scale < 1.0).any():
        # what was weighed already needs no more, but where a window asks for it
        widen = dict.fromkeys(widen, 1.0)
    return View.of(widened_by_window(view.model, residual, widen), view.beliefs, view.chosen), noise


def _judge_all(
    view: View,
    groups: dict[Group, tuple[int, ...]],
    found: dict[tuple[Group, ...], Answer],
    anchor: Answer | None = None,
    only: Collection[str] | None = None,
) -> None:
    """Judge all answers from a view, go to the most probable ones, and keep what is better.

    `anchor` is the answer at whose point the view is, `none` otherwise: what is not gone to counts
    by what the view promises of it beyond the anchor. `only` names the effects that are asked.
    """
    workers = view.setting.bench.workers
    own = () if anchor is None else anchor.groups
    here = answer_in(view, groups, own, None if anchor is None else anchor.which)
    if here is None:
        return
    if anchor is not None:
        settled_here = settled(here, groups)
        if settled_here.value > found[own].value:
            found[own] = settled_here
    shift = found[own].value - here.value
    asked = [g for g in groups if only is None or g[0] in only]
    singles = [
        one for one in workers.each([partial(answer_in, view, groups, (g,)) for g in asked]) if one
    ]
    singles.sort(key=lambda one: -one.value)
    both = [] if only is not None else _pairs_in(view, groups, singles)
    best = max(one.value for one in found.values())
    tried = [*_of_each(singles, _SINGLES), *both[:_PAIRS]]
    if own or only is not None:
        # what is far behind an answer that was gone to will not come first
        tried = [one for one in tried if one.value + shift > best - _BEHIND]
    # nothing is the matter, seen from where something was thought to be
    tried.append(_first(view, groups))
    _keep_better(found, workers.each([partial(settled, one, groups, 1) for one in tried]))
    for one in singles:
        if one.groups not in found and one.value + shift < best:
            found[one.groups] = replace(
                one, ordinary=one.ordinary + shift, strange=one.strange + shift
            )


def _pairs_in(
    view: View, groups: dict[Group, tuple[int, ...]], singles: Sequence[Answer]
) -> list[Answer]:
    """Judge pairs of the strongest effects in a view, the strongest first."""
    if not singles:
        return []
    ground = view.told(singles[0].level, held_out=True).ground
    each = [one.finding for one in singles[:_FROM] if one.finding is not None]
    every = view.setting.coordinates
    built = pairs(ground, every, groups, each, _FROM)[: 2 * _PAIRS]
    found = [answer_in(view, groups, pair.groups, pair.which) for pair in built]
    return sorted((one for one in found if one is not None), key=lambda one: -one.value)


def _keep_better(found: dict[tuple[Group, ...], Answer], seen: Sequence[Answer]) -> None:
    """Keep of each answer the one that was gone to, or the better of two."""
    for one in seen:
        known = found.get(one.groups)
        if known is None or not known.settled or one.value > known.value:
            found[one.groups] = one


def _of_each(singles: Sequence[Answer], most: int) -> list[Answer]:
    """Take the strongest effects, each at its two strongest targets."""
    found: list[Answer] = []
    for one in singles:
        names = {other.effects for other in found}
        if one.effects not in names and len(names) >= most:
            continue
        if sum(other.effects == one.effects for other in found) < _TARGETS:
            found.append(one)
    return found
