"""Short forms that texts are put together from: a label with its unit, a count, a range, a list."""

import re
from collections.abc import Callable, Iterator

from pipeline.language.numerals import UNITS, has_words, in_russian, is_measured

#: Says a part of a text, or None when it is not known.
Known = Callable[[str], str | None]

_MOST_ITEMS = 16
_COUNTED = re.compile(r"(\d+) ([a-z][^,;:.()\d]*)")
_LABEL = re.compile(r"(.+?)( +)\[([^\[\]]+)\]")
_MARKED = re.compile(r"([a-z][a-z -]+)( \d+)")
_SPAN = re.compile(r"(.+?) ([−-]?\d\S*) to ([−-]?\d\S*)((?: \S+){0,2})")
BRACKETED = re.compile(r"(.+?)( ?)\(([^()]+|[^()]*\([^()]*\)[^()]*)\)(\.?)")
#: Between items, but not within brackets.
SEMICOLON = re.compile(r"(; )(?![^()]*\))")
_COMMA_OR_AND = re.compile(r"(, | and )(?![^()]*\))")


def with_remark(text: str, known: Known) -> str | None:
    """Say what is known with what follows it: a unit, a range, a number, a remark in brackets.

    >>> said = {"speed": "скорость", "rms": "скз"}.get
    >>> [with_remark(text, said) for text in ("speed  [m/s]", "speed 2", "speed (rms)")]
    ['скорость  [м/с]', 'скорость 2', 'скорость (скз)']
    >>> with_remark("speed 1.2 to 3.0 m/s", said)
    'скорость 1,2…3,0 м/с'
    """
    return next(_with_remark(text, known), None)


def _with_remark(text: str, known: Known) -> Iterator[str]:
    if (found := _LABEL.fullmatch(text)) and (name := known(found[1])) is not None:
        yield f"{name}{found[2]}[{UNITS.get(found[3]) or known(found[3]) or found[3]}]"
    found = _SPAN.fullmatch(text)
    if found is not None and (found[4] == "" or is_measured(f"1{found[4]}")):
        name = known(found[1])
        if name is not None:
            yield in_russian(f"{name} {in_russian(found[2])}…{found[3]}{found[4]}")
    if (found := _MARKED.fullmatch(text)) and (name := known(found[1])) is not None:
        yield f"{name}{found[2]}"
    if (found := BRACKETED.fullmatch(text)) and (name := known(found[1])) is not None:
        inside = known(found[3])
        if inside is not None:
            yield f"{name}{found[2]}({inside}){found[4]}"


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
        parts[::2] = said = [known(part) or "" for part in parts[::2]]
        if all(said):
            return in_russian("".join(" и " if part == " and " else part for part in parts))
    return None
