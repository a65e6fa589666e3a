"""Pages in Russian: whole, with decimal commas, and nothing of it in English ones."""

import re
from collections.abc import Iterator

import pytest

from pipeline.reader_language import use
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


@pytest.mark.usefixtures("russian")
def test_a_vehicle_page_is_russian(results: VehicleResults) -> None:
    page = vehicle_page(results)
    assert '<html lang="ru">' in page
    assert "Таблица 1. Коэффициенты винта" in page
    found = texts(page)
    left = [one for one in found if ENGLISH.search(one)]
    assert len(left) <= 0.01 * len(found), left
    assert not [one for one in found if re.fullmatch(r"[−+-]?\d+\.\d+", one)]
    assert [one for one in found if re.fullmatch(r"[−+-]?\d+,\d+", one)]


@pytest.mark.usefixtures("russian")
def test_labels_of_figures_are_russian(results: VehicleResults) -> None:
    page = vehicle_page(results)
    assert "частота вращения n  [об/мин]" in page
    assert "shaft speed n" not in page


def test_an_english_page_stays_english(page: str) -> None:
    assert '<html lang="en">' in page
    assert "<h2>Contents</h2>" in page
    assert "Содержание" not in page
