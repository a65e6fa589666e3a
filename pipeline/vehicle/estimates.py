"""Numbers of a vehicle file that say where they are from: ``{value, ci95, from}`` for a number.

Any number (or true, false) of the file may be written so. Everything that computes takes the value;
`rig2sea why`, `apply` and the vehicle's page show the rest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.vehicle.frames import Change
from pipeline.vehicle.model_schema import HullShare, WakeFraction
from pipeline.vehicle.yaml_text import Node, Scalar, parse

#: Shares nearer to each other than this are one value for all thrusters.
_ALIKE = 1e-9
#: No share of a file is beyond this, either way.
_LARGEST = 0.999

#: Keys of a mapping that stands for a number.
KEYS = frozenset({"value", "ci95", "from"})


def share_changes(
    section: HullShare, names: Sequence[str], left: Sequence[float], std: float | None = None
) -> dict[str, Change]:
    """Say what to write so that the file gives each thruster what it was found to have left.

    `section` is wake fraction or thrust deduction as the file states it, `left` of each of all
    thrusters 1 - w of the inflow or 1 - t of the thrust, `std` the standard uncertainty common to
    all, where it is to be written too. [1]

    >>> share_changes(WakeFraction(), ("port", "stbd"), (0.75, 0.75))
    {'model.wake_fraction.value': 0.25}
    """
    key = "wake_fraction" if isinstance(section, WakeFraction) else "thrust_deduction"
    taken = [min(max(1.0 - one, -_LARGEST), _LARGEST) for one in left]
    changes: dict[str, Change] = {}
    if max(taken) - min(taken) <= _ALIKE and not section.thrusters:
        changes[f"model.{key}.value"] = taken[0]
    else:
        for name, one in zip(names, taken, strict=True):
            changes[f"model.{key}.thrusters.{name}"] = one
    if std is not None:
        changes[f"model.{key}.sigma"] = std
    return changes


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval (None: not stated) and what it is from."""

    value: Scalar
    ci95: tuple[float, float] | None = None
    source: str = ""
    line: int = 0


def with_plain_values(root: Node, shown_as: str) -> tuple[Node, dict[str, Estimate]]:
    """Put the values of estimates in their place.

    Returns the tree with plain values, each with its line, and what was stated: an `Estimate` by
    dotted path, list entries by their place from 0. `shown_as` is the file's name in messages.

    Raises
    ------
    InputError
        For a value that is no number, an interval that does not hold it, or a source that is no
        text.

    >>> text = b"a: [1, {value: 2.5, ci95: [2, 3], from: run 7}]"
    >>> plain, stated = with_plain_values(parse(text, "a.yaml"), "a.yaml")
    >>> plain.plain(), stated["a.1"].source
    ({'a': [1, 2.5]}, 'run 7')
    """
    stated: dict[str, Estimate] = {}
    return _plain(root, "", shown_as, stated), stated


def _plain(node: Node, path: str, shown_as: str, stated: dict[str, Estimate]) -> Node:
    def below(one: Node, key: object) -> Node:
        return _plain(one, f"{path}.{key}".removeprefix("."), shown_as, stated)

    if isinstance(node.value, list):
        return replace(node, value=[below(one, index) for index, one in enumerate(node.value)])
    if not isinstance(node.value, dict):
        return node
    keys = frozenset(node.value)
    if "value" in keys and len(keys) > 1 and keys <= KEYS:
        stated[path] = _estimate(node, node.value, path, shown_as)
        return replace(node, value=stated[path].value)
    return replace(node, value={key: below(one, key) for key, one in node.value.items()})


def _estimate(node: Node, parts: Mapping[str, Node], path: str, shown_as: str) -> Estimate:
    def refused(what: str, expected: str, at: Node) -> InputError:
        return InputError.at(Place(shown_as, row=at.line), f"{path}: {what}.", expected=expected)

    value = parts["value"].value
    if not isinstance(value, bool | int | float):
        raise refused("its value is no number", "value: a number.", parts["value"])
    source = parts["from"].value if "from" in parts else ""
    if not isinstance(source, str):
        raise refused(
            "from is no text", "from: the run, day or diagnosis, in quotes.", parts["from"]
        )
    ci95 = None
    if "ci95" in parts:
        pair = parts["ci95"].plain()
        expected = "ci95: [low, high] with low <= value <= high."
        if (
            not isinstance(pair, list)
            or len(pair) != 2
            or any(isinstance(end, bool) or not isinstance(end, int | float) for end in pair)
        ):
            raise refused("ci95 is no pair of numbers", expected, parts["ci95"])
        if not pair[0] <= value <= pair[1]:
            raise refused(
                f"the interval {pair[0]:g} to {pair[1]:g} does not hold {value:g}",
                expected,
                parts["ci95"],
            )
        ci95 = (float(pair[0]), float(pair[1]))
    return Estimate(value, ci95, source, node.line)


def estimates_of(file: Path) -> dict[str, Estimate]:
    """Return what a vehicle file states of its numbers, by dotted path; see `with_plain_values`."""
    return with_plain_values(parse(file.read_bytes(), str(file)), str(file))[1]
