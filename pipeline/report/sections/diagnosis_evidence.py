"""A diagnosis' page: how it was decided, for whoever doubts it."""

from collections.abc import Sequence

import numpy as np

from pipeline.records.diagnosis import ChannelNoiseCheck, DiagnosisRecord
from pipeline.report.blocks import Block, Bullets, Details, Links, Paragraph, Section, Table
from pipeline.report.diagnosis_words import (
    REGRESSORS,
    effect_names,
    identifiers,
    in_words,
    listed,
    of_bench,
    said,
    verdict_sentence,
)
from pipeline.report.numbers import fixed, general, plural
from pipeline.report.sections.diagnosis_answer import correlated, verdict_facts

#: Whitened residuals of a right noise model lie in here.
VARIANCE, LAG1 = (0.8, 1.2), 0.1
#: What the table shows as widened, with two places.
_WIDENED = 1.005
#: Outside force over that of a sound vehicle up to which nothing is said of it.
_ORDINARY = 1.0
#: Below this angle two effects are one answer. [deg]
ONE_ANSWER_DEG = 10.0
_STAGES = {
    "kinematics": "Do the sensors agree with each other?",
    "actuators": "Do the thrusters do what they are told?",
    "dynamics": "Does the vehicle move as the forces say?",
}


def evidence_section(record: DiagnosisRecord) -> Section:
    """Show the answer as computed, the stages, the check of the noise, and what is left."""
    stages = record.evidence.stages
    order = {name: place for place, name in enumerate(_STAGES)}
    answers = [
        f"{said(_STAGES.get(name, name))} {said(stages[name])}"
        for name in sorted(stages, key=lambda one: (order.get(one, len(order)), one))
    ]
    blocks: list[Block] = [
        Paragraph(verdict_sentence(record.verdict)),
        Bullets((*verdict_facts(record), *answers)),
        *_noise(record.evidence.noise, bench=of_bench(record)),
        Bullets(tuple(_facts(record))),
        *_leftover(record),
        Paragraph(
            "The method, its assumptions, when to distrust it and how often it is right: "
            "docs/diagnosis_bench.md."
            if of_bench(record)
            else "The method, its assumptions and when to distrust it: docs/diagnosis.md. How "
            "often it is right, measured on cases with sealed labels: docs/blind_check.md.",
            tone="note",
        ),
    ]
    return Section("evidence", "How it was decided", tuple(blocks))


def _facts(record: DiagnosisRecord) -> list[str]:
    """Say what the evidence is made of, and what it rests on."""
    evidence = record.evidence
    facts = []
    if of_bench(record):
        facts.append(f"Evidence of {plural(evidence.readings, 'reading')}, averaged by code.")
    else:
        facts.append(
            f"Evidence of {plural(evidence.windows, 'window')} of {general(evidence.window_s, 3)} "
            f"s each, with {evidence.readings} readings in all; linearisations of the model: "
            f"{evidence.linearisations}."
        )
        facts.append(
            f"What a sound vehicle leaves was learned from {identifiers(evidence.healthy_runs)}, "
            "and then frozen."
            if evidence.healthy_runs
            else "What a sound vehicle leaves is drawn from the uncertainties and sensor figures "
            "of the vehicle file; no sound run was given."
        )
        facts.append(
            "Outside force that the readings want beside the answer: "
            f"{general(evidence.force_scale, 2)} times that of a sound vehicle."
        )
    facts.append(f"Kept aside: {record.shrink.held_out.rstrip('.')}.")
    facts.append(f"Thresholds and their origin: {evidence.calibrated.rstrip('.')}.")
    facts.append(f"It took {general(record.elapsed_s, 2)} s.")
    return facts


def white(check: ChannelNoiseCheck) -> bool:
    """Tell whether a channel's whitened residual is as white as evidence needs it."""
    return VARIANCE[0] <= check.variance <= VARIANCE[1] and abs(check.lag1) < LAG1


def _noise(noise: dict[str, ChannelNoiseCheck], *, bench: bool) -> list[Block]:
    if not noise:
        return [Paragraph("The noise of the readings was not checked.", tone="warning")]
    table = Table(
        "Check of the noise: what the best model leaves, in units of the noise",
        ("Channel", "Variance", "Correlation of neighbours", "Noise widened by"),
        tuple(
            (
                name.replace("_", " "),
                fixed(check.variance, 2),
                fixed(check.lag1, 2),
                fixed(check.widened_by, 2),
            )
            for name, check in noise.items()
        ),
        row_classes=tuple("" if white(check) else "warning" for check in noise.values()),
        note=f"Right: variance {VARIANCE[0]:g} to {VARIANCE[1]:g}, correlation within "
        f"±{LAG1:g}; what is not is marked.",
    )
    return [Paragraph(_noise_said(noise, bench=bench)), table]


def _noise_said(noise: dict[str, ChannelNoiseCheck], *, bench: bool) -> str:
    odd = [name.replace("_", " ") for name, check in noise.items() if not white(check)]
    if not odd:
        return (
            "The readings scatter about the best model as the noise model says, so they count in "
            "full."
        )
    if bench:
        return (
            f"The noise model does not fit {listed(odd)}: the table says how. Nothing was "
            "widened for it: a mooring table has few readings, and smooth errors of both tables "
            "are counted as such."
        )
    if max(check.widened_by for check in noise.values()) < _WIDENED:
        return (
            f"The noise model does not fit {listed(odd)}: the table says how. Nothing was widened "
            "for it: readings that scatter less than stated, or turn about, count as they are."
        )
    return (
        f"The noise model does not fit {listed(odd)}: the table says how, and how much "
        "wider the noise was taken before the evidence was counted."
    )


def _leftover(record: DiagnosisRecord) -> list[Block]:
    left = record.leftover
    if not left.axes:
        return []
    # which axis is the largest of ordinary ones, and what it goes with, is chance
    if not of_bench(record) and max(left.axes.values()) <= _ORDINARY:
        text = "What the answer leaves is ordinary: on no axis more than on a sound vehicle."
        return [Paragraph(text)]
    depends = ""
    if left.depends_on is not None:
        depends = (
            f" It goes with {REGRESSORS.get(left.depends_on, left.depends_on)}{correlated(left)}."
        )
    course = left.time_course.rstrip(".")
    return [Paragraph(f"What the answer leaves: mostly {left.worst_axis}, {course}.{depends}")]


def confusable_section(record: DiagnosisRecord) -> Section:
    """Name the effects that these runs cannot separate, known before the verdict."""
    title = "What cannot be told apart"
    pairs = sorted(record.confusable, key=lambda pair: -pair[2])
    if not pairs:
        text = "Every two candidates leave traces of their own in these runs."
        return Section("confusable", title, (Paragraph(text),))
    groups = confusable_groups(record.confusable)
    blocks: list[Block] = []
    if groups:
        blocks += [
            Paragraph(
                "Known from the runs alone, before the verdict: the traces of these effects in the "
                f"measured channels differ by less than {ONE_ANSWER_DEG:g} degrees, so each group "
                "is one answer."
            ),
            Bullets(tuple(effect_names(group) for group in groups)),
        ]
        apart = _apart_all_the_same(record, groups)
        if apart:
            blocks.append(Paragraph(apart))
    else:
        blocks.append(
            Paragraph(
                f"No two effects come closer than {ONE_ANSWER_DEG:g} degrees; the closest pairs:"
            )
        )
    table = Table(
        "Closest pairs of effects",
        ("Effect", "and", "Angle [deg]"),
        tuple((in_words(a), in_words(b), fixed(angle_deg(cosine), 1)) for a, b, cosine in pairs),
        row_classes=tuple(
            "warning" if angle_deg(cosine) <= ONE_ANSWER_DEG else "" for *_, cosine in pairs
        ),
        note="Angle between what the two effects do to the readings, after everything that is "
        "ordinary has been taken away: 0 means the same trace, 90 nothing in common.",
    )
    blocks.append(table if len(pairs) <= 12 else Details(f"{len(pairs)} pairs", (table,)))
    return Section("confusable", title, tuple(blocks))


def _apart_all_the_same(record: DiagnosisRecord, groups: Sequence[Sequence[str]]) -> str:
    """Say of a verdict that stands in a group why it is told from the others all the same.

    What is alike to what the verdict explains is in its answer set; the angles here are the
    smallest of any parameter of an effect.
    """
    verdict = record.verdict
    if of_bench(record) or set(verdict.effects) & {"none", "unknown"}:
        return ""
    # errors of the DVL may have been settled by comparing instruments, which knows no angles
    mine = {name for name in verdict.effects if not name.startswith("dvl_")}
    near = {name for group in groups if mine & set(group) for name in group}
    others = sorted(near - {*verdict.effects, *verdict.ambiguous_with})
    if not others:
        return ""
    return (
        f"The verdict is distinguished from {effect_names(others)} all the same: what it explains "
        f"in these runs lies more than {ONE_ANSWER_DEG:g} degrees away, and the small angle is of "
        "another thruster, axis or parameter."
    )


def angle_deg(cosine: float) -> float:
    """Angle of a cosine. [deg].

    >>> angle_deg(1.0), round(angle_deg(0.5), 6)
    (0.0, 60.0)
    """
    return float(np.degrees(np.arccos(np.clip(abs(cosine), 0.0, 1.0))))


def confusable_groups(pairs: tuple[tuple[str, str, float], ...]) -> tuple[tuple[str, ...], ...]:
    """Join pairs that are one answer into groups.

    >>> confusable_groups((("a", "b", 0.999), ("b", "c", 0.99), ("d", "e", 0.5)))
    (('a', 'b', 'c'),)
    """
    groups: list[set[str]] = []
    for first, second, cosine in pairs:
        if angle_deg(cosine) > ONE_ANSWER_DEG:
            continue
        touched = [group for group in groups if first in group or second in group]
        groups = [group for group in groups if group not in touched]
        groups.append({first, second}.union(*touched))
    return tuple(sorted(tuple(sorted(group)) for group in groups))


def files_section(record: DiagnosisRecord, files: tuple[tuple[str, str], ...]) -> Section:
    """Name the runs and link the files of the diagnosis."""
    rows = [
        ("Runs", identifiers(record.runs) or "–"),
        ("Kept aside", identifiers(record.holdout) or "–"),
    ]
    if record.evidence.healthy_runs:
        rows.append(("Sound runs", identifiers(record.evidence.healthy_runs)))
    blocks: list[Block] = [Table("What was diagnosed", ("What", "Names"), tuple(rows))]
    if files:
        blocks.append(Links(files))
    return Section("files", "Runs and files", tuple(blocks))
