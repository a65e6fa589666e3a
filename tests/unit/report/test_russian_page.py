"""Pages in Russian: whole, with decimal commas, and nothing of it in English ones."""

import re
from collections.abc import Iterator

import diagnosis_records
import pytest

from pipeline.commands.diagnose import diagnosis_text
from pipeline.language import translate
from pipeline.reader_language import use
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report.diagnosis_page import diagnosis_line, diagnosis_page
from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_page

#: Words without which no English sentence does; none is a name or a key.
ENGLISH = re.compile(r"\b(the|and|is|are|of|with|from|this|that|not|by|than|which)\b")
TAG = re.compile(r"<(style|script)\b.*?</\1>|<title>.*?</title>|<[^>]*>", re.DOTALL)


@pytest.fixture
def russian() -> Iterator[None]:
    use("ru")
    yield
    use("en")


def texts(page: str) -> list[str]:
    """Return the texts of a page, without the marks of subscripts."""
    plain = re.sub(r"</?(sub|sup|strong)>", "", page)
    return [one.strip() for one in TAG.sub("\0", plain).split("\0") if one.strip()]


@pytest.fixture(scope="module")
def russian_page(results: VehicleResults) -> str:
    use("ru")
    try:
        return vehicle_page(results)
    finally:
        use("en")


def test_a_vehicle_page_is_russian(russian_page: str) -> None:
    page = russian_page
    assert '<html lang="ru">' in page
    assert "Таблица 1. Коэффициенты винта" in page
    found = texts(page)
    left = [one for one in found if ENGLISH.search(one)]
    # the texts of the synthetic records themselves, which no catalogue has
    assert len(left) <= 15, left
    assert not [one for one in found if re.fullmatch(r"[−+-]?\d+\.\d+", one)]
    assert [one for one in found if re.fullmatch(r"[−+-]?\d+,\d+", one)]


def test_labels_of_figures_are_russian(russian_page: str) -> None:
    assert "частота вращения n  [об/мин]" in russian_page
    assert "shaft speed n" not in russian_page


@pytest.fixture
def of_a_current() -> DiagnosisRecord:
    """A diagnosis whose identifiers are words of other meanings, too."""
    record = diagnosis_records.diagnosis(channels=(), windows=1)
    verdict = record.verdict.model_copy(
        update={
            "effects": ("current",),
            "ambiguous_with": ("tether", "payload"),
            "sentence": "current (the water moves over the ground) (probability 0.96). These runs "
            "cannot tell it from tether, payload.",
        }
    )
    first, *others = record.ranking
    ranking = (first.model_copy(update={"effect": "current"}), *others)
    assert record.next_run is not None
    following = record.next_run.model_copy(update={"separates": ("current", "tether")})
    return record.model_copy(
        update={
            "verdict": verdict,
            "ranking": ranking,
            "confusable": (("current", "tether", 0.999), ("lift", "payload", 0.7)),
            "next_run": following,
            "notes": (),
        }
    )


@pytest.mark.usefixtures("russian", "undrawn")
def test_effects_are_named_in_words(of_a_current: DiagnosisRecord) -> None:
    page = diagnosis_page(of_a_current)
    found = texts(page)
    # the sentence of JSON, where it was decided
    assert "current (вода движется" in page
    assert "кабель" in found
    assert not re.search(r"\bток\b", page)
    assert "нет" not in found
    assert not re.search("[\ue000\ue001]", page)


@pytest.mark.usefixtures("russian")
def test_effects_keep_their_identifiers_on_a_terminal(of_a_current: DiagnosisRecord) -> None:
    text = translate(diagnosis_text(of_a_current))
    assert text.startswith("current (вода движется")
    assert "%  current  " in text
    assert "current и tether" in text
    assert not re.search(r"\bток\b|\bкабель\b", text)


@pytest.mark.usefixtures("russian")
def test_the_line_of_a_water_current_is_not_of_an_electric_one() -> None:
    record = diagnosis_records.diagnosis(channels=(), windows=1)
    verdict = record.verdict.model_copy(update={"effects": ("current",)})
    line = translate(diagnosis_line(record.model_copy(update={"verdict": verdict})))
    assert not re.search(r"\bток\b", line)


def test_an_english_page_stays_english(page: str) -> None:
    assert '<html lang="en">' in page
    assert 'aria-label="Contents"' in page
    assert "Содержание" not in page
