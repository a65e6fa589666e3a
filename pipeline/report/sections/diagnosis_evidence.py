"""A diagnosis' page: how it was decided, for whoever doubts it."""

from collections.abc import Iterator

import numpy as np

from pipeline.records.diagnosis import ChannelNoiseCheck, DiagnosisRecord
from pipeline.report import diagnosis_words as words
from pipeline.report.blocks import Blocks, Bullets, Details, Table, Text, chapter
from pipeline.report.numbers import general, plural
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


@chapter("evidence", "How it was decided")
def evidence_section(record: DiagnosisRecord) -> Blocks:
    """Show the answer as computed, the stages, the check of the noise, and what is left."""
    stages = record.evidence.stages
    order = {name: place for place, name in enumerate(_STAGES)}
    answers = [
        f"{words.said(_STAGES.get(name, name))} {words.said(stages[name])}"
        for name in sorted(stages, key=lambda one: (order.get(one, len(order)), one))
    ]
    yield Text(words.verdict_sentence(record.verdict))
    yield Bullets(tuple(answers))
    yield from _noise(record.evidence.noise)
    yield Bullets(tuple(_facts(record)))
    yield _leftover(record)
    yield Text(
        "The method, its assumptions, when to distrust it and how often it is right: "
        "docs/diagnosis_bench.md."
        if words.of_bench(record)
        else "The method, its assumptions and when to distrust it: docs/diagnosis.md. How "
        "often it is right, measured on cases with sealed labels: docs/blind_check.md.",
        tone="note",
    )


def _facts(record: DiagnosisRecord) -> Iterator[str]:
    """Say what the evidence is made of, and what it rests on."""
    evidence = record.evidence
    if words.of_bench(record):
        yield f"Evidence of {plural(evidence.readings, 'reading')}, averaged by code."
    else:
        yield (
            f"Evidence of {plural(evidence.windows, 'window')} of {general(evidence.window_s, 3)} "
            f"s each, with {evidence.readings} readings in all; linearisations of the model: "
            f"{evidence.linearisations}."
        )
        healthy = words.identifiers(evidence.healthy_runs)
        yield (
            f"What a sound vehicle leaves was learned from {healthy}, and then frozen."
            if evidence.healthy_runs
            else "What a sound vehicle leaves is drawn from the uncertainties and sensor figures "
            "of the vehicle file; no sound run was given."
        )
        yield (
            "Outside force that the readings want beside the answer: "
            f"{general(evidence.force_scale, 2)} times that of a sound vehicle."
        )
    yield f"Kept aside: {record.shrink.held_out.rstrip('.')}."
    yield f"Thresholds and their origin: {evidence.calibrated.rstrip('.')}."
    yield f"It took {general(record.elapsed_s, 2)} s."


def white(check: ChannelNoiseCheck) -> bool:
    """Tell whether a channel's whitened residual is as white as evidence needs it."""
    return VARIANCE[0] <= check.variance <= VARIANCE[1] and abs(check.lag1) < LAG1


def _noise(noise: dict[str, ChannelNoiseCheck]) -> Blocks:
    if not noise:
        yield Text("The noise of the readings was not checked.", tone="warning")
        return
    odd = words.listed(
        [name.replace("_", " ") for name, check in noise.items() if not white(check)]
    )
    widened = max(check.widened_by for check in noise.values()) >= _WIDENED
    yield Text(
        "The readings scatter about the best model as the noise model says, so they count in full."
        if not odd
        else f"The noise model does not fit {odd}: the table says how, and how much wider the "
        "noise was taken before the evidence was counted."
        if widened
        else f"The noise model does not fit {odd}: the table says how. Nothing was widened for it."
    )
    yield Table.of(
        "Check of the noise: what the best model leaves, in units of the noise",
        noise.items(),
        "Channel: {0:words} | Variance: {1.variance:.2f} | "
        "Correlation of neighbours: {1.lag1:.2f} | Noise widened by: {1.widened_by:.2f}",
        lambda own: not white(own[1]),
        note=f"Right: variance {VARIANCE[0]:g} to {VARIANCE[1]:g}, correlation within "
        f"±{LAG1:g}; what is not is marked.",
    )


def _leftover(record: DiagnosisRecord) -> Text | None:
    left = record.leftover
    if not left.axes:
        return None
    # which axis is the largest of ordinary ones, and what it goes with, is chance
    if not words.of_bench(record) and max(left.axes.values()) <= _ORDINARY:
        text = "What the answer leaves is ordinary: on no axis more than on a sound vehicle."
        return Text(text)
    depends = ""
    if left.depends_on is not None:
        name = words.REGRESSORS.get(left.depends_on, left.depends_on)
        depends = f" It goes with {name}{correlated(left)}."
    course = left.time_course.rstrip(".")
    return Text(f"What the answer leaves: mostly {left.worst_axis}, {course}.{depends}")


@chapter("confusable", "What cannot be told apart")
def confusable_section(record: DiagnosisRecord) -> Blocks:
    """Name the effects that these runs cannot separate, known before the verdict."""
    pairs = sorted(record.confusable, key=lambda pair: -pair[2])
    if not pairs:
        yield Text("Every two candidates leave traces of their own in these runs.")
        return
    found = [(words.in_words(a), words.in_words(b), angle_deg(cosine)) for a, b, cosine in pairs]
    table = Table.of(
        "Closest pairs of effects",
        found,
        "Effect: {0} | and: {1} | Angle [deg]: {2:.1f}",
        lambda pair: pair[2] <= ONE_ANSWER_DEG,
        note="Angle between what the two effects do to the readings, after everything that is "
        "ordinary has been taken away: 0 means the same trace, 90 nothing in common.",
    )
    yield Text(
        f"Known from the runs alone, before the verdict. Marked: closer than {ONE_ANSWER_DEG:g} "
        "degrees, one answer unless the verdict names a thruster, axis or size that tells them "
        "apart."
        if min(angle for *_, angle in found) <= ONE_ANSWER_DEG
        else f"No two effects come closer than {ONE_ANSWER_DEG:g} degrees; the closest pairs:"
    )
    yield table if len(pairs) <= _PAIRS else Details(f"{len(pairs)} pairs", (table,))


def angle_deg(cosine: float) -> float:
    """Angle of a cosine. [deg].

    >>> angle_deg(1.0), round(angle_deg(0.5), 6)
    (0.0, 60.0)
    """
    return float(np.degrees(np.arccos(np.clip(abs(cosine), 0.0, 1.0))))
