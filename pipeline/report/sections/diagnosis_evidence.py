"""A diagnosis' page: how it was decided, for whoever doubts it."""

from pipeline.records.diagnosis import ChannelNoiseCheck, DiagnosisRecord
from pipeline.report.blocks import Block, Bullets, Links, Paragraph, Section, Table
from pipeline.report.diagnosis_words import REGRESSORS, identifiers, listed, of_bench
from pipeline.report.numbers import fixed, general, plural

#: Whitened residuals of a right noise model lie in here.
VARIANCE, LAG1 = (0.8, 1.2), 0.1
#: What the table shows as widened, with two places.
_WIDENED = 1.005
#: Outside force over that of a healthy vehicle up to which nothing is said of it.
_ORDINARY = 1.0
_STAGES = {
    "kinematics": "Do the sensors agree with each other?",
    "actuators": "Do the thrusters do what they are told?",
    "dynamics": "Does the vehicle move as the forces say?",
}


def evidence_section(record: DiagnosisRecord) -> Section:
    """Show the stages, the check of the noise, the thresholds, and what is left."""
    evidence = record.evidence
    blocks: list[Block] = []
    if evidence.stages:
        blocks.append(
            Table(
                "What each stage said",
                ("Stage", "Question", "What it said"),
                tuple(
                    (name, _STAGES.get(name, ""), evidence.stages[name])
                    for name in sorted(evidence.stages, key=_order)
                ),
                text_columns=frozenset({1, 2}),
                note="Cheap and sharp before deep; a stage without its channels is skipped.",
            )
        )
    blocks += _noise(evidence.noise, bench=of_bench(record))
    blocks.append(Bullets(tuple(_facts(record))))
    blocks += _leftover(record)
    blocks.append(
        Paragraph(
            "The method, its assumptions, when to distrust it and how often it is right: "
            "docs/diagnosis_bench.md."
            if of_bench(record)
            else "The method, its assumptions and when to distrust it: docs/diagnosis.md. How "
            "often it is right, measured on cases with sealed labels: docs/blind_check.md.",
            tone="note",
        )
    )
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
            f"What a healthy vehicle leaves was learned from {identifiers(evidence.healthy_runs)}, "
            "and then frozen."
            if evidence.healthy_runs
            else "What a healthy vehicle leaves is drawn from the uncertainties and sensor figures "
            "of the vehicle file; no healthy run was given."
        )
        facts.append(
            "Outside force that the readings want beside the answer: "
            f"{general(evidence.force_scale, 2)} times that of a healthy vehicle."
        )
    facts.append(f"Held out: {record.shrink.held_out.rstrip('.')}.")
    facts.append(f"Thresholds and their origin: {evidence.calibrated.rstrip('.')}.")
    facts.append(f"It took {general(record.elapsed_s, 2)} s.")
    return facts


def _order(stage: str) -> tuple[int, str]:
    known = list(_STAGES)
    return (known.index(stage) if stage in known else len(known)), stage


def white(check: ChannelNoiseCheck) -> bool:
    """Tell whether a channel's whitened residual is as white as evidence needs it."""
    return VARIANCE[0] <= check.variance <= VARIANCE[1] and abs(check.lag1) < LAG1


def _noise(noise: dict[str, ChannelNoiseCheck], *, bench: bool) -> list[Block]:
    if not noise:
        return [Paragraph("The noise of the readings was not checked.", tone="warning")]
    return [
        Paragraph(_noise_said(noise, bench=bench)),
        Table(
            "Check of the noise: whitened residuals of the best model",
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
        ),
    ]


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
    ordinary = not of_bench(record) and max(left.axes.values()) <= _ORDINARY
    depends = (
        f" It goes with {REGRESSORS.get(left.depends_on, left.depends_on)}"
        + (
            f" (rank correlation {fixed(left.correlation, 2)})."
            if left.correlation is not None
            else "."
        )
        if left.depends_on is not None
        else ""
    )
    return [
        Paragraph(
            "What the answer leaves is ordinary: on no axis more than on a healthy vehicle."
            if ordinary
            else f"What the answer leaves: mostly {left.worst_axis}, "
            f"{left.time_course.rstrip('.')}." + depends
        ),
        Table(
            "What the answer leaves"
            if of_bench(record)
            else "Outside force that the answer leaves",
            ("Axis", "Over that of a healthy vehicle"),
            tuple((axis, fixed(value, 2)) for axis, value in left.axes.items()),
            note="Root mean square; about 1 and below is ordinary.",
        ),
    ]


def files_section(record: DiagnosisRecord, files: tuple[tuple[str, str], ...]) -> Section:
    """Name the runs and link the files of the diagnosis."""
    rows = [
        ("Runs", identifiers(record.runs) or "–"),
        ("Held out", identifiers(record.holdout) or "–"),
    ]
    if record.evidence.healthy_runs:
        rows.append(("Healthy runs", identifiers(record.evidence.healthy_runs)))
    blocks: list[Block] = [
        Table("What was diagnosed", ("What", "Names"), tuple(rows), text_columns=frozenset({1}))
    ]
    if files:
        blocks.append(Links(files))
    return Section("files", "Runs and files", tuple(blocks))
