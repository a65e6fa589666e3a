"""One answer: its effects at their most probable point, and how probable it makes the readings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from pipeline.diagnose.asking.run_marginals import possible
from pipeline.diagnose.asking.view import View
from pipeline.diagnose.judging.hypotheses import (
    Finding,
    Group,
    best_subset,
    judge,
    subset_price,
)
from pipeline.diagnose.linear.scales import Level
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.types import FloatArray

#: Ordinary departures go no further than this, in standard deviations: no simulation is led astray.
_MOST_ORDINARY = 4.0
#: An answer has settled when a step changes its log evidence by less.
_SAME = 1.0
#: Steps of one simulation each.
_STEPS = 6


@dataclass(frozen=True)
class Answer:
    """An answer as it is seen from one view.

    Attributes
    ----------
    groups : tuple
        Effects at their targets; none for `none`.
    finding : Finding or None
        Its departures under the best level, by all windows.
    level : Level
        Force under which it is most probable.
    view : View
        Where it was seen.
    ordinary, strange : float
        Log evidence of all windows under forces that are ordinary, and under larger ones, their
        prior weights counted.
    settled : bool
        It was seen at its own point.
    """

    groups: tuple[Group, ...]
    finding: Finding | None
    level: Level
    view: View
    ordinary: float
    strange: float
    settled: bool = False

    @property
    def name(self) -> str:
        """Its effects, joined by a plus; `none`."""
        return "+".join(self.effects) or "none"

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects in alphabetical order."""
        return tuple(sorted({effect for effect, _ in self.groups}))

    @property
    def value(self) -> float:
        """Log evidence whatever the force."""
        return float(np.logaddexp(self.ordinary, self.strange))

    @property
    def which(self) -> tuple[int, ...]:
        """Its departures."""
        return () if self.finding is None else self.finding.which

    def estimate(self) -> tuple[FloatArray, FloatArray]:
        """Most probable departures (d,) by the chosen windows, and their deviations."""
        variance = np.zeros(0) if self.finding is None else self.finding.variance
        return self.view.estimate(self.level, self.which, variance)

    def within(self) -> FloatArray:
        """Most probable departures (d,), the ordinary ones kept ordinary."""
        return _within(self.view, self.estimate()[0], self)


def answer_in(
    view: View,
    groups: dict[Group, tuple[int, ...]],
    own: Sequence[Group],
    which: Sequence[int] | None = None,
    levels: Sequence[Level] | None = None,
) -> Answer | None:
    """Judge some effects together in a view, under every even level of the force.

    Parameters
    ----------
    view : View
        Where.
    groups : dict
        Coordinates of each effect at each target.
    own : sequence of Group
        The effects; none of them for `none`.
    which : sequence of int, optional
        Their departures; of a single effect the best subset otherwise.
    levels : sequence of Level, optional
        Levels of the force; all even ones otherwise.

    Returns
    -------
    Answer or None
        None where no vehicle can be what the readings want.
    """
    every = view.setting.coordinates
    rows: list[tuple[Level, float, Finding | None]] = []
    levels = view.even if levels is None else levels
    grounds = [view.told(level, held_out=True) for level in levels]
    if own and which is None:
        first = max(range(len(levels)), key=lambda k: grounds[k].nothing + np.log(levels[k].weight))
        targets = sum(effect == own[0][0] for effect, _ in groups)
        found = []
        for k in sorted({first, max(first - 2, 0)}):
            one = best_subset(grounds[k].ground, every, own[0], groups[own[0]], targets)
            if one.which and np.isfinite(one.log_evidence):
                found.append((grounds[k].nothing + one.log_evidence, one.which))
        if not found:
            return None
        which = max(found)[1]
    price = sum(
        subset_price(groups, one, sum(k in groups[one] for k in which or ())) for one in own
    )
    for level, told in zip(levels, grounds, strict=True):
        if not own:
            rows.append((level, told.nothing, None))
            continue
        gain, mean, covariance, variance = judge(told.ground, every, which or ())
        if np.isfinite(gain):
            finding = Finding(
                tuple(own), tuple(which or ()), gain + price, mean, covariance, variance
            )
            rows.append((level, told.nothing + gain + price, finding))
    if not rows:
        return None
    value = [evidence + float(np.log(level.weight)) for level, evidence, _ in rows]
    usual = [one for one, (level, _, _) in zip(value, rows, strict=True) if level.ordinary]
    larger = [one for one, (level, _, _) in zip(value, rows, strict=True) if not level.ordinary]
    best = rows[int(np.argmax(value))]
    return Answer(
        tuple(own),
        best[2],
        best[0],
        view,
        float(logsumexp(usual)) if usual else -np.inf,
        float(logsumexp(larger)) if larger else -np.inf,
    )


def settled(answer: Answer, groups: dict[Group, tuple[int, ...]], relinearised: int = 0) -> Answer:
    """Go to where an answer is most probable.

    Each step is one simulation with the derivatives of the view (chord method). What the linear
    model promises and the simulation does not bear out is lost.

    Parameters
    ----------
    answer : Answer
        As its view promises it.
    groups : dict
        Coordinates of each effect at each target.
    relinearised : int
        How often new derivatives may be taken, of the motion and the answer's own departures, where
        the steps do not come to an end.
    """
    best, view = _stepped(answer, answer.view, groups)
    for _ in range(relinearised):
        if best is None or best.settled:
            break
        point = best.view.model.point
        view = View.of(
            linear_model(view.setting, point, known=view.model, renew=answer.which),
            view.beliefs,
            view.chosen,
        )
        again = answer_in(
            view, groups, answer.groups, answer.which or None, _near(view, best.level)
        )
        if again is None:
            break
        better, _ = _stepped(again, view, groups)
        best = best if better is None else better
    if best is not None and not answer.groups:
        return best
    if best is None or not best.settled:
        # what the last step promises was borne out by none before
        return replace(best or answer, ordinary=-np.inf, strange=-np.inf)
    return best


def _stepped(
    answer: Answer, view: View, groups: dict[Group, tuple[int, ...]]
) -> tuple[Answer | None, View]:
    """Take steps with the derivatives of a view; None where no vehicle can be led there."""
    at = answer.within()
    found: Answer | None = None
    level = answer.level
    seen_from = answer.view
    for _ in range(_STEPS):
        seen = view.at(seen_from.motion(level, possible(view.setting, at)))
        told = None
        if seen is not None:
            told = answer_in(seen, groups, answer.groups, answer.which or None, _near(view, level))
        if seen is None or told is None:
            if found is not None or not answer.which:
                break
            # too far for one step: what acts strongly is far from straight
            at = _halved(view, at, answer)
            continue
        before, found = found, told
        level, seen_from = found.level, seen
        if before is not None and abs(found.value - before.value) < _SAME:
            return replace(found, settled=True), view
        at = found.within()
    return found, view


def _near(view: View, level: Level) -> tuple[Level, ...]:
    """Return a level with its neighbours: others weigh next to nothing."""
    at = next(k for k, one in enumerate(view.even) if one.size == level.size)
    return view.even[max(at - 1, 0) : at + 2]


def _within(view: View, departures: FloatArray, answer: Answer) -> FloatArray:
    """Keep ordinary departures ordinary."""
    prior = view.beliefs.prior
    most = _MOST_ORDINARY * np.sqrt(np.diag(prior.covariance))
    kept = prior.mean + np.clip(departures - prior.mean, -most, most)
    kept[list(answer.which)] = departures[list(answer.which)]
    return np.asarray(kept)


def _halved(view: View, at: FloatArray, answer: Answer) -> FloatArray:
    found = view.beliefs.prior.mean + 0.5 * (at - view.beliefs.prior.mean)
    found[list(answer.which)] = 0.5 * at[list(answer.which)]
    return np.asarray(found)
