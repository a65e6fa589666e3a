"""Which language is chosen."""

import pytest

from pipeline.reader_language import current, use, wanted


@pytest.mark.parametrize(
    ("environment", "language"),
    [
        ({}, "en"),
        ({"LANG": "ru_RU.UTF-8"}, "ru"),
        ({"LANG": "ru"}, "ru"),
        ({"LANG": "en_US.UTF-8", "LC_MESSAGES": "ru_RU.KOI8-R"}, "ru"),
        ({"LANG": "ru_RU.UTF-8", "LC_ALL": "C.UTF-8"}, "en"),
        ({"LANG": "ru_RU.UTF-8", "LC_ALL": ""}, "ru"),
        ({"LANG": "rum_RO"}, "en"),
        ({"LC_ALL": "ru_RU", "RIG2SEA_LANGUAGE": "en"}, "en"),
        ({"LC_ALL": "C", "RIG2SEA_LANGUAGE": "ru"}, "ru"),
        ({"LC_ALL": "ru_RU", "RIG2SEA_LANGUAGE": "klingon"}, "en"),
    ],
)
def test_the_environment_is_asked_in_order(environment: dict[str, str], language: str) -> None:
    assert wanted(environment) == language


def test_only_what_there_is_can_be_chosen() -> None:
    with pytest.raises(ValueError, match="de"):
        use("de")
    assert current() == "en"
