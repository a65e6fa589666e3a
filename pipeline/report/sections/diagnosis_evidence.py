"""A diagnosis' page: how it was decided, for whoever doubts it."""

import numpy as np

from pipeline.records.diagnosis import ChannelNoiseCheck, DiagnosisRecord
from pipeline.report.blocks import Block, Bullets, Details, Paragraph, Section, Table
from pipeline.report.diagnosis_words import (
    REGRESSORS,
    identifiers,
    in_words,
    listed,
    of_bench,
    said,
    verdict_sentence,
)
from pipeline.report.numbers import fixed, general, plural
from pipeline.report.sections.diagnosis_answer import correlated

#: Whitened residuals of a right noise model lie in here.
VARIANCE, LAG1 = (0.8, 1.2), 0.1
#: What the table shows as widened, with two places.
_WIDENED = 1.005
#: Outside force over that of a sound vehicle up to which nothing is said of it.
_ORDINARY = 1.0
#: Below this angle two effects are one answer. [deg]
ONE_ANSWER_DEG = 10.0
#: More pairs than this are folded away.
_PAIRS = 12
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
        Bullets(tuple(answers)),
        *_noise(record.evidence.noise),
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


def _noise(noise: dict[str, ChannelNoiseCheck]) -> list[Block]:
    if not noise:
        return [Paragraph("The noise of the readings was not checked.", tone="warning")]
    table = Table.of(
        "Check of the noise: what the best model leaves, in units of the noise",
        [
            {
                "Channel": name.replace("_", " "),
                "Variance": fixed(check.variance, 2),
                "Correlation of neighbours": fixed(check.lag1, 2),
                "Noise widened by": fixed(check.widened_by, 2),
            }
            for name, check in noise.items()
        ],
        row_classes=tuple("" if white(check) else "warning" for check in noise.values()),
        note=f"Right: variance {VARIANCE[0]:g} to {VARIANCE[1]:g}, correlation within "
        f"±{LAG1:g}; what is not is marked.",
    )
    return [Paragraph(_noise_said(noise)), table]


def _noise_said(noise: dict[str, ChannelNoiseCheck]) -> str:
    odd = listed([name.replace("_", " ") for name, check in noise.items() if not white(check)])
    if not odd:
        return (
            "The readings scatter about the best model as the noise model says, so they count in "
            "full."
        )
    if max(check.widened_by for check in noise.values()) < _WIDENED:
        return (
            f"The noise model does not fit {odd}: the table says how. Nothing was widened for it."
        )
    return (
        f"The noise model does not fit {odd}: the table says how, and how much wider the noise was "
        "taken before the evidence was counted."
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
    near = [angle_deg(cosine) <= ONE_ANSWER_DEG for *_, cosine in pairs]
    table = Table.of(
        "Closest pairs of effects",
        [
            {"Effect": in_words(a), "and": in_words(b), "Angle [deg]": fixed(angle_deg(cosine), 1)}
            for a, b, cosine in pairs
        ],
        row_classes=tuple("warning" if one else "" for one in near),
        note="Angle between what the two effects do to the readings, after everything that is "
        "ordinary has been taken away: 0 means the same trace, 90 nothing in common.",
    )
    said = (
        f"Known from the runs alone, before the verdict. Marked: closer than {ONE_ANSWER_DEG:g} "
        "degrees, one answer unless the verdict names a thruster, axis or size that tells them "
        "apart."
        if any(near)
        else f"No two effects come closer than {ONE_ANSWER_DEG:g} degrees; the closest pairs:"
    )
    shown = table if len(pairs) <= _PAIRS else Details(f"{len(pairs)} pairs", (table,))
    return Section("confusable", title, (Paragraph(said), shown))


def angle_deg(cosine: float) -> float:
    """Angle of a cosine. [deg].

    >>> angle_deg(1.0), round(angle_deg(0.5), 6)
    (0.0, 60.0)
    """
    return float(np.degrees(np.arccos(np.clip(abs(cosine), 0.0, 1.0))))
