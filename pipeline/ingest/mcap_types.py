"""Definitions of messages, whatever language they were written in, and paths into messages."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

#: Step into a message: the name of a field or the number of an element.
Step = str | int
Path = tuple[Step, ...]

#: Primitive -> NumPy kind and size in bytes. Characters and booleans are small numbers here.
PRIMITIVES: Mapping[str, str] = {
    "bool": "u1",
    "byte": "u1",
    "char": "u1",
    "octet": "u1",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}
STRING = "string"
#: Fields of all messages of a definition together.
MOST_FIELDS = 10_000
_MOST = 10_000
"""Elements that a path may name."""
_PART = re.compile(r"^(?P<name>[^\[\]]+)(\[(?P<first>[0-9]+)(:(?P<end>[0-9]+))?\])?$")


class DefinitionError(ValueError):
    """The definition of a message cannot be understood; the text says why."""


class BrokenMessageError(ValueError):
    """A message does not hold what its definition promises."""


@dataclass(frozen=True)
class Field:
    """A field of a message.

    `type` is a primitive, "string", or the name of a message; `length` is None for one value, -1
    for a sequence of any length, else the length of a fixed array.
    """

    name: str
    type: str
    length: int | None = None


@dataclass(frozen=True)
class Definition:
    """A message and every message in it: name -> fields in the order of serialisation."""

    root: str
    messages: Mapping[str, tuple[Field, ...]]
    wire: Literal["cdr", "ros1"] = "cdr"
    """How its messages are written into bytes."""

    @property
    def fields(self) -> tuple[Field, ...]:
        """Fields of the message itself."""
        return self.messages[self.root]


def checked(definition: Definition) -> Definition:
    """Return a definition in which every name is defined and nothing contains itself.

    Everything in it takes bytes: arrays of what takes none could be decoded without end.

    Raises
    ------
    DefinitionError
        Otherwise.
    """
    done: set[str] = set()

    def visit(name: str, inside: tuple[str, ...]) -> None:
        if name in inside:
            raise DefinitionError(f"{name} contains itself")
        if name in done:
            return
        if name not in definition.messages:
            raise DefinitionError(f"{name} is not defined in it")
        if len(inside) > 50:
            raise DefinitionError("it is nested deeper than 50 levels")
        if not definition.messages[name]:
            raise DefinitionError(f"{name} has no members")
        for part in definition.messages[name]:
            if part.length == 0:
                raise DefinitionError(f'"{part.name}" is an array of no elements')
            if part.type not in PRIMITIVES and part.type != STRING:
                visit(part.type, (*inside, name))
        done.add(name)

    visit(definition.root, ())
    return definition


def parse_path(text: str) -> list[Path]:
    """Parse the path of a field; a range of elements gives a path for each.

    >>> parse_path("pose.position.x"), parse_path("data[1:3]")
    ([('pose', 'position', 'x')], [('data', 1), ('data', 2)])

    Raises
    ------
    ValueError
        For something else.
    """
    paths: list[Path] = [()]
    for part in text.split("."):
        match = _PART.match(part)
        if match is None:
            raise ValueError(f'"{text}" is not the path of a field')
        steps: list[Path] = [(match["name"],)]
        if match["first"] is not None:
            first = int(match["first"])
            end = first + 1 if match["end"] is None else int(match["end"])
            steps = [(match["name"], number) for number in range(first, min(end, first + _MOST))]
        if len(paths) * len(steps) > _MOST:
            raise ValueError(f'"{text}" names more than {_MOST} elements')
        paths = [path + step for path in paths for step in steps]
    return paths


def path_text(path: Path) -> str:
    """Write a path as `parse_path` reads it.

    >>> path_text(("data", 3)), path_text(("pose", "position", "x"))
    ('data[3]', 'pose.position.x')
    """
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}"
    return text.removeprefix(".")
