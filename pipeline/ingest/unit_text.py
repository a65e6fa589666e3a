"""Unit texts of raw files, English and Russian, and what they are worth.

A bench's kg, g, lb and oz in a force or a torque mean kilogram-force and so on. Texts are compared
without case; blanks, dots and hyphens part the factors and may be missing: ``N.mm``, ``N mm`` and
``Nmm`` are one unit. Only where leaving them out makes two units look alike ("кгсм": "кгс·м" or
"кг·см"?) the text is refused.
"""

import difflib
import functools
import math
import re
import unicodedata
from collections.abc import Mapping
from typing import Any

from pipeline.ingest.data_files import data_of

#: Latin letters that look like Cyrillic ones, after case folding: "H·м" is typed with a Latin H.
_SAME_SHAPE = str.maketrans("aeopcxyhkmtb", "аеорсхункмтв")
_CYRILLIC = re.compile("[а-яё]")
_PARTING = re.compile(r"[\s.,·•∙⋅‧・*×⋆^_\u00ad\u2010-\u2015\u2212\-]+")
_BRACKETS = re.compile(r"^[\[({<]\s*(.*?)\s*[\])}>]$", re.DOTALL)


class UnitTextError(ValueError):
    """A unit text is not known, or is not a unit of the wanted quantity; the text says which."""


def normalise_unit(text: str) -> str:
    """Return the form in which unit texts are compared: factors parted by ``*``.

    >>> normalise_unit("[N·mm]"), normalise_unit("n. mm"), normalise_unit("H·м") == "н*м"
    ('n*mm', 'n*mm', True)
    """
    text = text.strip()
    inner = _BRACKETS.match(text)
    if inner is not None:
        text = inner[1]
    text = unicodedata.normalize("NFKC", text.replace("⁻", "-").replace("°", "deg")).casefold()
    plain = _PARTING.sub("*", text).strip("*").replace("*/", "/").replace("/*", "/")
    if not plain and text.strip():
        return "-"
    return fold_lookalikes(plain)


def fold_lookalikes(text: str) -> str:
    """Return a lower-case text with Latin letters turned Cyrillic where it has Cyrillic ones.

    >>> fold_lookalikes("mомент") == "момент", fold_lookalikes("torque")
    (True, 'torque')
    """
    return text.translate(_SAME_SHAPE) if _CYRILLIC.search(text) else text


@functools.cache
def _texts() -> Mapping[str, Mapping[str, str | None]]:
    """Return quantity -> text -> unit as pint writes it; None where the text could be two units."""
    table: dict[str, dict[str, str | None]] = {}
    for quantity, units in data_of("units").items():
        parted: dict[str, str | None] = {}
        joined: dict[str, str | None] = {}
        for unit, texts in units.items():
            for text in texts:
                key = normalise_unit(text)
                if parted.setdefault(key, unit) != unit:
                    raise AssertionError(f"{text!r} is both {parted[key]} and {unit}")
                compact = key.replace("*", "")
                if joined.setdefault(compact, unit) != unit:
                    joined[compact] = None
        table[quantity] = joined | parted
    return table


def _find(text: str, quantity: str) -> str | None:
    """Return the unit as pint writes it, None where the text is none of this quantity.

    Raises `UnitTextError` where it could be two.
    """
    known = _texts()[quantity]
    key = normalise_unit(text)
    for form in (key, key.replace("*", "")):
        if form in known:
            unit = known[form]
            if unit is None:
                raise UnitTextError(
                    f'"{text.strip()}" could be two units of {quantity}: write it with a blank or '
                    "a dot between the factors"
                )
            return unit
    return None


def is_same_unit(text: str, other: str) -> bool:
    """Tell whether two texts mean one unit: spelled alike, or two names of it.

    >>> is_same_unit("N.mm", "Nmm"), is_same_unit("В", "V"), is_same_unit("N m", "N mm")
    (True, True, False)
    """
    first, second = normalise_unit(text), normalise_unit(other)
    if first == second or first.replace("*", "") == second.replace("*", ""):
        return True
    for quantity in quantities_of(text) & quantities_of(other):
        try:
            if _find(text, quantity) == _find(other, quantity):
                return True
        except UnitTextError:
            continue
    return False


@functools.cache
def _registry() -> Any:  # noqa: ANN401  pint's registry is built at run time and has no useful type
    import pint  # 0.4 s: only when a file with units is read

    return pint.UnitRegistry()


@functools.cache
def _worth(unit: str, quantity: str) -> float:
    target = next(iter(data_of("units")[quantity]))  # the unit of the records
    return float(_registry().Quantity(1.0, unit).to(target).magnitude)


@functools.lru_cache(maxsize=4096)
def quantities_of(text: str) -> frozenset[str]:
    """Return the quantities that a text may be a unit of.

    >>> sorted(quantities_of("oz-in")), sorted(quantities_of("мс")), sorted(quantities_of("code"))
    (['torque'], ['pulse_width', 'time'], [])
    """
    key = normalise_unit(text)
    forms = {key, key.replace("*", "")}
    return frozenset(name for name, known in _texts().items() if not forms.isdisjoint(known))


def known_units(quantity: str) -> tuple[str, ...]:
    """Return one text for each unit of a quantity, as offered in messages."""
    return tuple(texts[0] for texts in data_of("units")[quantity].values())


def unit_worth(quantity: str, worth: float, most_times: float = 1.02) -> str | None:
    """Return the unit that is nearest to being worth so much in that of the records.

    None where none is, to `most_times` as much or little.

    >>> unit_worth("torque", 0.098), unit_worth("shaft_speed", 9.55), unit_worth("torque", 0.5)
    ('kg cm', 'rad/s', None)
    """
    units = data_of("units")[quantity]
    off = {unit: abs(math.log(worth / _worth(unit, quantity))) for unit in units}
    nearest = min(off, key=lambda unit: off[unit])
    return str(units[nearest][0]) if off[nearest] <= math.log(most_times) else None


def factor(unit_text: str, quantity: str) -> float:
    """Return what one unit is in the unit of the records (rpm, N m, N, A, V, W, s, us, m/s, 1).

    Raises `UnitTextError` where the text is not a unit of that quantity.

    >>> round(factor("oz-in", "torque"), 8), round(factor("кгс·см", "torque"), 7)
    (0.00706155, 0.0980665)
    >>> factor("1/min", "shaft_speed"), factor("мА", "current")
    (1.0, 0.001)
    """
    unit = _find(unit_text, quantity)
    if unit is not None:
        return _worth(unit, quantity)
    name = quantity.replace("_", " ")
    known = ", ".join(known_units(quantity))
    others = sorted(quantities_of(unit_text))
    if others:
        other = " or ".join(other.replace("_", " ") for other in others)
        raise UnitTextError(
            f'"{unit_text.strip()}" is a unit of {other}, not of {name}; known for {name}: {known}'
        )
    texts = [text for text, meaning in _texts()[quantity].items() if meaning is not None]
    close = difflib.get_close_matches(normalise_unit(unit_text), texts, n=1, cutoff=0.75)
    hint = ""
    nearest = _texts()[quantity][close[0]] if close else None
    if nearest is not None:
        hint = f' (did you mean "{data_of("units")[quantity][nearest][0]}"?)'
    raise UnitTextError(
        f'"{unit_text.strip()}" is not a known unit of {name}{hint}; known: {known}'
    )


def parts_of_whole(unit: str) -> int:
    """Return how many make the whole: 100 for per cent, 1000 for per mille, 0 for other units.

    >>> parts_of_whole("%"), parts_of_whole("проц"), parts_of_whole("‰"), parts_of_whole("-")
    (100, 100, 1000, 0)
    """
    try:
        return {"percent": 100, "permille": 1000}.get(_find(unit, "ratio") or "", 0)
    except UnitTextError:
        return 0
