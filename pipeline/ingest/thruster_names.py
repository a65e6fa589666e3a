"""Which thruster a name in a log means: by the name of one in it, or by a number."""

import re
from collections.abc import Sequence

_HUMP = re.compile(r"(?<=[a-zа-яё])(?=[A-ZА-ЯЁ])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+|\d+")


def words_of(name: str) -> list[str]:
    """Cut a name into words and numbers, in lower case.

    >>> words_of("rov1/base_link_frd"), words_of("mapNED"), words_of("ThrusterLeft12")
    (['rov', '1', 'base', 'link', 'frd'], ['map', 'ned'], ['thruster', 'left', '12'])
    """
    return [one.lower() for one in _WORD.findall(_HUMP.sub(" ", name))]


def thrusters_named(texts: Sequence[str], thrusters: Sequence[str]) -> dict[str, str]:
    """Return element -> thruster for the elements whose names have the name of one in them.

    >>> thrusters_named(["thruster_upper_left_joint", "arm", "UpperJoint"], ["upper", "upper_left"])
    {'thruster_upper_left_joint': 'upper_left', 'UpperJoint': 'upper'}
    """
    found: dict[str, str] = {}
    of = {name: f" {' '.join(words_of(name))} " for name in thrusters}
    for text in map(str, texts):
        fits = [name for name in thrusters if of[name] in f" {' '.join(words_of(text))} "]
        longest = max((len(of[name]) for name in fits), default=0)
        best = [text] if text in thrusters else [one for one in fits if len(of[one]) == longest]
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
