"""Numbers and units as they stand in running Russian text: decimal comma, Н for newton.

Names stay as they are: files, versions, and whatever stands between quotation marks.
"""

import re
import tomllib
from pathlib import Path

from pipeline.reader_language import MARKED

_WORDS = re.compile(r"[A-Za-z]{2}")
#: Names, and what is meant to be typed.
_QUOTED = re.compile(
    rf'({MARKED.pattern}|"[^"]*"|`[^`]*`|(?<![\w-])--[a-z][\w-]*[ =][^\s:;]+(?::\S+)?)'
)
_DECIMAL = re.compile(
    r"(?<![\w.,/\\#'=@])(?<![A-Za-z]-)(?<!Python )(?<!rig2sea )(?<!version )(?<!версия )"
    r"([−+-]?\d+)\.(\d+(?:e[−+-]?\d+)?)(?!\.?\w|[/\\@])"
)
_ONE = r"[−+-]?\d+(?:,\d+)?(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?(?: %)?"
_LISTED = re.compile(rf"(?<![\w,]){_ONE}(?:, {_ONE})+(?![\w,])")

#: Unit as the program writes it -> as GOST 8.417 has it.
UNITS: dict[str, str] = tomllib.loads(
    Path(__file__).with_name("units_ru.toml").read_text(encoding="utf-8")
)
_ANY_UNIT = "|".join(re.escape(unit) for unit in sorted(UNITS, key=len, reverse=True))
_AFTER_NUMBER = re.compile(
    rf"(?<![\w.])(\d(?:[\d.,]*\d)?(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?)([ \u00a0])({_ANY_UNIT})"
    r"(?![\w/^²³·*=(|]|-\w)"
)
_MEASURED = re.compile(
    rf"[<>≤≥±~]?[ \u00a0]?[−+-]?\d[\d.,]*(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?[ \u00a0](?:{_ANY_UNIT})"
)
_IN_BRACKETS = re.compile(rf"\[({_ANY_UNIT})\]")
_DEGREES = re.compile(r"(?<=\d)[ \u00a0]°")
_AT_END = re.compile(rf"(?<=, )({_ANY_UNIT})$")


def has_words(text: str) -> bool:
    """Tell whether there is anything in a text but numbers, signs and symbols of one letter.

    >>> has_words("1.5, 3 N"), has_words("3 rpm")
    (False, True)
    """
    return _WORDS.search(text) is not None


def is_measured(text: str) -> bool:
    """Tell whether a text is a number with its unit.

    >>> is_measured("28 rpm"), is_measured("rpm"), is_measured("3 points")
    (True, False, False)
    """
    return _MEASURED.fullmatch(text) is not None


def in_russian(text: str) -> str:
    r"""Write the numbers and units of a text as a Russian reader expects them.

    With decimal comma; a list of such numbers is set apart by semicolons.

    >>> in_russian("0.5, 1.0 and −1.5 m/s"), in_russian("[0.137, 0.141]")
    ('0,5; 1,0 and −1,5 м/с', '[0,137; 0,141]')
    >>> in_russian('run-1.5.mcap, sheet "V 1.5", rig2sea 0.1.0, 3 N')
    'run-1.5.mcap, sheet "V 1.5", rig2sea 0.1.0, 3 Н'
    >>> in_russian("Speed [m/s]"), in_russian("thrust, N")
    ('Speed [м/с]', 'thrust, Н')
    """
    parts = _QUOTED.split(text)
    parts[::2] = [_plain(part) for part in parts[::2]]
    return "".join(parts)


def _plain(text: str) -> str:
    text = _DECIMAL.sub(r"\1,\2", text)
    text = _LISTED.sub(_apart, text)
    text = _AFTER_NUMBER.sub(lambda found: found[1] + _joined(found[2], UNITS[found[3]]), text)
    text = _IN_BRACKETS.sub(lambda found: f"[{UNITS[found[1]]}]", text)
    text = _AT_END.sub(lambda found: UNITS[found[1]], text)
    return _DEGREES.sub("°", text)


def _apart(found: re.Match[str]) -> str:
    """Set numbers with decimal commas apart by semicolons."""
    numbers = found[0].split(", ")
    return ("; " if any("," in number for number in numbers) else ", ").join(numbers)


def _joined(space: str, unit: str) -> str:
    return unit if unit == "°" else f"{space}{unit}"
