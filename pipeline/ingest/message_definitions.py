"""Definitions of messages in every language that logs use, and paths into messages.

`rosbags` parses the text; what a reader of hostile files has to refuse beside it (sizes, nesting,
what its grammar passes over although it changes the layout) is refused here.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

#: Step into a message: the name of a field or the number of an element.
Step = str | int
Path = tuple[Step, ...]

#: Primitive -> NumPy kind and size in bytes. Characters and booleans are small numbers here.
PRIMITIVES: Mapping[str, str] = {
    **dict.fromkeys(("bool", "byte", "char", "octet", "uint8"), "u1"),
    "int8": "i1",
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
_SEPARATOR = re.compile(r"^={3,}[ \t\r]*$", re.MULTILINE)
_IDL_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_IDL_SKIPPED = re.compile(r"^\s*(#.*|=+|IDL:.*)$", re.MULTILINE)
#: Their layout depends on more than the definition, or rosbags passes over them.
_IDL_REFUSED = re.compile(
    r"\b(union|map|wstring|wchar|bitset|bitmask|fixed|valuetype)\b|@(optional|mutable|appendable)\b"
)
_NESTED_SEQUENCE = re.compile(r"\bsequence\s*<\s*sequence\b")
_MOST_CHARACTERS = 200_000
#: rosbags takes time with their square.
_IDL_NAMES = re.compile(r"\b(?:typedef|const)\b|@")
_MOST_IDL_NAMES = 1000
_MAX_LENGTH = 10_000_000


class DefinitionError(ValueError):
    """The definition of a message cannot be understood; the text says why."""


class BrokenMessageError(ValueError):
    """A message does not hold what its definition promises."""


@dataclass(frozen=True)
class Field:
    """A field of a message; `length` is None for one value, -1 for a sequence of any length."""

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


def parse_path(text: str) -> list[Path]:
    """Parse the path of a field; a range of elements gives a path for each.

    >>> parse_path("pose.position.x"), parse_path("data[1:3]")
    ([('pose', 'position', 'x')], [('data', 1), ('data', 2)])

    Raises `ValueError` for something else.
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


#: A message without fields is one byte on the wire: its structure in C may not be empty.
_NO_FIELDS = (Field("structure_needs_at_least_one_member", "uint8"),)
_TIME = {
    "cdr": (Field("sec", "int32"), Field("nanosec", "uint32")),
    "ros1": (Field("sec", "uint32"), Field("nanosec", "uint32")),
}
#: Of ROS 1 alone: the header of every message is numbered.
_ROS1_HEADER = (
    Field("seq", "uint32"),
    Field("stamp", "builtin_interfaces/msg/Time"),
    Field("frame_id", STRING),
)


@lru_cache(maxsize=256)  # topics and logs share their types
def parse_definition(name: str, text: str, language: str) -> Definition:
    r"""Parse the definition of a message with those of the messages in it.

    `language` is "ros2msg", "ros1msg", "ros2idl" or "omgidl". Some recorders leave the definition
    of a standard message empty: then that of ROS 2 Humble is taken. Raises `DefinitionError`.

    >>> parse_definition("a/msg/B", "float64[3] x  # metres\nint8 LOW=1\n", "ros2msg").fields
    (Field(name='x', type='float64', length=3),)
    """
    root = re.sub("^([^/]*)/([^/]*)$", r"\1/msg/\2", name.replace("::", "/"))
    wire: Literal["cdr", "ros1"] = "ros1" if language == "ros1msg" else "cdr"
    if not text.strip():
        try:
            return _definition(root, {}, wire)
        except DefinitionError as error:
            raise DefinitionError(f"its definition is empty: {error}") from None
    if len(text) > _MOST_CHARACTERS:
        raise DefinitionError(f"it has {len(text)} characters; at most {_MOST_CHARACTERS} are read")
    types = _types_in(root, text, is_idl=language.endswith("idl"))
    if root not in types:
        raise DefinitionError(f"{name} is not defined in it")
    return _definition(root, types, wire)


def _types_in(root: str, text: str, *, is_idl: bool) -> Mapping[str, Any]:
    """Return what rosbags makes of a text: name -> constants and members of each message."""
    from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg

    if is_idl:
        text = _IDL_COMMENT.sub(" ", _IDL_SKIPPED.sub("", text))
        refused = _IDL_REFUSED.search(text)
        if refused is not None:
            raise DefinitionError(f'"{refused[0]}" is not supported')
        if _NESTED_SEQUENCE.search(text):
            raise DefinitionError("a sequence of sequences is not supported")
        if sum(1 for _ in _IDL_NAMES.finditer(text)) > _MOST_IDL_NAMES:
            raise DefinitionError(f"it has more than {_MOST_IDL_NAMES} typedefs and annotations")
    elif re.search(r"^---\s*$", text, re.MULTILINE):
        raise DefinitionError("it defines a service or an action, which is not one message")
    try:
        if is_idl:
            return get_types_from_idl(text)
        return get_types_from_msg(_SEPARATOR.sub("=" * 80, text), root)
    except (TypesysError, ValueError, RecursionError, IndexError, KeyError, TypeError) as error:
        # the place that could not be parsed, in one line
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        place = lines[-1][:60] if len(lines) > 1 else (lines or [type(error).__name__])[0][:100]
        raise DefinitionError(f'"{place}" cannot be understood') from None


def _definition(root: str, types: Mapping[str, Any], wire: Literal["cdr", "ros1"]) -> Definition:
    """Return a definition if nothing contains itself and all takes bytes."""
    messages: dict[str, tuple[Field, ...]] = {}

    def visit(name: str, inside: tuple[str, ...]) -> None:
        if name in inside:
            raise DefinitionError(f"{name} contains itself")
        if name in messages:
            return
        if len(inside) > 50:
            raise DefinitionError("it is nested deeper than 50 levels")
        messages[name] = _fields(name, types, wire)
        if sum(map(len, messages.values())) > MOST_FIELDS:
            raise DefinitionError(f"it has more than {MOST_FIELDS} members")
        for part in messages[name]:
            if part.type not in PRIMITIVES and part.type != STRING:
                visit(part.type, (*inside, name))

    visit(root, ())
    return Definition(root, messages, wire)


def _fields(name: str, types: Mapping[str, Any], wire: str) -> tuple[Field, ...]:
    # what files leave out, or rosbags takes for its namesake of ROS 2
    if name in ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"):
        return _TIME[wire]
    if wire == "ros1" and name == "std_msgs/msg/Header":
        return _ROS1_HEADER
    if name not in types:  # some recorders leave standard messages undefined
        from rosbags.typesys import Stores, get_typestore

        types = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    if name not in types:
        raise DefinitionError(f"{name} is not defined in it, and is no standard message")
    members = types[name][1]
    return tuple(_field(*one) for one in members) or _NO_FIELDS


def _field(name: str, kind: Any) -> Field:  # noqa: ANN401  rosbags' nested tuples
    from rosbags.interfaces import Nodetype

    node, content = kind
    length = None
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        length = content[1] if node == Nodetype.ARRAY else -1
        node, content = content[0]
        if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            raise DefinitionError(f'"{name}" is an array of arrays')
    if length is not None and length > _MAX_LENGTH:
        raise DefinitionError(f'"{name}" is too long an array')
    if length == 0:
        raise DefinitionError(f'"{name}" is an array of no elements')
    base = content if node == Nodetype.NAME else content[0]
    if node == Nodetype.BASE and base not in PRIMITIVES and base != STRING:
        raise DefinitionError(f'"{name}": {base} is not supported')
    return Field(name, base, length)
