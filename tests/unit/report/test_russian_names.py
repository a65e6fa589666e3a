"""What a person wrote, names and notes, is the same on a page of any language."""

import re
from collections.abc import Iterator
from dataclasses import replace

import diagnosis_records
import pytest
import run_records

from pipeline.language import as_it_is, translate
from pipeline.reader_language import use
from pipeline.records.pool_run import RunNotes
from pipeline.report.diagnosis_page import diagnosis_line, diagnosis_page
from pipeline.report.results import VehicleResults
from pipeline.report.run_page import run_line, run_page

pytestmark = pytest.mark.usefixtures("russian", "undrawn")
NOTES = RunNotes.model_validate(
    {
        "what": "steps of surge speed, for the added mass in surge",
        "who": ["bundled generator", "current"],
        "where": "open water, 10 m below the surface",
        "healthy": True,
        "ballast": [{"what": "trim weight", "mass_kg": 0.5}],
        "text": "The vehicle rose more slowly than in the trim tank.",
    }
)


@pytest.fixture
def russian() -> Iterator[None]:
    use("ru")
    yield
    use("en")


def test_numbers_of_a_title_keep_their_points() -> None:
    said = translate(f"{as_it_is('AUV of 2.10 m')}; kg and kg m^2 on surge, sway:")
    assert said.startswith("AUV of 2.10 m; кг")


def test_runs_of_a_diagnosis_keep_their_names() -> None:
    record = diagnosis_records.diagnosis(channels=(), windows=1)
    evidence = record.evidence.model_copy(update={"healthy_runs": ("healthy", "depth")})
    record = record.model_copy(
        update={"runs": ("current", "thrust"), "holdout": ("time",), "evidence": evidence}
    )
    page = diagnosis_page(record)
    assert "healthy и depth" in page
    assert "current и thrust" in page
    assert "исправен и" not in page
    assert translate(diagnosis_line(record)).endswith("current и thrust")
    assert not re.search("[\ue000\ue001]", page)


def test_notes_of_a_run_stay_as_they_were_written(results: VehicleResults) -> None:
    found = run_records.run_results(results.vehicle, seconds=5.0, name="healthy")
    assert found.stored is not None
    found = replace(found, stored=found.stored.model_copy(update={"notes": NOTES}))
    page = run_page(found, (), "../../assets")
    for text in (NOTES.what, NOTES.where, NOTES.text, "bundled generator; current"):
        assert text in page
    assert "trim weight" in page
    assert "<h1>Прогон healthy</h1>" in page
    assert results.vehicle.title in page
    assert translate(run_line(found)).startswith(f"{NOTES.what}; ")
    # what is no text of anybody's is translated
    assert "<td>да</td>" in page or '<td class="text">да</td>' in page


def test_a_name_marked_for_another_language_is_shown_plainly_in_english() -> None:
    marked = "\ue000current\ue001"
    use("en")
    assert translate(f"{marked}: 5 s") == "current: 5 s"


def test_a_force_below_that_of_a_healthy_vehicle_is_not_so_many_times_larger() -> None:
    said = translate(
        "Outside force that the readings want beside the answer: 0.70 times that of a sound "
        "vehicle."
    )
    assert "составляет 0,70 от" in said
    assert "раз" not in said


def test_counts_have_their_nouns() -> None:
    said = translate(
        "Evidence of 12 windows of 10 s each, with 9040 readings in all; linearisations of the "
        "model: 2."
    )
    assert said == "Свидетельства: 12 окон по 10 с, всего показаний 9040; линеаризаций модели: 2."


@pytest.mark.parametrize(
    ("english", "expected"),
    [
        ("gap over the healthy floor: z 7.46, u 1.20", "z 7,46, u 1,20"),
        (
            (
                "The noise model does not fit angular velocity and specific force: the table says "
                "how, and how much wider the noise was taken before the evidence was counted."
            ),
            "каналам: угловая скорость и удельная сила",
        ),
        ("Thrust at the largest code, 127", "Упор при наибольшем коде, 127"),
        ("cg shift", "сдвиг центра тяжести"),
        ("Run", "Прогон"),
    ],
)
def test_nothing_is_left_in_english_or_in_another_case(english: str, expected: str) -> None:
    said = translate(english)
    assert expected in said
    assert not re.search(r"gap|healthy|against|largest|noise", said)


def test_a_note_explains_the_words_of_the_cells() -> None:
    note = translate("dead: both give no thrust; none: our drive and propeller curves do not meet.")
    for cell in ("dead", "none"):
        assert f"{translate(cell)}: " in note
