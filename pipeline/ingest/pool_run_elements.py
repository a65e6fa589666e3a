"""Which thruster each element of an array belongs to: by names in the messages, or by order."""

import re
from collections.abc import Sequence
from typing import Any

from pipeline.ingest.mcap_types import Path
from pipeline.records.pool_schema import PoolChannel

#: Quantities with an element for each thruster.
PER_THRUSTER = ("thruster_command", "shaft_speed", "thrust")


class NotThereError(ValueError):
    """A topic does not have what a channel asks for; the text says what it has."""


def elements_of(  # noqa: PLR0917  one caller
    stated: PoolChannel,
    texts: Any,  # noqa: ANN401  whatever the message has under `name`
    numbers: list[Path],
    thrusters: Sequence[str],
    notes: list[str],
    doubts: list[str],
) -> tuple[Path | None, tuple[str, ...], list[Path]]:
    """Say which thruster each element belongs to: by names in the messages, or by their order.

    Returns where the names stand, or the thrusters of the elements; and the numbers to take.
    """
    if stated.quantity not in PER_THRUSTER:
        return None, (), numbers
    if stated.thrusters is not None:
        if len(stated.thrusters) != len(numbers):
            raise NotThereError(
                f"thrusters names {len(stated.thrusters)} elements, the field has "
                f"{len(numbers)} numbers"
            )
        return None, stated.thrusters, numbers
    if stated.index is None and isinstance(texts, list) and texts and len(texts) == len(numbers):
        by_name = _by_name(texts, numbers, thrusters, notes, doubts)
        if by_name is not None:
            return by_name
    if not thrusters:
        return None, tuple(f"{number + 1}" for number in range(len(numbers))), numbers
    if len(numbers) < len(thrusters):
        raise NotThereError(
            f"the field has {len(numbers)} numbers for {len(thrusters)} thrusters; name them with "
            "thrusters"
        )
    if len(numbers) > len(thrusters):
        notes.append(f"the first {len(thrusters)} of {len(numbers)} elements are taken")
    if len(thrusters) > 1:
        notes.append("elements are assumed to be in the order of the thrusters of the vehicle file")
    return None, tuple(thrusters), numbers


def _by_name(
    texts: Sequence[Any],
    numbers: list[Path],
    thrusters: Sequence[str],
    notes: list[str],
    doubts: list[str],
) -> tuple[Path | None, tuple[str, ...], list[Path]] | None:
    """Say what names in a message tell of its elements, as `elements_of`; None for nothing."""
    if not thrusters or thrusters_named(texts, thrusters):
        # another message may name more of them
        most = len(numbers) + len(thrusters)
        more = [(*numbers[0][:-1], number) for number in range(len(numbers), most)]
        return ("name",), (), [*numbers, *more]
    order = _by_number(texts)
    if order is not None and len(texts) == len(thrusters):
        named = ", ".join(str(texts[index]) for index in order)
        notes.append(f"elements by the numbers in their names: {named}")
        return None, tuple(thrusters), [numbers[index] for index in order]
    doubts.append(
        f"its elements are named {', '.join(map(str, texts[:12]))}, not as the thrusters of the "
        "vehicle; they are taken in the order of the vehicle file"
    )
    return None


def thrusters_named(texts: Sequence[str], thrusters: Sequence[str]) -> dict[str, str]:
    """Return element -> thruster for the elements whose names have the name of one in them.

    >>> thrusters_named(["thruster_upper_left_joint", "arm"], ["left", "upper_left"])
    {'thruster_upper_left_joint': 'upper_left'}
    """
    found: dict[str, str] = {}
    for text in map(str, texts):
        fits = [
            name
            for name in thrusters
            if re.search(rf"(?<![a-z0-9]){re.escape(name.lower())}(?![a-z0-9])", text.lower())
        ]
        longest = max(map(len, fits), default=0)
        best = [name for name in fits if len(name) == longest]
        if text in thrusters:
            best = [text]
        if len(best) == 1:
            found[text] = best[0]
    # two elements of one thruster are two quantities of it, or a name that is part of another
    taken = list(found.values())
    return {
        text: name for text, name in found.items() if taken.count(name) == 1 or text in thrusters
    }


def _by_number(texts: Sequence[Any]) -> list[int] | None:
    """Return the order of elements whose names differ by a number alone, None for others."""
    parts = [re.fullmatch(r"(\D*)(\d+)(\D*)", str(text)) for text in texts]
    numbers = [(one[1], one[3], int(one[2])) for one in parts if one is not None]
    alike = {(before, after) for before, after, _ in numbers}
    if len(numbers) != len(texts) or len(alike) != 1 or len(set(numbers)) != len(texts):
        return None
    return sorted(range(len(texts)), key=lambda index: numbers[index][2])
