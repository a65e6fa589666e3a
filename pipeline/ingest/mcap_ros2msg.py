"""Read ROS 2 message definitions (``ros2msg``) as MCAP embeds them."""

import re
from collections.abc import Iterator, Mapping

from pipeline.ingest.mcap_types import (
    PRIMITIVES,
    STRING,
    Definition,
    DefinitionError,
    Field,
    checked,
)

_SEPARATOR = re.compile(r"^=+\s*$")
_NAME = re.compile(r"^(MSG|SRV|ACTION):\s*(?P<name>\S+)\s*$")
_TYPE = re.compile(
    r"^(?P<base>[A-Za-z][A-Za-z0-9_/]*)(<=[0-9]+)?(?P<array>\[(?P<bound><=)?(?P<length>[0-9]{0,9})\])?$"
)
_TIME = (Field("sec", "int32"), Field("nanosec", "uint32"))
#: Understood although files leave them out.
_BUILT_IN = {"builtin_interfaces/Time": _TIME, "builtin_interfaces/Duration": _TIME}
_SHORT = {"time": "builtin_interfaces/Time", "duration": "builtin_interfaces/Duration",
          "Header": "std_msgs/Header"}  # fmt: skip
#: A message without fields is one byte on the wire: its structure in C may not be empty.
_NO_FIELDS = (Field("structure_needs_at_least_one_member", "uint8"),)
_MAX_LENGTH = 10_000_000


def parse_ros2msg(name: str, text: str) -> Definition:
    r"""Parse a definition with those of the messages in it.

    Parameters
    ----------
    name : str
        ``package/msg/Name``.
    text : str
        The definition, the others behind lines of ``=`` and ``MSG: package/Name``.

    Raises
    ------
    DefinitionError
        With the line that cannot be understood.

    Examples
    --------
    >>> parse_ros2msg("a/msg/B", "float64[3] x  # metres\nint8 LOW=1\n").fields
    (Field(name='x', type='float64', length=3),)
    """
    root = _short(name)
    texts: dict[str, list[str]] = {}
    for section, lines in _sections(root, text):
        texts.setdefault(section, lines)
    messages: dict[str, tuple[Field, ...]] = dict(_BUILT_IN)
    known: dict[str, list[str]] = {}
    for section in texts:
        known.setdefault(section.rsplit("/", maxsplit=1)[-1], []).append(section)
    for section, lines in texts.items():
        messages[section] = tuple(_fields(section, lines, known)) or _NO_FIELDS
    return checked(Definition(root, messages))


def _sections(root: str, text: str) -> Iterator[tuple[str, list[str]]]:
    name: str | None = root
    lines: list[str] = []
    for line in text.splitlines():
        if _SEPARATOR.match(line) and len(line.strip()) >= 3:
            if name is not None:
                yield name, lines
            name, lines = None, []
        elif name is None:
            match = _NAME.match(line.strip())
            if match is None and line.strip():
                raise DefinitionError(f'"{line.strip()[:60]}" stands where MSG: is expected')
            name = None if match is None else _short(match["name"])
        else:
            lines.append(line)
    if name is not None:
        yield name, lines


def _fields(section: str, lines: list[str], known: Mapping[str, list[str]]) -> Iterator[Field]:
    for line in lines:
        words = line.split("#", maxsplit=1)[0].split(maxsplit=2)
        if not words:
            continue
        if words[0] == "---":
            raise DefinitionError("it defines a service or an action, which is not one message")
        match = _TYPE.match(words[0])
        if match is None or len(words) < 2:
            raise DefinitionError(f'"{line.strip()[:60]}" is not a field')
        if "=" in words[1] or (len(words) == 3 and words[2].startswith("=")):
            continue  # a constant
        length = None
        if match["array"] is not None:
            length = -1 if match["bound"] or not match["length"] else int(match["length"])
        if length is not None and length > _MAX_LENGTH:
            raise DefinitionError(f'"{line.strip()[:60]}" is too long an array')
        yield Field(words[1], _resolve(match["base"], section, known), length)


def _resolve(base: str, section: str, known: Mapping[str, list[str]]) -> str:
    """Full name of a field's type: a bare message name belongs to the package it is used in.

    `known` has the full names of what is defined by their last part.
    """
    if base in PRIMITIVES or base == STRING:
        return base
    if base == "wstring":
        raise DefinitionError("wstring is not supported")
    if "/" in base:
        return _short(base)
    same_package = f"{section.rsplit('/', maxsplit=1)[0]}/{base}"
    near = known.get(base, [])
    if same_package in near:
        return same_package
    if base in _SHORT:
        return _SHORT[base]
    # a request in the definition of a service event stands in its package's srv
    return near[0] if len(near) == 1 else same_package


def _short(name: str) -> str:
    """``package/msg/Name`` as ``package/Name``, which is how definitions refer to it."""
    return name.replace("/msg/", "/")
