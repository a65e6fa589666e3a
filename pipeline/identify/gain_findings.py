"""What the gains of runs show: dead, weak, reversed, swapped and coupled thrusters, by test.

Every question that is asked of a set of runs has a p-value; all of them are counted together
(`gain_tests.adjusted`), and only what is rejected is told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.identify.gain_estimates import ALL, Gain, Gains, GainSet, References, pool, typical
from pipeline.identify.gain_tests import (
    FALSE_ALARMS,
    ORDINARY_COUPLING,
    GainQuestion,
    adjusted,
    against_all,
    layout_evidence,
    other_layouts,
    sentence,
    tail,
)
from pipeline.records.gains import GainFinding, GainReference

#: A thruster is dead whose interval holds 0 and which surely gives less than this share, either
#: way, of what sound runs gave, or may have, or the file says, and of that what the others of the
#: run may give.
_DEAD = 0.5
#: Degrees of freedom that stand for many.
_MANY = 30


def findings_of(asked: GainSet, sound: GainSet) -> list[GainFinding]:
    """Ask all questions of a set of runs, and tell what stands.

    `sound` are runs that are known to be so; a run is compared with the others of them.
    """
    # half of the rate for single thrusters, half for all else: the many other questions are not to
    # hide a dead one
    groups = (
        _thrusters(asked, sound),
        [*_layouts(asked), *_couplings(asked), *_headings(asked), *_common_scales(asked, sound)],
    )
    found: list[GainQuestion] = []
    for questions in groups:
        chances = adjusted([min(one.p * len(groups), 1.0) for one in questions]).tolist()
        found += [
            replace(one, chance=chance)
            for one, chance in zip(questions, chances, strict=True)
            if chance <= FALSE_ALARMS
        ]
    return _merged(_without_consequences(found))


def _thrusters(asked: GainSet, known: GainSet) -> list[GainQuestion]:
    """Ask of each thruster in each run, and in all, whether it gives what is expected."""
    questions: list[GainQuestion] = []
    for run in asked.runs:
        # what runs differ by that nobody logged is ordinary too: of the others, for want of more
        rest = replace(asked, runs=tuple(one for one in asked.runs if one is not run)).pooled()
        apart = {name: one.between for (name, axis), one in rest.items() if axis == ALL}
        questions += _of_thrusters(asked, known.apart_from(run.name), run.told, apart)
    if len(asked.runs) > 1:
        rows = {
            key: one for key, one in asked.pooled().items() if key[1] != ALL or len(one.runs) > 1
        }
        sound = known.apart_from(*(run.name for run in asked.runs))
        questions += _of_thrusters(asked, sound, rows, {})
    return questions


def _of_thrusters(
    asked: GainSet, sound: References, rows: Gains, between: Mapping[str, float]
) -> list[GainQuestion]:
    """Ask of each thruster that `rows` tell on all axes together; `between`: ordinary scatter."""
    joint = {
        name: replace(rows[name, ALL], degrees=rows[name, ALL].degrees or _MANY)
        for name in asked.names
        if (name, ALL) in rows
    }
    sure = {name: own for (name, axis), own in sound.items() if axis == ALL and own.ci95[0] > 0.0}
    questions = []
    for name, own in joint.items():
        mine, told_by = sound.get((name, ALL)), "the vehicle file"
        usual, doubt = dict.fromkeys(joint, 1.0), asked.doubt.axis
        if name in sure:
            usual |= {other: sure[other].mean for other in joint if other in sure}
            doubt = float(np.hypot(_std_of(sure[name]), sure[name].between_runs))
            told_by = sure[name].name
        expected, alive = usual[name], 1.0
        # what all others share is no thruster's: the scale of a run, or of an axis' mass
        others = [other for other in joint if other != name]
        if others:
            ratios = [joint[other].mean / usual[other] for other in others]
            widths = [joint[other].std / usual[other] for other in others]
            apart = asked.doubt.thruster if mine is None else doubt / expected
            common = pool(ratios, widths, apart)
            alive = float(np.clip(common.ci95[1], 0.0, 1.0))
            middle = float(np.median(ratios))
            if middle > 0.2:
                expected *= middle
                shared = max(common.std, common.between / len(others) ** 0.5)
                doubt = expected * float(np.hypot(apart, shared))
                told_by = told_by if mine is not None else "the others"
        doubt = float(np.hypot(doubt, between.get(name, 0.0) if mine is None else 0.0))
        spread = float(np.hypot(own.std, doubt))
        question = partial(
            GainQuestion,
            runs=own.runs,
            thrusters=(name,),
            value=own.mean,
            ci95=own.ci95,
            expected=expected,
            against=told_by,
        )
        told = {axis: row for (of, axis), row in rows.items() if of == name}
        questions += [
            question(
                "reversed" if own.ci95[1] < 0.0 else "weak",
                tail(own.mean - expected, spread, own.degrees),
            ),
            question("dead", _dead(asked, sound, name, told, alive)),
            question("strong", tail(expected - own.mean, spread, own.degrees)),
        ]
    return questions


def _std_of(sound: GainReference) -> float:
    return (sound.ci95[1] - sound.ci95[0]) / 4.0


def _dead(
    asked: GainSet, sound: References, name: str, told: Mapping[str, Gain], alive: float
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
        chance = tail(beyond, own.std, own.degrees or _MANY)
        chances.append(1.0 if (ALL in against if axis == ALL else against) else chance)
    return min(min(chances) * len(chances), 1.0)


def _layouts(asked: GainSet) -> list[GainQuestion]:
    """Ask whether thrusters are exchanged, or an axis counts the other way."""
    questions = []
    layouts = other_layouts(asked.levers)
    told, doubt = [run.likelihood for run in asked.runs], asked.doubt
    file = [layout_evidence(run, asked.levers, doubt) for run in told]
    for other in layouts:
        ratios = [
            layout_evidence(run, other.levers, doubt, exchanged=True) - own
            for run, own in zip(told, file, strict=True)
        ]
        runs = tuple(run.run for run, ratio in zip(told, ratios, strict=True) if ratio > 1.0)
        p = float(np.exp(min(-sum(ratios), 0.0)))
        if other.axis is not None:
            p = max(p, against_all(told, asked.levers[other.axis], other.axis))
        questions.append(
            GainQuestion(
                other.kind,
                p,
                runs or tuple(run.run for run in told),
                tuple(asked.names[i] for i in other.thrusters),
                None if other.axis is None else AXES[other.axis],
            )
        )
    return questions


def _couplings(asked: GainSet) -> list[GainQuestion]:
    """Ask whether a thruster moves an axis that its lever says it cannot."""
    questions = []
    moved = typical(asked.levers) > 0.0
    for (name, axis), one in asked.pooled(ORDINARY_COUPLING / 4.0).items():
        if asked.moves(name, axis) or not moved[AXES.index(axis)]:
            continue
        beyond = max(abs(one.mean) - ORDINARY_COUPLING, 0.0)
        spread = float(np.hypot(one.std, one.between / len(one.runs) ** 0.5))
        p = min(2.0 * tail(-beyond, spread, one.degrees or _MANY), 1.0)
        questions.append(GainQuestion("coupled", p, one.runs, (name,), axis, one.mean, one.ci95))
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
        sound, rows = known.apart_from(run.name), run.told
        both = [
            (rows[name, ALL], sound[name, ALL])
            for name in asked.names
            if (name, ALL) in rows and (name, ALL) in sound and sound[name, ALL].ci95[0] > 0.0
        ]
        if len(both) < 2:
            continue
        ratios = [row.mean / own.mean for row, own in both]
        widths = [float(np.hypot(row.std, _std_of(own))) / own.mean for row, own in both]
        one, apart = pool(ratios, widths), max(own.between_runs / own.mean for _, own in both)
        spread = float(np.hypot(one.std, apart))
        # two-sided, and the thrusters have to agree: else it is one of them
        if one.between > 0.5 * abs(one.mean - 1.0):
            continue
        questions.append(
            GainQuestion(
                "common_scale",
                min(2.0 * tail(-abs(one.mean - 1.0), spread, max(len(both) - 1, 8)), 1.0),
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


def _merged(kept: Sequence[GainQuestion]) -> list[GainFinding]:
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
                p_value=min(one.chance for one in rows),
                text=sentence(clearest, runs),
            )
        )
    return sorted(found, key=lambda one: one.p_value)
