"""Which thruster a name in a log means: by the name of one in it, or by a number."""

import re
from collections.abc import Sequence


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


def in_number_order(names: Sequence[str]) -> list[list[int]]:
    """Return the positions of names that differ by their last number alone, in its order.

    >>> in_number_order(["/esc_2/cmd", "/arm", "/esc_1/cmd"])
    [[2, 0]]
    """
    groups: dict[tuple[str, str], dict[int, int]] = {}
    for at, name in enumerate(names):
        if match := re.fullmatch(r"(.*?)(\d+)(\D*)", name):
            groups.setdefault((match[1], match[3]), {})[int(match[2])] = at
    return [[group[number] for number in sorted(group)] for group in groups.values()]
