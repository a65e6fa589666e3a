"""A stranger's ten questions, answered by the first screen alone, in English and in Russian."""

import re

import pytest
from diagnosis_records import estimate

from pipeline.reader_language import use
from pipeline.records.base import Glance
from pipeline.records.day_findings import DayDiagnosis, DayFinding
from pipeline.records.diagnosis import FoundEvent, NextRun, RankedEffect, Series
from pipeline.report.glance import Flown, day_glance, run_glance
from pipeline.report.page import first_screen, glance_text, with_glance
from pipeline.report.plain_words import short_finding
from pipeline.report.sections.diagnosis_curves import finding_figure

FLOWN = Flown({"straight": ("straight",), "turns": ("zig_zag",)})
FAULT = DayFinding(
    effects=("thruster_degraded",),
    thruster="upper",
    runs=("turns",),
    by="run",
    probability=0.89,
    ambiguous_with=("reverse_thrust",),
    ranked=RankedEffect(
        effect="thruster_degraded",
        probability=0.89,
        parameters={"thrust_fraction": estimate(0.694, "1", 0.065)},
        gap_closed=0.9,
        thruster="upper",
        thrusters={"thruster_degraded": "upper"},
        log_evidence=9.0,
    ),
)
SOUND = DayFinding(effects=("none",), thruster=None, runs=("straight",), by="run", probability=0.98)
DAY = DayDiagnosis(
    vehicle="boat", day="2026-05-04", against="the vehicle file", findings=(FAULT, SOUND)
)
BEFORE = DAY.model_copy(
    update={
        "day": "2026-05-03",
        "next_run": NextRun(
            manoeuvre="zig_zag",
            separates=("thruster_degraded", "reverse_thrust"),
            expected_separation_sigma=4.0,
        ),
    }
)
#: Question -> what the first screen says to it, in English and in Russian.
QUESTIONS = {
    "Is the vehicle all right?": ("Fault", "Неисправность"),
    "Which part is it?": ("upper thruster", "Движитель upper"),
    "How bad is it?": ("gives 69 % of its thrust", "даёт 69 % своего упора"),
    "Between what limits?": ("(63 to 76 %)", "(63…76 %)"),
    "Always, or in some manoeuvre?": ("only in zig-zag", "только в манёвре зигзаг"),
    "How sure is that?": ("sure to 0.89", "уверенность 0,89"),
    "What else may it be?": ("thrust astern differs", "назад отличается"),
    "What do I look at first?": ("Look at its propeller and shaft", "Осмотрите его винт и вал"),
    "What do I type?": ("rig2sea apply boat 2026-05-04", "rig2sea apply boat 2026-05-04"),
    "What do I fly next, and did the last advice help?": ("Followed; now:", "Выполнено; теперь:"),
}


def told(language: str) -> str:
    use(language)
    try:
        html = first_screen(day_glance("boat", "2026-05-04", DAY, FLOWN, BEFORE))
    finally:
        use("en")
    plain = re.sub(r"<[^>]+>", " ", html).replace("\N{NO-BREAK SPACE}", " ")
    return re.sub(r"\s+", " ", plain)


@pytest.fixture(scope="module")
def screens() -> tuple[str, str]:
    return told("en"), told("ru")


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_first_screen_answers(screens: tuple[str, str], question: str) -> None:
    for screen, answer in zip(screens, QUESTIONS[question], strict=True):
        assert answer in screen


def test_a_sound_day_is_green_and_says_so_in_the_same_place() -> None:
    sound = DAY.model_copy(update={"findings": (SOUND,)})
    glance = day_glance("boat", "2026-05-04", sound, FLOWN, BEFORE)
    assert glance.light == "green"
    assert glance.matter == "1 run. Sound: the vehicle moves as its file says; sure to 0.98."
    assert glance.last_advice.endswith("Followed; the fault is gone.")


def test_what_may_be_nothing_is_amber() -> None:
    faint = FAULT.model_copy(update={"ambiguous_with": ("none",)})
    assert day_glance("b", "d", DAY.model_copy(update={"findings": (faint,)}), FLOWN).light == (
        "amber"
    )


def test_a_log_that_cannot_be_read_is_red_on_a_sound_day() -> None:
    sound = DAY.model_copy(update={"findings": (SOUND,)})
    flown = Flown({"straight": ("straight",), "torn": ()}, unreadable=("torn",))
    glance = day_glance("boat", "2026-05-04", sound, flown)
    assert glance.light == "red"
    assert glance.do[0].text == "Not read: torn."
    assert "1 log not read" in glance.short


def test_a_run_without_diagnosis_says_why() -> None:
    day = DAY.model_copy(update={"findings": (), "without": {"r": "it has no commands."}})
    glance = run_glance("boat", "r", day, Flown({"r": ()}))
    assert glance.light == "amber"
    assert "No diagnosis: it has no commands." in glance.matter


def test_a_page_takes_another_first_screen() -> None:
    first = Glance(light="amber", matter="Not judged.", short="not judged")
    page = f"<main>{first_screen(first)}<p>rest</p></main>"
    done = with_glance(page, Glance(light="green", matter="<b>Sound</b>.", short="sound"))
    assert "Not judged." not in done
    assert "&lt;b&gt;Sound" in done
    assert done.endswith("<p>rest</p></main>")


def test_the_likeliest_of_several_answers_is_not_called_sure() -> None:
    hardly = SOUND.model_copy(update={"probability": 0.29, "ambiguous_with": ("dead_zone",)})
    glance = day_glance("b", "d", DAY.model_copy(update={"findings": (hardly,)}), FLOWN)
    assert glance.light == "green", "nothing wrong is the likeliest answer"
    assert "do not rule out that small codes give no thrust (sound at 0.29" in glance.matter
    assert glance.short == "no fault found"
    assert "sure" not in glance.matter
    # a doubt is worth a run that ends it, where one would
    doubted = DAY.model_copy(
        update={
            "findings": (hardly,),
            "next_run": NextRun(
                manoeuvre="pitch_steps",
                separates=("dead_zone", "none"),
                expected_separation_sigma=2.5,
            ),
        }
    )
    advice = day_glance("b", "d", doubted, FLOWN).fly_next
    assert advice == "Pitch steps: it shows whether small codes give no thrust."


def test_what_may_be_nothing_is_called_perhaps_in_every_list() -> None:
    faint = FAULT.model_copy(update={"ambiguous_with": ("none",)})
    assert short_finding(faint).startswith("perhaps the upper thruster gives 69 %")
    assert short_finding(FAULT).startswith("the upper thruster gives 69 %")


def test_the_terminal_says_it_in_russian() -> None:
    sound = day_glance("b", "d", DAY.model_copy(update={"findings": (SOUND,)}), FLOWN)
    use("ru")
    try:
        lines = glance_text("boat", sound).splitlines()
    finally:
        use("en")
    assert lines[0].startswith("boat: ✔ Неисправности нет. 1 прогон. Исправен")
    assert "  Что сделать: ничего." in lines
    assert not any(re.search(r"[A-Za-z]{5,}", line) for line in lines[1:])


def test_the_picture_of_a_finding_takes_the_place_of_the_pages_own() -> None:
    seen = Series(
        run="turns", channel="w", unit="m/s", time_s=(0.0, 1.0, 2.0),
        measured=(0.0, 0.1, 0.0), before=(0.1, 0.2, 0.1), after=(0.0, 0.11, 0.01),
    )  # fmt: skip
    picture = finding_figure(FAULT.model_copy(update={"shown": (seen,), "shown_floor": 0.02}))
    assert picture is not None
    assert picture.lead == (
        "Heave velocity w in turns: the simulation is off by 0.10 m/s, with this cause by "
        "0.0082 m/s."
    )
    page = "<!--picture-->track<!--/picture--><h2>Manoeuvres</h2><!--spare-->"
    glance = day_glance("b", "d", DAY, FLOWN)
    done = with_glance(page, glance, picture)
    assert done.index('id="fig-shown"') < done.index("<h2>") < done.index("track")
    assert finding_figure(FAULT) is None
    shown = FAULT.model_copy(update={"shown": (seen,)})
    assert finding_figure(shown, "another run") is None


def test_an_event_is_told_with_the_line_that_notes_it() -> None:
    event = FoundEvent(
        run="turns",
        at_s=20.0,
        between_s=(19.5, 20.5),
        what="module_1 was let go 20.0 s into turns (between 19.5 and 20.5 s)",
        axis="heave",
        unit="N",
        time_s=(19.0, 19.5, 20.0, 20.5),
        force=(0.2, -0.1, -73.0, -72.6),
        step=(0.05, -72.8),
        note="events: [{at_s: 20.0, release: module_1}]",
    )
    update = {"effects": ("payload",), "thruster": None, "event": event, "ambiguous_with": ()}
    day = DAY.model_copy(update={"findings": (FAULT.model_copy(update=update), SOUND)})
    told = day_glance("boat", "2026-05-04", day, FLOWN)
    assert told.light == "red"
    assert told.matter.startswith("module_1 was let go 20.0 s into turns")
    (advice,) = told.do
    assert event.note in advice.text
    assert told.fly_next.startswith("Nothing more is needed")
    figure = finding_figure(day.findings[0])
    assert figure is not None
    assert "Heave force" in figure.lead
