"""What a reader is told first: pure functions from results to one record (`Glance`).

Green: no fault was found; nothing wrong is the likeliest answer, and what cannot be ruled out is
said. Amber: something is odd, its cause is not known or it may be nothing; or nothing was judged.
Red: a fault with its cause, which is not to be taken for nothing; or a log that cannot be read.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeline.language import as_it_is
from pipeline.records.base import LIGHTS, Advice, Glance, Light
from pipeline.records.day_findings import DayDiagnosis, DayFinding
from pipeline.records.diagnosis import DiagnosisRecord, NextRun
from pipeline.records.gains import ThrusterGains
from pipeline.report.diagnosis_words import capital, listed
from pipeline.report.numbers import plural
from pipeline.report.plain_words import (
    HALF,
    effect_words,
    finding_sentence,
    manoeuvre_words,
    short_finding,
    what_to_look_at,
)

#: What a day needs at least, so that every thruster and axis has been asked.
STANDARD = ("surge_steps", "heave_steps", "zig_zag", "pitch_steps")
#: What happened during a run is over.
_APART = "Nothing more is needed: apart from that the vehicle moves as it should."
#: Stands where a diagnosis is still to come.
FOLLOWS = "The diagnosis of the day follows."
_MOST = 3
#: A run that tells answers apart by fewer standard deviations is not worth advising.
_CLEAR = 2.0


@dataclass(frozen=True)
class Flown:
    """What is known of a day's runs: run -> names of its manoeuvres; runs that cannot be read."""

    manoeuvres: Mapping[str, tuple[str, ...]]
    unreadable: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All that was flown, each once."""
        return tuple(dict.fromkeys(name for own in self.manoeuvres.values() for name in own))

    def words(self, runs: Sequence[str]) -> list[str]:
        """Say what was flown in some of the runs; their names where that tells them not apart."""
        found = [" and ".join(map(manoeuvre_words, self.manoeuvres.get(run, ()))) for run in runs]
        others = {
            manoeuvre_words(name)
            for run, own in self.manoeuvres.items()
            if run not in runs
            for name in own
        }
        plain = all(found) and not others & set(found)
        return list(dict.fromkeys(found)) if plain else [as_it_is(run) for run in runs]


def rank(glance: Glance | None) -> int:
    """Return the place of a light in a list that is worst first; what has none is last."""
    return len(LIGHTS) if glance is None else LIGHTS.index(glance.light)


def day_glance(
    vehicle: str, day: str, told: DayDiagnosis | None, flown: Flown,
    before: DayDiagnosis | None = None,
) -> Glance:  # fmt: skip
    """Say first what is to be said of a day.

    `told` is None where it is not known what its runs show; the advice of the trial day `before`
    was to be followed.
    """
    if told is None or not told.findings:
        return _unjudged(vehicle, flown, "" if told is None else told.why_not)
    faults = [one for one in told.findings if not one.is_sound]
    light: Light = "red" if flown.unreadable else "green"
    if not faults:
        runs = capital(plural(len(told.findings[0].runs), "run"))
        matter = f"{runs}. {finding_sentence(told.findings[0])}"
    else:
        first, *rest = faults
        light = _light(first, flown)
        apart = len(told.findings) > 1
        matter = finding_sentence(first, flown.words(first.runs), only=apart)
        beside = (f"{short_finding(o)} ({listed([as_it_is(r) for r in o.runs])})" for o in rest[:2])
        matter = f"{matter} Besides: {'; '.join(beside)}." if rest else matter
    return Glance(
        light=light,
        matter=matter,
        short=_short(told, flown),
        do=_to_do(vehicle, day, told.findings[0], flown),
        fly_next=_fly_next(told, flown),
        last_advice=last_advice(before, told, flown),
    )


def run_glance(
    vehicle: str, run: str, day: DayDiagnosis | None, flown: Flown,
    gains: ThrusterGains | None = None, *, unreadable: str = "", last: str = "",
) -> Glance:  # fmt: skip
    """Say first what is to be said of a run.

    `day` is None before it is known what the runs of its day show; until then its `gains` have
    something to say. `unreadable` is why the log cannot be read, `last` what became of the last
    advice.
    """
    if unreadable:
        return Glance(
            light="red",
            matter=f"The log cannot be read: {unreadable}",
            short="the log cannot be read",
            do=(Advice(text="See what is wrong with it.", command=f"rig2sea check {vehicle}"),),
        )
    mine = [one for one in (day.findings if day is not None else ()) if run in one.runs]
    if not mine:
        return _run_undiagnosed(vehicle, run, day, gains)
    first = mine[0]
    return Glance(
        light="green" if first.is_sound else _light(first, flown),
        matter=finding_sentence(first),
        short=short_finding(first),
        do=_to_do(vehicle, run, first, flown),
        fly_next=_fly_next(day, flown) if not first.is_sound else _sound_next(flown),
        last_advice=last,
    )


def diagnosis_glance(record: DiagnosisRecord, finding: DayFinding) -> Glance:
    """Say first what a diagnosis that was asked for found; `finding` is the same answer."""
    fly_next = "Nothing more is needed."
    if finding.event is not None:
        fly_next = _APART
    elif record.next_run is not None:
        fly_next = _separating(record.next_run)
    elif not finding.is_sound:
        fly_next = "The same manoeuvre again once that is done: it shows whether the fault is gone."
    return Glance(
        light="green" if finding.is_sound else _light(finding, Flown({})),
        matter=finding_sentence(finding),
        short=short_finding(finding),
        do=_to_do(record.vehicle, "", finding, Flown({})),
        fly_next=fly_next,
    )


def last_advice(before: DayDiagnosis | None, told: DayDiagnosis, flown: Flown) -> str:
    """Say what became of the advice of the day before: followed or not, and what it showed."""
    if before is None:
        return "There is no trial day before this one."
    faults = [one for one in before.findings if not one.is_sound]
    if not faults:
        return f"On {before.day} nothing was to be done: the vehicle was sound."
    wanted = (before.next_run.manoeuvre,) if before.next_run is not None else ()
    gone = all(one.is_sound for one in told.findings)
    shown = "the fault is gone" if gone else f"now: {short_finding(told.findings[0])}"
    if not wanted:
        return f"On {before.day}: {short_finding(faults[0])}; {shown}."
    words = listed([manoeuvre_words(name) for name in wanted])
    if set(wanted) & set(flown.names):
        return f"Of {before.day}: to fly {words}. Followed; {shown}."
    return f"Of {before.day}: to fly {words}. Not followed; {shown}."


def _light(one: DayFinding, flown: Flown) -> Light:
    if flown.unreadable:
        return "red"
    faint = one.effects == ("unknown",) or "none" in one.ambiguous_with
    return "amber" if faint else "red"


def _short(told: DayDiagnosis, flown: Flown) -> str:
    first = told.findings[0]
    text = short_finding(first)
    if len(told.findings) > 1:
        text = f"{text}, only in {listed(flown.words(first.runs))}"
    if flown.unreadable:
        text = f"{text}; {plural(len(flown.unreadable), 'log')} not read"
    return text


def _to_do(vehicle: str, of: str, one: DayFinding, flown: Flown) -> tuple[Advice, ...]:
    found: list[Advice] = []
    if flown.unreadable:
        names = listed([as_it_is(run) for run in flown.unreadable])
        found.append(Advice(text=f"Not read: {names}.", command=f"rig2sea check {vehicle}"))
    look = what_to_look_at(one)
    if look is None:
        return tuple(found)
    found.append(look)
    if one.event is None and one.effects == ("unknown",):
        command = f"rig2sea diagnose {vehicle} {' '.join(one.runs)}"
        found.append(Advice(text="Take the whole runs, beside sound ones.", command=command))
    elif one.event is None and of:
        text = "If it stays as it is, take it into the vehicle file."
        found.append(Advice(text=text, command=f"rig2sea apply {vehicle} {of}"))
    return tuple(found[:_MOST])


def _fly_next(told: DayDiagnosis | None, flown: Flown) -> str:
    if told is None:
        return _sound_next(flown)
    if all(one.is_sound for one in told.findings):
        # a doubt that is left is worth a run that would end it
        one, doubted = told.next_run, told.findings[0].probability < HALF
        if doubted and one is not None and one.expected_separation_sigma >= _CLEAR:
            return _separating(one)
        return _sound_next(flown)
    if all(one.is_sound or one.event is not None for one in told.findings):
        return _APART
    if told.next_run is not None:
        return _separating(told.next_run)
    what = capital(listed(flown.words(told.findings[0].runs)))
    return f"{what} again once that is done: it shows whether the fault is gone."


def _sound_next(flown: Flown) -> str:
    rest = [manoeuvre_words(name) for name in STANDARD if name not in flown.names]
    if flown.manoeuvres and rest and len(flown.manoeuvres) > 1:
        return f"Nothing more is needed; not flown this day: {', '.join(rest)}."
    return "Nothing more is needed."


def _separating(one: NextRun) -> str:
    first, second = (effect_words(name) for name in one.separates)
    what = capital(manoeuvre_words(one.manoeuvre))
    if "none" in one.separates:
        cause = first if one.separates[1] == "none" else second
        return f"{what}: it shows whether {cause}."
    return f"{what}: it tells apart whether {first}, or {second}."


def _unjudged(vehicle: str, flown: Flown, why: str) -> Glance:
    if flown.unreadable and len(flown.unreadable) == len(flown.manoeuvres):
        matter, short = "No log of this day can be read.", "no log can be read"
    else:
        matter = f"Not judged: {why}" if why else "Not judged yet: the diagnosis follows."
        short = "not judged"
    see = Advice(text="See what the logs hold.", command=f"rig2sea check {vehicle}")
    light: Light = "red" if flown.unreadable else "amber"
    return Glance(light=light, matter=matter, short=short, do=(see,))


def _run_undiagnosed(
    vehicle: str, run: str, day: DayDiagnosis | None, gains: ThrusterGains | None
) -> Glance:
    """Say what the gains say, until the diagnosis is there or where there is none."""
    why = "" if day is None else day.without.get(run, day.why_not)
    after = f"No diagnosis: {why}" if why else FOLLOWS
    texts = [one.text for one in gains.findings] if gains is not None else []
    if texts:
        matter = f"{' '.join(texts[:2])} {after}"
        return Glance(light="red", matter=matter, short=texts[0].rstrip("."), do=())
    matter = "Nothing stands out so far." if gains is not None else "Not judged."
    return Glance(
        light="amber",
        matter=f"{matter} {after}",
        short="not judged" if day is not None else "not judged yet",
        do=(Advice(text="See what the log holds.", command=f"rig2sea check {vehicle}"),),
    )
