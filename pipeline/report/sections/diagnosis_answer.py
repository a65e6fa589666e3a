"""A diagnosis' page: notes, ranking, what to fly next; for doubters how it was decided."""

from collections.abc import Iterator

from pipeline.errors import CannotComputeError
from pipeline.records.diagnosis import ChannelNoiseCheck, DiagnosisRecord, Leftover, RankedEffect
from pipeline.report import diagnosis_words as words
from pipeline.report import plotting
from pipeline.report.bars import Bar, bars_figure
from pipeline.report.blocks import Blocks, Bullets, Details, Table, Text, chapter
from pipeline.report.numbers import general, plural

#: Answers shown in the open: so many, or as many as are this probable.
SHOWN, PROBABLE = 4, 0.01
#: Answers that are drawn; the table has all.
MOST_DRAWN = 8
#: Standard deviations below which a difference is hard to see.
_CLEAR = 3.0


@chapter("notes", "Notes")
def notes_section(record: DiagnosisRecord) -> Blocks:
    """Say what must be known before the answer is used."""
    # the engine may have said it
    said = any("no healthy runs" in note.lower() for note in record.notes)
    if not record.evidence.healthy_runs and not said and not words.of_bench(record):
        yield Text(
            "No sound runs were given: what a sound vehicle leaves was taken from the "
            "uncertainties and sensor figures of the vehicle file, and the answer rests on "
            "them. --healthy RUN gives measured ones.",
            tone="note",
        )
    none = Text("No further remarks on these data.")
    yield Bullets(record.notes) if record.notes else none


@chapter("ranking", "What it may be")
def ranking_section(record: DiagnosisRecord) -> Blocks:
    """Show every answer with its probability, its parameters and their intervals."""
    if not record.ranking:
        raise CannotComputeError("no answer was ranked.")
    ranking = sorted(record.ranking, key=lambda one: -one.probability)
    bars = [
        Bar(
            _words(one),
            100 * one.probability,
            colour=_tone(one, record, (plotting.BLUE, plotting.ORANGE, "#b9c2cc")),
            text=words.probability_text(one.probability),
        )
        for one in ranking[:MOST_DRAWN]
    ]
    told = [(_words(one), words.probability_text(one.probability)) for one in ranking[:2]]
    text = f"{told[0][0]} is the most probable, {told[0][1]}"
    if len(ranking) > 1:
        text += f"; next {told[1][0]}, {told[1][1]}"
    yield bars_figure(
        "fig-ranking",
        f"{words.capital(text)}.",
        "Blue: the verdict. Orange: what these data cannot tell from it.",
        bars,
        x_label="probability  [%]",
        x_range=(0.0, 128.0),
    )
    shown = max(SHOWN, sum(one.probability >= PROBABLE for one in ranking))
    yield _table("Answers, the most probable first", ranking[:shown], record)
    rest = ranking[shown:]
    if rest:
        most = words.probability_text(rest[0].probability).removeprefix("<").strip()
        summary = f"{plural(len(rest), 'more answer')}, none above {most}"
        yield Details(summary, (_table("The other answers", rest, record),))


def _tone(one: RankedEffect, record: DiagnosisRecord, tones: tuple[str, str, str]) -> str:
    """Choose for the verdict, for what cannot be told from it, and for the rest."""
    if set(one.effect.split("+")) == set(record.verdict.effects):
        return tones[0]
    return tones[1] if words.beside(record.verdict, one.effect) else tones[2]


def _words(one: RankedEffect) -> str:
    return words.listed([words.said(words.in_words(name)) for name in one.effect.split("+")])


def _table(caption: str, ranking: list[RankedEffect], record: DiagnosisRecord) -> Table:
    def cells(one: RankedEffect) -> dict[str, str]:
        place = list(dict.fromkeys(one.thrusters.values()))
        place += [words.listed(one.axes)] if one.axes else []
        where = f" ({'; '.join(place)})" if place else ""
        values = (words.parameter_words(name, value) for name, value in one.parameters.items())
        return {
            "Answer": _words(one),
            "What it is": f"{words.what_it_is(one.effect)}{where}",
            "Probability": words.probability_text(one.probability),
            "Values with 95 % intervals": "; ".join(f"{w} ({ends})" for w, ends in values) or "–",
            "Gap closed": "–" if one.gap_closed is None else words.closed_text(one.gap_closed),
        }

    return Table.of(
        caption,
        ranking,
        cells,
        lambda one: _tone(one, record, ("chosen", "warning", "")),
        note="Shaded: the verdict. Marked: what these data cannot tell from it. Gap closed: on "
        "readings that were kept aside.",
    )


@chapter("next", lambda of: "What to measure next" if words.of_bench(of) else "What to fly next")
def next_section(record: DiagnosisRecord) -> Blocks:
    """Say what to fly next, and what is left."""
    bench = words.of_bench(record)
    following, unknown = record.next_run, "unknown" in record.verdict.effects
    if following is not None:
        first, second = (words.in_words(name) for name in following.separates)
        manoeuvre = following.manoeuvre.replace("_", " ")
        what = (
            f"Measure {manoeuvre}: it shows"
            if bench
            else f"Fly {manoeuvre}: of the manoeuvres that the vehicle can fly it shows best"
        )
        sigma = general(following.expected_separation_sigma, 2)
        yield Text(
            f"{what} the difference between {first} and {second}, by {sigma} standard deviations."
        )
        if following.expected_separation_sigma < _CLEAR:
            yield Text("That is little: repeat it, or take more readings.")
    elif not unknown:
        yield Text("Nothing more is needed to tell the answer from another one.")
    if unknown:
        course = "What is left" if bench else "Time course"
        yield Text(_dependence(record))
        yield Text(f"{course}: {record.leftover.time_course}.")


def _dependence(record: DiagnosisRecord) -> str:
    left, bench = record.leftover, words.of_bench(record)
    if left.depends_on is None:
        return (
            "The thrust that is left goes neither with the code nor with its size."
            if bench
            else f"The force that is left lies mostly in {left.worst_axis} and goes with none of "
            "the quantities that were measured."
        )
    name = words.REGRESSORS.get(left.depends_on, left.depends_on)
    return (
        f"The thrust that is left goes with the {name}{correlated(left)}."
        if bench
        else f"The force that is left lies mostly in {left.worst_axis} and goes with {name}"
        f"{correlated(left)}: vary {name} on its own in the next run."
    )


def correlated(left: Leftover) -> str:
    """Say how closely what is left goes with what it goes with."""
    if left.correlation is None:
        return ""
    return f" (rank correlation {left.correlation:.2f})".replace("-", "\N{MINUS SIGN}")


#: Whitened residuals of a right noise model lie in here.
VARIANCE, LAG1 = (0.8, 1.2), 0.1
#: What the table shows as widened, with two places.
_WIDENED = 1.005
#: Outside force over that of a sound vehicle up to which nothing is said of it.
_ORDINARY = 1.0
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
