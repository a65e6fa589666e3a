"""Decode protobuf messages by the descriptor set that MCAP embeds; no generated code, no library.

A field of proto3 that was not sent has its default, zero; one that is marked optional, in a oneof,
or a message is absent. Packed and unpacked repeated numbers are read alike; unknown fields are
passed over. Groups and maps are not supported (a map is read as a list of key and value).

References
----------
Protocol Buffers, Encoding, https://protobuf.dev/programming-guides/encoding/ ;
google/protobuf/descriptor.proto (field numbers below).
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pipeline.ingest.mcap_types import MOST_FIELDS, BrokenMessageError, DefinitionError

_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5
#: FieldDescriptorProto.Type of numbers -> wire type, struct code of the fixed ones.
_DOUBLE, _FLOAT, _INT64, _UINT64, _INT32, _FIXED_64, _FIXED_32, _BOOL = range(1, 9)
_STRING, _GROUP, _MESSAGE, _RAW, _UINT32, _ENUM, _SFIXED32, _SFIXED64, _SINT32, _SINT64 = range(
    9, 19
)
_FIXED = {
    _DOUBLE: ("<d", 8),
    _FLOAT: ("<f", 4),
    _FIXED_64: ("<Q", 8),
    _FIXED_32: ("<I", 4),
    _SFIXED32: ("<i", 4),
    _SFIXED64: ("<q", 8),
}
_REPEATED = 3
_MAX_DEPTH = 50
#: Fields of a message and of all messages in it that may have their default before they are read.
_MOST_DEFAULTS = 1_000_000


@dataclass(frozen=True)
class ProtoField:
    """A field: its type as in descriptor.proto, the message's full name where it is one."""

    name: str
    type: int
    is_repeated: bool
    message: str = ""
    has_presence: bool = False


@dataclass(frozen=True)
class ProtoDefinition:
    """Messages of a descriptor set: full name -> field number -> field."""

    root: str
    messages: dict[str, dict[int, ProtoField]]


def parse_descriptor_set(name: str, data: bytes) -> ProtoDefinition:
    """Parse a ``FileDescriptorSet``.

    Parameters
    ----------
    name : str
        Full name of the message, ``package.Name``.
    data : bytes
        The serialised set.

    Raises
    ------
    DefinitionError
        If it is none, or does not define the message.
    """
    messages: dict[str, dict[int, ProtoField]] = {}
    try:
        for number, content in _parts(data):
            if number == 1:
                _file(_bytes(content), messages)
    except (BrokenMessageError, UnicodeDecodeError) as error:
        raise DefinitionError(f"it is not a descriptor set of protobuf ({error})") from None
    if name not in messages:
        raise DefinitionError(f"{name} is not defined in it")
    if sum(map(len, messages.values())) > MOST_FIELDS:
        raise DefinitionError(f"it has more than {MOST_FIELDS} members")
    return ProtoDefinition(name, messages)


def _file(data: bytes, messages: dict[str, dict[int, ProtoField]]) -> None:
    package, syntax, types = "", "proto2", []
    for part, value in _parts(data):
        if part == 2:
            package = _bytes(value).decode()
        elif part == 12:
            syntax = _bytes(value).decode()
        elif part == 4:
            types.append(_bytes(value))
    for one in types:
        _message_type(one, package, syntax, messages, 0)


def _message_type(
    data: bytes,
    scope: str,
    syntax: str,
    messages: dict[str, dict[int, ProtoField]],
    depth: int,
) -> None:
    if depth > _MAX_DEPTH:
        raise BrokenMessageError("messages are nested too deeply")
    name, fields, nested = "", {}, []
    for part, value in _parts(data):
        if part == 1:
            name = _bytes(value).decode()
        elif part == 2:
            number, found = _field(_bytes(value), syntax)
            fields[number] = found
        elif part == 3:
            nested.append(_bytes(value))
    full = f"{scope}.{name}" if scope else name
    messages[full] = fields
    for inner in nested:
        _message_type(inner, full, syntax, messages, depth + 1)


def _field(data: bytes, syntax: str) -> tuple[int, ProtoField]:
    name, number, label, kind, message, explicit = "", 0, 1, 0, "", syntax != "proto3"
    for part, value in _parts(data):
        if part == 1:
            name = _bytes(value).decode()
        elif part == 3:
            number = _number(value)
        elif part == 4:
            label = _number(value)
        elif part == 5:
            kind = _number(value)
        elif part == 6:
            message = _bytes(value).decode().removeprefix(".")
        elif part in (9, 17):  # in a oneof, or marked optional in proto3
            explicit = True
    return number, ProtoField(name, kind, label == _REPEATED, message, explicit)


def decode_protobuf(definition: ProtoDefinition, data: memoryview | bytes) -> dict[str, Any]:
    """Decode a message.

    Returns
    -------
    dict
        Values by field: numbers, texts, lists, dictionaries; absent messages are left out.

    Raises
    ------
    BrokenMessageError
        If the bytes are not a message of this type.
    """
    return _Decoder(definition).message(definition.root, bytes(data), 0)


class _Decoder:
    def __init__(self, definition: ProtoDefinition) -> None:
        self._messages = definition.messages
        self._defaults = 0

    def message(self, name: str, data: bytes, depth: int) -> dict[str, Any]:
        if depth > _MAX_DEPTH:
            raise BrokenMessageError("it is nested too deeply")
        fields = self._messages.get(name)
        if fields is None:
            raise BrokenMessageError(f"{name} is not defined")
        self._defaults += len(fields)  # an element of two bytes has all of them
        if self._defaults > _MOST_DEFAULTS:
            raise BrokenMessageError(f"it has more than {_MOST_DEFAULTS} numbers")
        found = {
            part.name: _default(part)
            for part in fields.values()
            if part.is_repeated or not (part.has_presence or part.type in (_MESSAGE, _GROUP))
        }
        for number, value in _parts(data):
            known = fields.get(number)
            if known is None:
                continue
            for one in self._values(known, value, depth):
                if known.is_repeated:
                    found[known.name].append(one)
                else:
                    found[known.name] = one
        return found

    def _values(self, part: ProtoField, value: int | bytes, depth: int) -> Iterator[Any]:
        if part.type == _MESSAGE:
            yield self.message(part.message, _bytes(value), depth + 1)
        elif part.type == _STRING:
            yield _bytes(value).decode("utf-8", errors="replace")
        elif part.type == _RAW:
            yield list(_bytes(value))
        elif part.type in _FIXED:
            code, size = _FIXED[part.type]
            content = _bytes(value)
            if len(content) % size or (not part.is_repeated and len(content) != size):
                raise BrokenMessageError(f"{part.name} has {len(content)} bytes")
            for (one,) in struct.iter_unpack(code, content):
                yield one
        elif isinstance(value, bytes):  # packed
            at = 0
            while at < len(value):
                one, at = _varint(value, at)
                yield _signed(part.type, one)
        else:
            yield _signed(part.type, value)


def _default(part: ProtoField) -> Any:  # noqa: ANN401  a value of the field's type
    """Return what a field means that was not sent."""
    if part.is_repeated:
        return []
    if part.type in (_STRING, _RAW):
        return "" if part.type == _STRING else []
    return 0.0 if part.type in (_DOUBLE, _FLOAT) else 0


def _signed(kind: int, value: int) -> int:
    """Turn the bits of a varint into the number that the field's type means."""
    if kind in (_SINT32, _SINT64):
        return (value >> 1) ^ -(value & 1)
    if kind in (_INT32, _INT64, _ENUM):
        value &= (1 << 64) - 1
        signed = value - (1 << 64) if value >> 63 else value
        return (signed + (1 << 31)) % (1 << 32) - (1 << 31) if kind != _INT64 else signed
    if kind == _BOOL:
        return int(value != 0)
    return value & ((1 << (32 if kind == _UINT32 else 64)) - 1)


def _parts(data: bytes) -> Iterator[tuple[int, int | bytes]]:
    """Yield field numbers with varints, or with bytes (fixed numbers are bytes, too)."""
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        number, wire = key >> 3, key & 7
        if wire == _VARINT:
            value, at = _varint(data, at)
            yield number, value
            continue
        if wire == _BYTES:
            size, at = _varint(data, at)
        elif wire in (_FIXED64, _FIXED32):
            size = 8 if wire == _FIXED64 else 4
        else:
            raise BrokenMessageError(f"wire type {wire} is not supported")
        if number == 0 or size > len(data) - at:
            raise BrokenMessageError(f"{size} bytes are announced where {len(data) - at} are left")
        yield number, data[at : at + size]
        at += size


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value, shift = 0, 0
    while True:
        if at >= len(data) or shift > 63:
            raise BrokenMessageError("a number has no end")
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7


def _bytes(value: int | bytes) -> bytes:
    if isinstance(value, int):
        raise BrokenMessageError("a number stands where bytes are expected")
    return value


def _number(value: int | bytes) -> int:
    if isinstance(value, bytes):
        raise BrokenMessageError("bytes stand where a number is expected")
    return value
