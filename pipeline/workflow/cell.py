"""A number of ``tables.json`` by the name that a person gives it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pipeline.plan import UsageError

_BY_POWER = ("code", "code/N", "code/N^2", "code/N^3")
#: Number -> its unit; of coefficients by their place, in ascending order.
_UNITS: dict[str, str | tuple[str, ...]] = {
    "KF0": "N",
    "KF1": "N/code",
    "KF2": "N/code^2",
    "T_max_n": "N",
    "dead_zone_code": "code",
    "positive": _BY_POWER,
    "negative": _BY_POWER,
    **dict(zip(("KN0", "KN1", "KN2", "KN3"), _BY_POWER, strict=True)),
    "code": "code",
    "code_min": "code",
    "code_max": "code",
    "thrust_max_n": "N",
    "thrust_dead_n": "N",
    "speed_mps": "m/s",
}
#: Table -> stage that computed it.
STAGE_OF = {
    "table1": "propeller",
    "table2": "static",
    "table3": "inverse",
    "table4": "inverse",
    "firmware": "inverse",
}
_PATH = re.compile(r"([A-Za-z]\w*(?:\.[A-Za-z]\w*)+)((?:\[\d{1,6}\])*)")
_SPEED = "speed_mps"
_FORMS = (
    'a path as in tables.json ("table4.KN1[2]"), or table, coefficient and speed or number '
    '("table4 KN1 1.5", "table1 KT 0").'
)


@dataclass(frozen=True)
class Cell:
    """A number of the tables.

    `interval` is its 95 % interval, `printed` what was published for it, `fit` the quality of the
    fit that it is a coefficient of: each None where there is none. `speed_mps` [m/s] is None for
    what does not depend on speed. `unit` is empty for a plain number.
    """

    table: str
    path: str
    value: float
    interval: tuple[float, float] | None = None
    printed: float | None = None
    speed_mps: float | None = None
    fit: Mapping[str, Any] | None = None
    unit: str = ""

    @property
    def stage(self) -> str:
        """The stage that computed it."""
        return STAGE_OF[self.table]


def find_cell(tables: Mapping[str, Any], words: Sequence[str]) -> Cell:
    """Find a number in the body of ``tables.json``, with what is known of it.

    `words` are one path, or table, coefficient and speed (Tables 2 and 4, in m/s) or number of the
    coefficient (Tables 1 and 3, from 0) in any order.
    """
    text = " ".join(words)[:200]
    match = _PATH.fullmatch(text)
    if match:
        keys = match[1].split(".")
        indices = [int(index) for index in re.findall(r"\d+", match[2])]
    else:
        keys, indices = _by_words(tables, words)
    if keys[0] not in STAGE_OF:
        raise UsageError(
            f'there is no table "{keys[0][:40]}". There are: {", ".join(STAGE_OF)}; '
            f"a number is named by {_FORMS}"
        )
    value = _walk(tables, keys, indices)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise UsageError(f'"{text}" is not a number but {_what(value)}. Expected {_FORMS}')
    table, name = keys[0], keys[-1]
    path = ".".join(keys) + "".join(f"[{index}]" for index in indices)
    if table == "firmware" or len(keys) != 2 or len(indices) != 1:
        return Cell(table, path, float(value), unit=_unit(keys, indices))
    index = indices[0]
    speeds = tables[table].get(_SPEED)
    speed_mps = None if speeds is None else float(speeds[index])
    interval = _at(tables, table, "ci95", name, index)
    return Cell(
        table,
        path,
        float(value),
        interval=(interval[0], interval[1]) if interval else None,
        printed=_printed(tables, table, name, index, speed_mps),
        speed_mps=speed_mps,
        fit=_fit(tables, table, name, index),
        unit=_unit(keys, indices),
    )


def _unit(keys: Sequence[str], indices: Sequence[int]) -> str:
    """Return the unit of a number; empty for a ratio.

    >>> _unit(["table3", "positive"], [1]), _unit(["table1", "KT"], [0])
    ('code/N', '')
    """
    found = _UNITS.get(keys[-1], "")
    if isinstance(found, str):
        return found
    return found[indices[-1]] if indices and indices[-1] < len(found) else ""


def _by_words(tables: Mapping[str, Any], words: Sequence[str]) -> tuple[list[str], list[int]]:
    plain = [word for word in words if _number(word) is None]
    numbers = [number for word in words if (number := _number(word)) is not None]
    if len(plain) != 2 or len(numbers) != 1:
        raise UsageError(f'"{" ".join(words)[:200]}" names no number. Expected {_FORMS}')
    if plain[0] not in STAGE_OF and plain[1] in STAGE_OF:
        plain.reverse()
    speeds = (tables.get(plain[0]) or {}).get(_SPEED) if plain[0] in STAGE_OF else None
    if speeds is None:
        return plain, [int(numbers[0])] if numbers[0].is_integer() else []
    near = [i for i, speed in enumerate(speeds) if abs(speed - numbers[0]) < 1e-9]
    if not near:
        there = ", ".join(f"{speed:g}" for speed in speeds)
        raise UsageError(f"{plain[0]} has no row for {numbers[0]:g} m/s. There are: {there}.")
    return plain, near


def _walk(tables: Mapping[str, Any], keys: Sequence[str], indices: Sequence[int]) -> Any:  # noqa: ANN401 - plain JSON
    value: Any = tables
    for depth, key in enumerate(keys):
        where = ".".join(keys[:depth]) or "tables.json"
        if value is None:
            raise UsageError(f"{where} was not computed.{_why_not(tables)}")
        if not isinstance(value, dict) or key not in value:
            there = ", ".join(value) if isinstance(value, dict) else _what(value)
            raise UsageError(f'{where} has no "{key[:40]}". There is: {there}.')
        value = value[key]
    for depth, index in enumerate(indices):
        if not isinstance(value, list) or not 0 <= index < len(value):
            name = ".".join(keys) + "".join(f"[{i}]" for i in indices[:depth])
            raise UsageError(f"{name} has no [{index}]: it is {_what(value)}.")
        value = value[index]
    return value


def _why_not(tables: Mapping[str, Any]) -> str:
    reasons = tables.get("not_computed") or {}
    return "".join(f"\n{reason}" for reason in reasons.values())


def _what(value: object) -> str:
    if isinstance(value, list):
        return f"a list of {len(value)}, counted from 0"
    if isinstance(value, dict):
        return f"a group of {', '.join(value)}"
    return "nothing" if value is None else repr(value)[:80]


def _number(word: str) -> float | None:
    try:
        return float(word.replace(",", "."))
    except ValueError:
        return None


def _at(value: Any, *keys: str | int) -> Any:  # noqa: ANN401 - plain JSON
    """Return what stands at some keys; None where there is nothing."""
    for key in keys:
        if isinstance(key, str):
            value = value.get(key) if isinstance(value, dict) else None
        else:
            value = value[key] if isinstance(value, list) and 0 <= key < len(value) else None
    return value


def _printed(
    tables: Mapping[str, Any], table: str, name: str, index: int, speed_mps: float | None
) -> float | None:
    if speed_mps is not None:
        rows = _at(tables, "published", table, _SPEED) or []
        index = next((i for i, speed in enumerate(rows) if abs(speed - speed_mps) < 1e-9), -1)
    number = _at(tables, "published", table, name, index)
    return None if number is None else float(number)


def _fit(tables: Mapping[str, Any], table: str, name: str, index: int) -> Mapping[str, Any] | None:
    found = _at(tables, "quality", table, "rows" if table == "table2" else name)
    if isinstance(found, list):
        found = _at(found, index)
    return found if isinstance(found, dict) else None
