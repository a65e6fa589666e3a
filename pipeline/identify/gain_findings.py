"""What the gains of runs show: dead, weak, reversed, swapped and coupled thrusters, by test.

Every question that is asked of a set of runs has a p-value; all of them are counted together
(`gain_tests.rejected`), and only what is rejected is told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.identify.gain_estimates import WIDEST, pool
from pipeline.identify.gain_sentences import GainQuestion, sentence
from pipeline.identify.gain_tests import (
    ORDINARY_COUPLING,
    adjusted,
    against_all,
    log_ratios,
    moved_apart,
    other_layouts,
    rejected,
    tail,
)
from pipeline.identify.thruster_gains import (
    ALL,
    GainSet,
    References,
    RunGains,
    Sound,
    pooled_gains,
)
from pipeline.records.gains import FindingKind, GainFinding
from pipeline.records.intervals import student_95

#: A thruster is dead whose interval holds 0 and which surely gives less than this share, either
#: way, of what sound runs gave, or the file says.
_DEAD = 0.5


def findings_of(asked: GainSet, sound: Sound) -> list[GainFinding]:
    """Ask all questions of a set of runs, and tell what stands.

    Parameters
    ----------
    asked : GainSet
        The runs.
    sound : Sound
        Runs that are known to be sound; a run is compared with the others of them.
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
        p = [min(one.p * len(groups), 1.0) for one in questions]
        chances = zip(questions, adjusted(p), rejected(p), strict=True)
        found += [(one, float(chance)) for one, chance, stands in chances if stands]
    kept = _without_consequences([one for one, _ in found])
    chance_of = {id(one): chance for one, chance in found}
    return _merged(kept, chance_of)


def _thrusters(asked: GainSet, known: Sound) -> list[GainQuestion]:
    """Ask of each thruster in each run, and in all, whether it gives what is expected."""
    questions: list[GainQuestion] = []
    for run in asked.runs:
        told = run.likelihood
        sound = known.apart_from(told.run)
        half = run.joint.half_width()
        judged = told.excited & (half < WIDEST)
        # what runs differ by that nobody logged is ordinary too: of the others, for want of more
        rest = replace(asked, runs=tuple(one for one in asked.runs if one is not run))
        apart = {
            name: one.between
            for (name, axis), (one, _) in pooled_gains(rest).items()
            if axis == ALL
        }
        for i in np.flatnonzero(judged):
            questions += _of_thruster(
                asked,
                sound,
                int(i),
                (told.run,),
                run.joint.value,
                run.joint.std,
                judged,
                float(run.joint.degrees[i]),
                apart.get(asked.names[i], 0.0),
            )
    together = {name: one for (name, axis), one in pooled_gains(asked).items() if axis == ALL}
    if len(asked.runs) > 1:
        sound = known.apart_from(*(run.likelihood.run for run in asked.runs))
        value = np.array([together[n][0].mean if n in together else 0.0 for n in asked.names])
        std = np.array([together[n][0].std if n in together else 1.0 for n in asked.names])
        judged = np.array([n in together and len(together[n][1]) > 1 for n in asked.names])
        for i in np.flatnonzero(judged):
            one, runs = together[asked.names[i]]
            degrees = float(one.degrees or 30)
            questions += _of_thruster(asked, sound, int(i), runs, value, std, judged, degrees)
    return questions


def _of_thruster(  # noqa: PLR0917  one thruster among the others
    asked: GainSet,
    sound: References,
    i: int,
    runs: tuple[str, ...],
    value: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    std: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    judged: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    degrees: float,
    between_runs: float = 0.0,
) -> list[GainQuestion]:
    name = asked.names[i]
    usual, scatter, other = (
        np.ones(len(asked.names)),
        np.zeros(len(asked.names)),
        "the vehicle file",
    )
    scatter[:] = asked.doubt.axis
    mine = sound.get((name, ALL))
    if mine is not None and mine.ci95[0] > 0.0:
        for k, each in enumerate(asked.names):
            known = sound.get((each, ALL))
            if known is not None and known.ci95[0] > 0.0:
                own = (known.ci95[1] - known.ci95[0]) / 4.0
                usual[k], scatter[k] = known.mean, float(np.hypot(own, known.between_runs))
        other = mine.name
    # what all others share is no thruster's: the scale of a run, or of an axis' mass
    others = [k for k in np.flatnonzero(judged) if k != i]
    expected, doubt = float(usual[i]), float(scatter[i])
    if others:
        ratios, widths = value[others] / usual[others], std[others] / usual[others]
        apart = asked.doubt.thruster if mine is None else doubt / expected
        common = pool(ratios.tolist(), widths.tolist(), apart)
        middle = float(np.median(ratios))
        if middle > 0.2:
            expected *= middle
            doubt = expected * float(
                np.hypot(apart, max(common.std, common.between / len(others) ** 0.5))
            )
            other = other if mine is not None else "the others"
    doubt = float(np.hypot(doubt, between_runs if mine is None else 0.0))
    factor = student_95(max(int(degrees), 1))
    low, high = value[i] - factor * std[i], value[i] + factor * std[i]
    spread = float(np.hypot(std[i], doubt))
    less = tail(float(value[i]) - expected, spread, degrees)
    more = tail(expected - float(value[i]), spread, degrees)
    kind: FindingKind = "reversed" if high < 0.0 else "weak"
    # dead is no difference from what is expected, which may be vague, but next to nothing for sure
    limit = _DEAD * min(float(usual[i]), 1.0)
    nothing = tail(abs(float(value[i])) - limit, float(std[i]), degrees)
    if not low <= 0.0 <= high:
        nothing = 1.0
    figures = {
        "runs": runs,
        "thrusters": (name,),
        "value": float(value[i]),
        "ci95": (float(low), float(high)),
        "expected": expected,
        "against": other,
    }
    return [
        GainQuestion(kind, less, **figures),  # type: ignore[arg-type]
        GainQuestion("dead", nothing, **figures),  # type: ignore[arg-type]
        GainQuestion("strong", more, **figures),  # type: ignore[arg-type]
    ]


def _layouts(asked: GainSet) -> list[GainQuestion]:
    """Ask whether thrusters are exchanged, or an axis counts the other way."""
    questions = []
    layouts = other_layouts(asked.levers)
    by_run = [log_ratios(run.likelihood, asked.levers, layouts, asked.doubt) for run in asked.runs]
    for k, other in enumerate(layouts):
        ratios = [(own[k], run.likelihood.run) for own, run in zip(by_run, asked.runs, strict=True)]
        total = sum(ratio for ratio, _ in ratios)
        runs = tuple(run for ratio, run in ratios if ratio > 1.0)
        p = float(np.exp(min(-total, 0.0)))
        if other.axis is not None:
            likelihoods = [run.likelihood for run in asked.runs]
            p = max(p, against_all(likelihoods, asked.levers[other.axis], other.axis))
        questions.append(
            GainQuestion(
                "swapped" if other.kind == "swapped" else "axis_reversed",
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
    for (name, axis), (one, runs) in pooled_gains(asked, ORDINARY_COUPLING / 4.0).items():
        if axis == ALL or not moved_apart(asked.levers)[AXES.index(axis), asked.names.index(name)]:
            continue
        beyond = max(abs(one.mean) - ORDINARY_COUPLING, 0.0)
        degrees = float(one.degrees or 30)
        questions.append(
            GainQuestion(
                "coupled",
                min(
                    2.0
                    * tail(
                        -beyond, float(np.hypot(one.std, one.between / len(runs) ** 0.5)), degrees
                    ),
                    1.0,
                ),
                runs,
                (name,),
                axis,
                one.mean,
                (one.mean - one.half_width, one.mean + one.half_width),
            )
        )
    return questions


def _headings(asked: GainSet) -> list[GainQuestion]:
    """Ask whether the heading turns against the commands."""
    return [
        GainQuestion(
            "heading_reversed",
            run.heading.p_negative,
            (run.likelihood.run,),
            axis="yaw",
            value=run.heading.correlation,
        )
        for run in asked.runs
        if run.heading is not None
    ]


def _common_scales(asked: GainSet, known: Sound) -> list[GainQuestion]:
    """Ask whether all thrusters of a run give more or less than in the reference, alike."""
    questions = []
    for run in asked.runs:
        sound = known.apart_from(run.likelihood.run)
        ratios, widths, scatter = _ratios(asked, run, sound)
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
                (run.likelihood.run,),
                value=one.mean,
                ci95=(one.mean - 2.0 * spread, one.mean + 2.0 * spread),
                against=next(iter(sound.values())).name,
            )
        )
    return questions


def _ratios(
    asked: GainSet, run: RunGains, sound: References
) -> tuple[list[float], list[float], list[float]]:
    half = run.joint.half_width()
    ratios, widths, scatter = [], [], []
    for i, name in enumerate(asked.names):
        known = sound.get((name, ALL))
        if (
            known is None
            or known.ci95[0] <= 0.0
            or not run.likelihood.excited[i]
            or half[i] >= WIDEST
        ):
            continue
        own = (known.ci95[1] - known.ci95[0]) / 4.0
        ratios.append(float(run.joint.value[i]) / known.mean)
        widths.append(float(np.hypot(run.joint.std[i], own)) / known.mean)
        scatter.append(known.between_runs / known.mean)
    return ratios, widths, scatter


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
