"""Short forms that texts are put together from: a label with its unit, a count, a range, a list."""

import re
from collections.abc import Callable

from pipeline.language.numerals import UNITS, has_words, in_russian, is_measured

#: Says a part of a text, or None when it is not known.
Known = Callable[[str], str | None]

_MOST_ITEMS = 16
_COUNTED = re.compile(r"(\d+) ([a-z][^,;:.()\d]*)")
_LABEL = re.compile(r"(.+?)( +)\[([^\[\]]+)\]")
_MARKED = re.compile(r"([a-z][a-z -]+) (\d+)")
_SPAN = re.compile(r"(.+?) ([−-]?\d\S*) to ([−-]?\d\S*)((?: \S+){0,2})")
BRACKETED = re.compile(r"(.+?)( ?)\(([^()]+|[^()]*\([^()]*\)[^()]*)\)(\.?)")
#: Between items, but not within brackets.
SEMICOLON = re.compile(r"(; )(?![^()]*\))")
_COMMA_OR_AND = re.compile(r"(, | and )(?![^()]*\))")


def label(text: str, known: Known) -> str | None:
    """Say the label of an axis or a column, ``speed [m/s]``.

    >>> label("speed  [m/s]", {"speed": "скорость"}.get)
    'скорость  [м/с]'
    """
    found = _LABEL.fullmatch(text)
    name = known(found[1]) if found is not None else None
    if found is None or name is None:
        return None
    return f"{name}{found[2]}[{UNITS.get(found[3]) or known(found[3]) or found[3]}]"


def counted(text: str, known: Known) -> str | None:
    """Say a count of what is known in the singular or so: in Russian the noun stands first.

    >>> counted("3 zero reading", {"zero reading": "показание нуля"}.get)
    'показание нуля: 3'
    """
    found = _COUNTED.fullmatch(text)
    if found is None or found[2].split(" ", 1)[0] in UNITS:
        return None
    what = known(found[2])
    return None if what is None else f"{what}: {found[1]}"


def marked(text: str, known: Known) -> str | None:
    """Say a word with a number after it.

    >>> marked("saturated 6", {"saturated": "насыщение"}.get)
    'насыщение 6'
    """
    found = _MARKED.fullmatch(text)
    name = known(found[1]) if found is not None else None
    return f"{name} {found[2]}" if found is not None and name is not None else None


def span(text: str, known: Known) -> str | None:
    """Say a range of a quantity.

    >>> span("depth 1.2 to 3.0 m", {"depth": "глубина"}.get)
    'глубина 1,2…3,0 м'
    """
    found = _SPAN.fullmatch(text)
    if found is None or not (found[4] == "" or is_measured(f"1{found[4]}")):
        return None
    name = known(found[1])
    if name is None:
        return None
    return in_russian(f"{name} {in_russian(found[2])}…{found[3]}{found[4]}")


def bracketed(text: str, known: Known) -> str | None:
    """Say a text with a remark in brackets, of which both are known.

    >>> bracketed("speed (rms)", {"speed": "скорость", "rms": "скз"}.get)
    'скорость (скз)'
    """
    found = BRACKETED.fullmatch(text)
    if found is None:
        return None
    before, inside = known(found[1]), known(found[3])
    if before is None or inside is None:
        return None
    return f"{before}{found[2]}({inside}){found[4]}"


def named_numbers(text: str, known: Known) -> str | None:
    """Say what numbers are of.

    >>> named_numbers("codes: 1.5, 3", {"codes": "коды"}.get)
    'коды: 1,5; 3'
    """
    name, colon, numbers = text.partition(": ")
    if not colon or has_words(numbers):
        return None
    said = known(name)
    return None if said is None else f"{said}: {in_russian(numbers)}"


def items(text: str, known: Known) -> str | None:
    """Say a list of which every item is known.

    >>> items("speed, depth and course", {"speed": "скорость", "depth": "глубина"}.get)
    >>> items("speed and depth", {"speed": "скорость", "depth": "глубина"}.get)
    'скорость и глубина'
    """
    for signs in (SEMICOLON, _COMMA_OR_AND):
        parts = signs.split(text)
        if not 1 < len(parts) <= 2 * _MOST_ITEMS:
            continue
        said = [known(part) for part in parts[::2]]
        if None in said:
            continue
        signs_said = [" и " if sign == " and " else sign for sign in parts[1::2]] + [""]
        both = zip(said, signs_said, strict=True)
        return in_russian("".join(f"{item}{sign}" for item, sign in both))
    return None
