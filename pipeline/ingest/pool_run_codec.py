"""One way to decode for each encoding of a log's messages; protobuf by google.protobuf."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from pipeline.errors import reason
from pipeline.ingest.mcap_gather import decode
from pipeline.ingest.mcap_records import ChannelRecord, SchemaRecord
from pipeline.ingest.message_definitions import (
    MOST_FIELDS,
    BrokenMessageError,
    Definition,
    DefinitionError,
    Path,
    parse_definition,
)

_MAX_DEPTH = 50
#: Fields of a message and of all messages in it, sent or not.
_MOST_NUMBERS = 200_000
#: An element of two bytes becomes an object of some hundred.
_MOST_BYTES = 2_000_000
#: Definitions that every program has, and that writers therefore leave out.
_WELL_KNOWN = ("any", "duration", "empty", "field_mask", "struct", "timestamp", "wrappers")
#: A message of one type as dictionaries, lists, numbers and texts.
Tree = dict[str, Any]
_LANGUAGES = {"cdr": ("ros2msg", "ros2idl", "omgidl"), "ros1": ("ros1msg",)}
_NUMBER = re.compile(r"\s*[+-]?\d+\.\d*(?:[eE][+-]?\d+)?\s*")
_JSON_TEXT = re.compile(rb'"(?:[^"\\]|\\.)*"')
_ZSTD = b"\x28\xb5\x2f\xfd"
#: A message that was compressed by itself unpacks to no more.
_MAX_UNPACKED_BYTES = 4_000_000
#: Names of components that say by themselves which is which.
_COMPONENT_NAMES = (
    *map(tuple, ("xyz", "xyzw", "uvw", "pqr")),
    ("qx", "qy", "qz", "qw"),
    ("roll", "pitch", "yaw"),
)


def protobuf_decoder(name: str, data: bytes) -> Callable[[bytes], dict[str, Any]]:
    """Make a decoder of messages ``package.Name`` that a serialised descriptor set defines.

    Files of ``google/protobuf/`` may be missing in it. The decoder raises `BrokenMessageError`.
    Raises `DefinitionError` if `data` is no descriptor set, or does not define the message.
    """
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
    from google.protobuf.message import DecodeError

    described = descriptor_pb2.FileDescriptorSet()
    try:
        described.ParseFromString(data)
    except (DecodeError, RecursionError):
        raise DefinitionError("it is not a descriptor set of protobuf") from None
    if sum(_members(one, 0) for file in described.file for one in file.message_type) > MOST_FIELDS:
        raise DefinitionError(f"it has more than {MOST_FIELDS} members")
    pool = descriptor_pool.DescriptorPool()
    try:
        _add_files(pool, described.file)
        message_class = message_factory.GetMessageClass(pool.FindMessageTypeByName(name))
    except KeyError:
        raise DefinitionError(f"{name} is not defined in it") from None
    except (TypeError, ValueError, RecursionError) as error:
        raise DefinitionError(f"its descriptor set is not sound ({reason(error, 100)})") from None

    def decode(content: bytes) -> dict[str, Any]:
        if len(content) > _MOST_BYTES:
            raise BrokenMessageError(f"it has {len(content)} bytes; at most {_MOST_BYTES} are read")
        try:
            message = message_class.FromString(content)
        except (DecodeError, RecursionError) as error:
            raise BrokenMessageError(
                f"it is not a message of {name} ({reason(error, 100)})"
            ) from None
        return _tree(message, 0, [_MOST_NUMBERS])

    return decode


def _members(message: Any, depth: int) -> int:  # noqa: ANN401  a DescriptorProto
    """Count the fields of a message and of those that are defined in it."""
    if depth > _MAX_DEPTH:
        raise DefinitionError("messages are nested too deeply")
    return len(message.field) + sum(_members(one, depth + 1) for one in message.nested_type)


def _add_files(pool: Any, described: Any) -> None:  # noqa: ANN401  of google.protobuf
    """Add files to a pool, each after those that it needs, with what is well known and absent."""
    import importlib

    defined = {f"{file.package}.{one.name}" for file in described for one in file.message_type}
    known = [
        importlib.import_module(f"google.protobuf.{one}_pb2").DESCRIPTOR for one in _WELL_KNOWN
    ]
    known = [
        one
        for one in known
        if defined.isdisjoint(f"{one.package}.{name}" for name in one.message_types_by_name)
    ]
    for one in known:
        pool.AddSerializedFile(one.serialized_pb)
    waiting = {file.name or f"file-{number}": file for number, file in enumerate(described)}

    def add(name: str) -> None:
        file = waiting.pop(name)
        for needed in file.dependency:
            if needed in waiting:
                add(needed)
        file.name = name
        file.dependency.extend(one.name for one in known if one.name not in file.dependency)
        pool.Add(file)

    while waiting:
        add(next(iter(waiting)))


def _tree(message: Any, depth: int, left: list[int]) -> Tree:  # noqa: ANN401  of google.protobuf
    """Turn a message into dictionaries, lists, numbers and texts; `left` counts the numbers."""
    found: Tree = {}
    if depth > _MAX_DEPTH:
        raise BrokenMessageError("it is nested too deeply")
    for field in message.DESCRIPTOR.fields:
        value, kind = getattr(message, field.name), field.message_type
        if field.is_repeated and kind is not None and kind.GetOptions().map_entry:
            continue  # a map has no numbers in an order
        left[0] -= 1 + (len(value) if field.is_repeated else 0)
        if left[0] < 0:
            raise BrokenMessageError(f"it has more than {_MOST_NUMBERS} numbers")
        if field.is_repeated:
            found[field.name] = [_plain(kind, part, depth, left) for part in value]
        elif not field.has_presence or message.HasField(field.name):
            found[field.name] = _plain(kind, value, depth, left)
    return found


def _plain(kind: Any, value: Any, depth: int, left: list[int]) -> Any:  # noqa: ANN401  of any type
    if kind is not None:
        return _tree(value, depth + 1, left)
    if isinstance(value, bytes):
        return list(value)
    return int(value) if isinstance(value, bool) else value


@dataclass(frozen=True)
class Codec:
    """How messages of a channel are decoded; `definition` is for the fast way of those of ROS.

    `packed`: each is compressed by itself, as by ``ros2 bag record --compression-mode message``.
    """

    decode: Callable[[bytes], Tree]
    definition: Definition | None = None
    packed: bool = False


def codec_of(channel: ChannelRecord, schema: SchemaRecord | None) -> Codec:
    """Choose the decoder of a channel; raises `DefinitionError` where there is none for it."""
    encoding = channel.message_encoding
    if encoding == "json":
        return Codec(decode_json)
    if encoding not in ("cdr", "ros1", "protobuf"):
        raise DefinitionError(
            f'messages are encoded as "{encoding}"; cdr (ROS 2), ros1, json and protobuf are read'
        )
    if schema is None:
        raise DefinitionError("the log does not hold the definition of its messages")
    if encoding == "protobuf":
        if schema.encoding != "protobuf":
            raise DefinitionError(f'its definition is "{schema.encoding}", not protobuf')
        return Codec(protobuf_decoder(schema.name, schema.data))
    if schema.encoding not in _LANGUAGES[encoding] and schema.data:
        raise DefinitionError(
            f'its definition is written in "{schema.encoding}"; '
            f"{', '.join(_LANGUAGES[encoding])} is understood for {encoding}"
        )
    language = schema.encoding or _LANGUAGES[encoding][0]
    text = schema.data.decode("utf-8", errors="replace")
    definition = parse_definition(schema.name, text, language)
    return Codec(partial(decode, definition), definition)


def packed(codec: Codec) -> Codec:
    """Return the codec of messages that are each compressed with zstd."""
    return Codec(lambda data: codec.decode(unpacked(data)), codec.definition, packed=True)


def is_packed(data: bytes) -> bool:
    """Tell a message that was compressed by itself."""
    return data.startswith(_ZSTD)


def unpacked(data: bytes) -> bytes:
    """Unpack one message; raises `BrokenMessageError` where it is broken or too large."""
    import zstandard

    try:
        with zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(data) as reader:
            found = reader.read(_MAX_UNPACKED_BYTES + 1)
    except zstandard.ZstdError as error:
        raise BrokenMessageError(f"it cannot be unpacked ({reason(error)})") from None
    if len(found) > _MAX_UNPACKED_BYTES:
        raise BrokenMessageError(f"it unpacks to more than {_MAX_UNPACKED_BYTES} bytes")
    return found


def decode_json(data: memoryview | bytes) -> Tree:
    """Decode a message; raises `BrokenMessageError` if it is no JSON object, or nested too deeply.

    >>> decode_json(b'{"depth": 1.5}')
    {'depth': 1.5}
    """
    data = bytes(data)
    try:
        found = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise BrokenMessageError(f"it is not JSON ({reason(error, 80)})") from None
    if not isinstance(found, dict):
        raise BrokenMessageError(f"it is a JSON {type(found).__name__}, not an object")
    if data.count(b"{") + data.count(b"[") > _MAX_DEPTH:
        signs = np.frombuffer(_JSON_TEXT.sub(b"", data), np.uint8)
        opens, closes = (np.isin(signs, list(some)).astype(int) for some in (b"{[", b"}]"))
        if np.cumsum(opens - closes).max() > _MAX_DEPTH:
            raise BrokenMessageError("it is nested deeper than 50 levels")
    return found


def value_at(tree: Any, path: Path) -> Any:  # noqa: ANN401  a message holds values of any type
    """Return what stands at a path, None where there is nothing.

    >>> value_at({"data": [1.0, 2.0]}, ("data", 1)), value_at({"data": []}, ("data", 1))
    (2.0, None)
    """
    here = tree
    for step in path:
        if isinstance(step, str):
            here = here.get(step) if isinstance(here, dict) else None
        elif isinstance(here, list) and step < len(here):
            here = here[step]
        else:
            return None
        if here is None:
            return None
    return here


def numbers_below(tree: Any, path: Path) -> list[Path]:  # noqa: ANN401  as above
    """Paths of all numbers at or below a path, in the order of the message.

    Components whose names say which is which come in their own order: the members of a JSON object
    have none, and a program that sorts them writes the w of a quaternion first.

    >>> numbers_below({"twist": {"linear": {"x": 1.0, "y": 2.0}}}, ("twist", "linear"))
    [('twist', 'linear', 'x'), ('twist', 'linear', 'y')]
    >>> [path[-1] for path in numbers_below({"q": {"w": 1.0, "x": 0, "y": 0, "z": 0}}, ("q",))]
    ['x', 'y', 'z', 'w']
    """
    value = value_at(tree, path)
    if isinstance(value, dict):
        names = next((known for known in _COMPONENT_NAMES if set(known) == set(value)), value)
        return [found for name in names for found in numbers_below(tree, (*path, name))]
    if isinstance(value, list):
        return [
            found
            for number in range(min(len(value), 10_000))
            for found in numbers_below(tree, (*path, number))
        ]
    if isinstance(value, str):  # some programs write numbers as texts
        return [path] if _NUMBER.fullmatch(value) else []
    return [path] if isinstance(value, int | float) else []
