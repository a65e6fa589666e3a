"""Which language a person reads: chosen once, at the start of a process.

Apart from `pipeline.language`, whose catalogues are part of the pages and of no other result.
"""

import re
from collections.abc import Mapping

#: Environment variable that names the language; child processes learn it from there.
VARIABLE = "RIG2SEA_LANGUAGE"
ENGLISH = "en"
LANGUAGES = (ENGLISH, "ru")

_LOCALE = ("LC_ALL", "LC_MESSAGES", "LANG")
_chosen = [ENGLISH]


def wanted(environment: Mapping[str, str]) -> str:
    """Return the language that the environment asks for, English when it asks for none of ours.

    `VARIABLE` goes before the locale, of which the first that is set counts, as everywhere.

    >>> wanted({"LANG": "ru_RU.UTF-8"}), wanted({"LANG": "ru_RU.UTF-8", "LC_ALL": "C"})
    ('ru', 'en')
    >>> wanted({"RIG2SEA_LANGUAGE": "en", "LANG": "ru_RU.UTF-8"}), wanted({"LANG": "de_DE"})
    ('en', 'en')
    """
    named = environment.get(VARIABLE, "")
    if not named:
        named = next((environment[name] for name in _LOCALE if environment.get(name)), "")
    short = named.replace("-", "_").partition("_")[0].partition(".")[0].lower()
    return short if short in LANGUAGES else ENGLISH


def use(language: str) -> None:
    """Choose the language of this process."""
    if language not in LANGUAGES:
        raise ValueError(f"no catalogue of the language {language!r}")
    _chosen[0] = language


def current() -> str:
    """Return the language of this process."""
    return _chosen[0]


_FIRST, _LAST = "\ue000", "\ue001"
MARKED = re.compile(f"{_FIRST}[^{_FIRST}{_LAST}]*{_LAST}")
_MARKS = str.maketrans("", "", _FIRST + _LAST)


def as_it_is(name: str) -> str:
    """Mark a name, for a text that is translated as a whole; English needs no mark.

    >>> as_it_is("current")
    'current'
    """
    return name if current() == ENGLISH else f"{_FIRST}{name}{_LAST}"


def without_marks(text: str) -> str:
    """Take the marks away, the names stay."""
    return text.translate(_MARKS)
