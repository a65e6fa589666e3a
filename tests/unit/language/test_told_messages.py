"""Messages with something before them, and of several sentences, are said whole in Russian."""

import pytest

from pipeline.language.catalogue import Catalogue
from pipeline.language.translate import catalogue
from pipeline.plan import TITLES

NO_VEHICLE = (
    'there is no vehicle "{}": neither a folder under {} nor a path to one that holds '
    "vehicle.yaml.{} Under {}: mmt300, scout."
)


@pytest.fixture(scope="module")
def russian() -> Catalogue:
    return catalogue("ru")


@pytest.mark.parametrize("raw", ["raw", "/srv/my bench/raw"])
@pytest.mark.parametrize(
    ("before", "said"),
    [("", "нет"), ("error: ", "ошибка: нет"), ("Waiting for it: ", "Жду его: нет")],
)
def test_a_vehicle_that_is_not_there(russian: Catalogue, raw: str, before: str, said: str) -> None:
    for hint, meant in (("", ""), (' Did you mean "scout"?', ' Имелось в виду "scout"?')):
        assert russian.say(before + NO_VEHICLE.format("scuot", raw, hint, raw)) == (
            f'{said} аппарата "scuot": ни папки в {raw}, ни пути к папке, где есть '
            f"vehicle.yaml.{meant} В {raw} есть: mmt300, scout."
        )


@pytest.mark.parametrize("title", sorted(set(TITLES.values()) - {"tables.json"}))
def test_what_a_run_did_not_come_to_has_a_russian_title(russian: Catalogue, title: str) -> None:
    begin, _, last = russian.say(f"boat: the run did not come to this: {title}.").rpartition(": ")
    assert begin == "boat: запуск не дошёл до этого"
    assert not any(letter.isascii() and letter.isalpha() for letter in last)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Stopped.", "Остановлено."),
        (
            "Stopped. The next run goes on from here.",
            "Остановлено. Следующий запуск продолжит с этого места.",
        ),
    ],
)
def test_ctrl_c(russian: Catalogue, text: str, said: str) -> None:
    assert russian.say(text) == said
