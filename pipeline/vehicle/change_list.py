"""What a finding changes in a vehicle file, number by number, with intervals; and its new text."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pipeline.records.base import FileChange, Plain
from pipeline.vehicle.estimates import Estimate
from pipeline.vehicle.frames import Change
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.write_back import updated_vehicle_text

#: What a finding changes with each of its parameters at either end of its interval.
Ends = Sequence[tuple[Mapping[str, Change], Mapping[str, Change]]]


def listed_changes(
    vehicle: Vehicle, changes: Mapping[str, Change], ends: Ends = ()
) -> tuple[FileChange, ...]:
    """List what becomes another number.

    `changes` are new values by dotted path, in the file's axes, `ends` the same at the ends of each
    parameter's interval. The interval of a key is that of the finding's parameters, each at its
    ends while the others stay; what several of them do to one key adds up as the root of the
    squares.
    """
    stated = vehicle.model_dump()
    found = []
    for path, value in _numbers(changes):
        old = value_at(stated, path)
        if old == value:
            # a vector that the file leaves out is written whole
            if value_at(stated, path.rpartition(".")[0]) is None or isinstance(value, str):
                found.append(FileChange(path=path, old=old, value=value))
            continue
        found.append(
            FileChange(path=path, old=old, value=value, ci95=_interval(path, value, old, ends))
        )
    return tuple(found)


def _numbers(changes: Mapping[str, Change]) -> Iterator[tuple[str, Plain]]:
    for path, value in changes.items():
        if isinstance(value, tuple):
            yield from ((f"{path}.{index}", one) for index, one in enumerate(value))
        else:
            yield path, value


def _interval(path: str, value: Plain, old: Plain | None, ends: Ends) -> tuple[float, float] | None:
    if isinstance(value, bool | str):
        return None
    below = above = 0.0
    for pair in ends:
        moved = []
        for one in pair:
            now = dict(_numbers(one)).get(path, old)
            if isinstance(now, int | float) and not isinstance(now, bool):
                moved.append(now - value)
        below = math.hypot(below, min(0.0, *moved)) if moved else below
        above = math.hypot(above, max(0.0, *moved)) if moved else above
    return (value - below, value + above) if below or above else None


def value_at(tree: Any, path: str) -> Any:  # noqa: ANN401 - the tree of a file has no narrower type
    """Return what stands at a dotted path of a plain tree, None where nothing does."""
    for part in path.split(".") if path else ():
        if isinstance(tree, Mapping):
            tree = tree.get(part)
        elif isinstance(tree, Sequence) and part.isdigit() and int(part) < len(tree):
            tree = tree[int(part)]
        else:
            return None
    return tree


def text_with(original: str, changes: Sequence[FileChange], source: str, note: str = "") -> str:
    """Write changes into a vehicle file's text, each with its interval and its source.

    Words (a characteristic's kind) stand alone.
    """
    values = {
        one.path: one.value if isinstance(one.value, str) else Estimate(one.value, one.ci95, source)
        for one in changes
    }
    return updated_vehicle_text(original, values, note)
