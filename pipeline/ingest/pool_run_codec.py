"""One way to decode for each encoding of a log's messages."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from pipeline.ingest.mcap_gather import decode
from pipeline.ingest.mcap_protobuf import protobuf_decoder
from pipeline.ingest.mcap_records import ChannelRecord, SchemaRecord
from pipeline.ingest.mcap_types import BrokenMessageError, Definition, DefinitionError, Path
from pipeline.ingest.ros_definitions import parse_definition

#: A message of one type as dictionaries, lists, numbers and texts.
Tree = dict[str, Any]
_LANGUAGES = {"cdr": ("ros2msg", "ros2idl", "omgidl"), "ros1": ("ros1msg",)}
_MAX_DEPTH = 50
_ZSTD = b"\x28\xb5\x2f\xfd"
#: A message that was compressed by itself unpacks to no more.
_MAX_UNPACKED_BYTES = 4_000_000


@dataclass(frozen=True)
class Codec:
    """How messages of a channel are decoded.

    `definition` is there for those of ROS, for their fast way. `packed` tells that each message is
    compressed with zstd by itself, as ``ros2 bag record --compression-mode message`` does.
    """

    decode: Callable[[bytes], Tree]
    definition: Definition | None = None
    packed: bool = False


def codec_of(channel: ChannelRecord, schema: SchemaRecord | None) -> Codec:
    """Choose the decoder of a channel.

    Raises
    ------
    DefinitionError
        Where its encoding is unknown or its definition missing or not understood.
    """
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
    """Unpack one message.

    Raises
    ------
    BrokenMessageError
        If it cannot be unpacked, or to more than a message of readings has.
    """
    import zstandard

    try:
        with zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(data) as reader:
            found = reader.read(_MAX_UNPACKED_BYTES + 1)
    except zstandard.ZstdError as error:
        raise BrokenMessageError(f"it cannot be unpacked ({error})") from None
    if len(found) > _MAX_UNPACKED_BYTES:
        raise BrokenMessageError(f"it unpacks to more than {_MAX_UNPACKED_BYTES} bytes")
    return found


def decode_json(data: memoryview | bytes) -> Tree:
    """Decode a message.

    Raises
    ------
    BrokenMessageError
        If it is not a JSON object, or nested deeper than 50 levels. ``NaN`` and ``Infinity`` are
        understood.

    Examples
    --------
    >>> decode_json(b'{"depth": 1.5}')
    {'depth': 1.5}
    """
    data = bytes(data)
    try:
        found = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise BrokenMessageError(f"it is not JSON ({str(error)[:80]})") from None
    if not isinstance(found, dict):
        raise BrokenMessageError(f"it is a JSON {type(found).__name__}, not an object")
    # brackets in texts count here, too: whether it is deep the walk decides
    if data.count(b"{") + data.count(b"[") > _MAX_DEPTH and _is_too_deep(found):
        raise BrokenMessageError("it is nested deeper than 50 levels")
    return found


def _is_too_deep(tree: Tree) -> bool:
    level: list[Any] = [tree]
    for _ in range(_MAX_DEPTH):
        level = [
            part
            for node in level
            for part in (node.values() if isinstance(node, dict) else node)
            if isinstance(part, dict | list)
        ]
    return bool(level)


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


#: Names of components that say by themselves which is which.
_COMPONENT_NAMES = (
    ("x", "y", "z"),
    ("x", "y", "z", "w"),
    ("qx", "qy", "qz", "qw"),
    ("roll", "pitch", "yaw"),
    ("u", "v", "w"),
    ("p", "q", "r"),
)


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
    return [path] if isinstance(value, int | float) else []
