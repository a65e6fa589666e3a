"""What the gains of runs show: dead, weak, reversed, swapped and coupled thrusters, by test.

Every question that is asked of a set of runs has a p-value; all of them are counted together
(`gain_tests.adjusted`), and only what is rejected is told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.identify.gain_estimates import (
    ALL,
    Estimates,
    GainSet,
    Pooled,
    References,
    pool,
    typical,
)
from pipeline.identify.gain_tests import (
    FALSE_ALARMS,
    ORDINARY_COUPLING,
    GainQuestion,
    adjusted,
    against_all,
    log_ratios,
    other_layouts,
    sentence,
    tail,
)
from pipeline.records.gains import FindingKind, GainFinding
from pipeline.types import BoolArray

#: A thruster is dead whose interval holds 0 and which surely gives less than this share, either
#: way, of what sound runs gave, or may have, or the file says, and of that what the others of the
#: run may give.
_DEAD = 0.5


def findings_of(asked: GainSet, sound: GainSet) -> list[GainFinding]:
    """Ask all questions of a set of runs, and tell what stands.

    `sound` are runs that are known to be so; a run is compared with the others of them.
    """
    # half of the rate for single thrusters, half for all else: the many other questions are not to
    # hide a dead one
    groups = (
        _thrusters(asked, sound),
        [
            *_layouts(asked),
            *_couplings(asked),
            *_headings(asked),
            *_common_scales(asked, sound),
        ],
    )
    found = []
    for questions in groups:
        chances = adjusted([min(one.p * len(groups), 1.0) for one in questions]).tolist()
        found += [(one, p) for one, p in zip(questions, chances, strict=True) if p <= FALSE_ALARMS]
    kept = _without_consequences([one for one, _ in found])
    chance_of = {id(one): chance for one, chance in found}
    return _merged(kept, chance_of)


def _thrusters(asked: GainSet, known: GainSet) -> list[GainQuestion]:
    """Ask of each thruster in each run, and in all, whether it gives what is expected."""
    questions: list[GainQuestion] = []
    for run in asked.runs:
        sound, judged = known.apart_from(run.name), run.judged(run.joint)
        # what runs differ by that nobody logged is ordinary too: of the others, for want of more
        rest = replace(asked, runs=tuple(one for one in asked.runs if one is not run))
        apart = {
            name: one.between for (name, axis), (one, _) in rest.pooled().items() if axis == ALL
        }
        for i in np.flatnonzero(judged).tolist():
            between = apart.get(asked.names[i], 0.0)
            questions += _of_thruster(
                asked, sound, i, (run.name,), run.joint, run.told(i), judged, between
            )
    if len(asked.runs) > 1:
        sound = known.apart_from(*(run.name for run in asked.runs))
        pooled = asked.pooled()
        together = {name: row for (name, axis), row in pooled.items() if axis == ALL}
        unknown = Pooled(0.0, 1.0, 0, 0.0)
        one = [together.get(name, (unknown, ()))[0] for name in asked.names]
        rows = [(row.mean, row.std, float(row.degrees or 30)) for row in one]
        estimates = Estimates(*np.array(rows).T)
        judged = np.array([n in together and len(together[n][1]) > 1 for n in asked.names])
        for i in np.flatnonzero(judged).tolist():
            own = asked.names[i]
            told = {axis: row for (name, axis), (row, _) in pooled.items() if name == own}
            runs = together[own][1]
            questions += _of_thruster(asked, sound, i, runs, estimates, told, judged)
    return questions


def _of_thruster(  # noqa: PLR0917  one thruster among the others
    asked: GainSet,
    sound: References,
    i: int,
    runs: tuple[str, ...],
    estimates: Estimates,
    told: Mapping[str, Pooled],
    judged: BoolArray,
    between_runs: float = 0.0,
) -> list[GainQuestion]:
    value, std, degrees = estimates.value, estimates.std, float(estimates.degrees[i])
    name = asked.names[i]
    usual, other = np.ones(len(asked.names)), "the vehicle file"
    scatter = np.full(len(asked.names), asked.doubt.axis)
    mine = sound.get((name, ALL))
    if mine is not None and mine.ci95[0] > 0.0:
        for k, each in enumerate(asked.names):
            known = sound.get((each, ALL))
            if known is not None and known.ci95[0] > 0.0:
                own = (known.ci95[1] - known.ci95[0]) / 4.0
                usual[k], scatter[k] = known.mean, float(np.hypot(own, known.between_runs))
        other = mine.name
    # what all others share is no thruster's: the scale of a run, or of an axis' mass
    others, alive = [k for k in np.flatnonzero(judged) if k != i], 1.0
    expected, doubt = float(usual[i]), float(scatter[i])
    if others:
        ratios, widths = value[others] / usual[others], std[others] / usual[others]
        apart = asked.doubt.thruster if mine is None else doubt / expected
        common = pool(ratios.tolist(), widths.tolist(), apart)
        alive = float(np.clip(common.ci95[1], 0.0, 1.0))
        middle = float(np.median(ratios))
        if middle > 0.2:
            expected *= middle
            doubt = expected * float(
                np.hypot(apart, max(common.std, common.between / len(others) ** 0.5))
            )
            other = other if mine is not None else "the others"
    doubt = float(np.hypot(doubt, between_runs if mine is None else 0.0))
    low, high = value[i] - estimates.half_width[i], value[i] + estimates.half_width[i]
    spread = float(np.hypot(std[i], doubt))
    less = tail(float(value[i]) - expected, spread, degrees)
    more = tail(expected - float(value[i]), spread, degrees)
    kind: FindingKind = "reversed" if high < 0.0 else "weak"
    question = partial(
        GainQuestion,
        runs=runs,
        thrusters=(name,),
        value=float(value[i]),
        ci95=(float(low), float(high)),
        expected=expected,
        against=other,
    )
    dead = _dead(asked, sound, name, told, alive)
    return [question(kind, less), question("dead", dead), question("strong", more)]


def _dead(
    asked: GainSet, sound: References, name: str, told: Mapping[str, Pooled], alive: float
) -> float:
    """Return the chance that a thruster that is not dead gives so little.

    All axes together tell, or one alone where none differs from 0; all that are asked are counted.
    What the file says of an axis may be far off: one is asked alone only where sound runs surely
    show the thruster, on it or on all together.
    """
    axes = {axis: own for axis, own in told.items() if asked.moves(name, axis)}
    against = {axis for axis, own in axes.items() if abs(own.mean) > own.half_width}
    chances = []
    for axis, own in axes.items():
        known = [sound[name, one] for one in (ALL, axis) if (name, one) in sound]
        if axis != ALL and all(one.ci95[0] <= 0.0 for one in known):
            continue
        # no difference from what is expected, which may be vague, but next to nothing for sure
        gave = [one.mean if one.ci95[0] > 0.0 else max(one.ci95[1], 0.0) for one in known]
        beyond = abs(own.mean) - _DEAD * alive * min([1.0, *gave])
        chance = tail(beyond, own.std, float(own.degrees or 30))
        chances.append(1.0 if (ALL in against if axis == ALL else against) else chance)
    return min(min(chances) * len(chances), 1.0)


def _layouts(asked: GainSet) -> list[GainQuestion]:
    """Ask whether thrusters are exchanged, or an axis counts the other way."""
    questions = []
    layouts = other_layouts(asked.levers)
    by_run = [log_ratios(run.likelihood, asked.levers, layouts, asked.doubt) for run in asked.runs]
    for k, other in enumerate(layouts):
        ratios = [(own[k], run.name) for own, run in zip(by_run, asked.runs, strict=True)]
        total = sum(ratio for ratio, _ in ratios)
        runs = tuple(run for ratio, run in ratios if ratio > 1.0)
        p = float(np.exp(min(-total, 0.0)))
        if other.axis is not None:
            likelihoods = [run.likelihood for run in asked.runs]
            p = max(p, against_all(likelihoods, asked.levers[other.axis], other.axis))
        questions.append(
            GainQuestion(
                other.kind,
                p,
                runs or tuple(run for _, run in ratios),
                tuple(asked.names[i] for i in other.thrusters),
                None if other.axis is None else AXES[other.axis],
            )
        )
    return questions


def _couplings(asked: GainSet) -> list[GainQuestion]:
    """Ask whether a thruster moves an axis that its lever says it cannot."""
    questions = []
    moved = typical(asked.levers) > 0.0
    for (name, axis), (one, runs) in asked.pooled(ORDINARY_COUPLING / 4.0).items():
        if asked.moves(name, axis) or not moved[AXES.index(axis)]:
            continue
        beyond = max(abs(one.mean) - ORDINARY_COUPLING, 0.0)
        spread = float(np.hypot(one.std, one.between / len(runs) ** 0.5))
        p = min(2.0 * tail(-beyond, spread, float(one.degrees or 30)), 1.0)
        questions.append(GainQuestion("coupled", p, runs, (name,), axis, one.mean, one.ci95))
    return questions


def _headings(asked: GainSet) -> list[GainQuestion]:
    """Ask whether the heading turns against the gyroscope, or the commands."""
    return [
        GainQuestion(
            "heading_reversed",
            run.heading.p_negative,
            (run.name,),
            axis="yaw",
            value=run.heading.correlation,
            against=run.heading.told_by,
        )
        for run in asked.runs
        if run.heading is not None
    ]


def _common_scales(asked: GainSet, known: GainSet) -> list[GainQuestion]:
    """Ask whether all thrusters of a run give more or less than in the reference, alike."""
    questions = []
    for run in asked.runs:
        sound = known.apart_from(run.name)
        ratios, widths, scatter = [], [], []
        for i in np.flatnonzero(run.judged(run.joint)).tolist():
            own = sound.get((asked.names[i], ALL))
            if own is None or own.ci95[0] <= 0.0:
                continue
            ratios.append(float(run.joint.value[i]) / own.mean)
            wide = float(np.hypot(run.joint.std[i], (own.ci95[1] - own.ci95[0]) / 4.0))
            widths.append(wide / own.mean)
            scatter.append(own.between_runs / own.mean)
        if len(ratios) < 2:
            continue
        one = pool(ratios, widths)
        apart = max(scatter)
        degrees = float(len(ratios) - 1)
        spread = float(np.hypot(one.std, apart))
        # two-sided, and the thrusters have to agree: else it is one of them
        if one.between > 0.5 * abs(one.mean - 1.0):
            continue
        questions.append(
            GainQuestion(
                "common_scale",
                min(2.0 * tail(-abs(one.mean - 1.0), spread, max(degrees, 8.0)), 1.0),
                (run.name,),
                value=one.mean,
                ci95=(one.mean - 2.0 * spread, one.mean + 2.0 * spread),
                against=next(iter(sound.values())).name,
            )
        )
    return questions


def _without_consequences(found: Sequence[GainQuestion]) -> list[GainQuestion]:
    """Drop what a clearer finding explains: exchanged thrusters look dead, reversed and coupled."""
    layouts = sorted(
        (one for one in found if one.kind in {"swapped", "axis_reversed"}), key=lambda one: one.p
    )
    if not layouts:
        return list(found)
    best = layouts[0]
    kept = [best]
    for one in found:
        if one in layouts or (one.axis is not None and one.axis == best.axis):
            continue
        if set(one.thrusters) & set(best.thrusters) or (
            best.kind == "axis_reversed" and one.kind in {"weak", "dead", "reversed", "coupled"}
        ):
            continue
        kept.append(one)
    return kept


def _merged(kept: Sequence[GainQuestion], chance_of: Mapping[int, float]) -> list[GainFinding]:
    """Make one finding of the same thing in several runs."""
    groups: dict[tuple[str, tuple[str, ...], str | None], list[GainQuestion]] = {}
    for one in kept:
        kind = "weak" if one.kind in {"dead", "reversed"} else one.kind
        groups.setdefault((kind, one.thrusters, one.axis), []).append(one)
    found = []
    for rows in groups.values():
        clearest = min(rows, key=lambda one: (-len(one.runs) if len(rows) == 1 else 0, one.p))
        single = sorted({run for one in rows if len(one.runs) == 1 for run in one.runs})
        runs = tuple(single) or clearest.runs
        found.append(
            GainFinding(
                kind=clearest.kind,
                thrusters=clearest.thrusters,
                axis=clearest.axis,
                runs=runs,
                value=clearest.value,
                ci95=clearest.ci95,
                p_value=min(chance_of[id(one)] for one in rows),
                text=sentence(clearest, runs),
            )
        )
    return sorted(found, key=lambda one: one.p_value)
