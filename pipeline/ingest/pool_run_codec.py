"""One way to decode for each encoding of a log's messages."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pipeline.ingest.mcap_cdr import decode_cdr
from pipeline.ingest.mcap_idl import parse_idl
from pipeline.ingest.mcap_json import decode_json
from pipeline.ingest.mcap_protobuf import decode_protobuf, parse_descriptor_set
from pipeline.ingest.mcap_records import ChannelRecord, SchemaRecord
from pipeline.ingest.mcap_ros2msg import parse_ros2msg
from pipeline.ingest.mcap_types import Definition, DefinitionError, Path

#: A message of one type as dictionaries, lists, numbers and texts.
Tree = dict[str, Any]


@dataclass(frozen=True)
class Codec:
    """How messages of a channel are decoded; `definition` is there for CDR, for its fast way."""

    decode: Callable[[bytes], Tree]
    definition: Definition | None = None


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
    if encoding not in ("cdr", "protobuf"):
        raise DefinitionError(
            f'messages are encoded as "{encoding}"; cdr (ROS 2), json and protobuf are read'
        )
    if schema is None:
        raise DefinitionError("the log does not hold the definition of its messages")
    if encoding == "protobuf":
        if schema.encoding != "protobuf":
            raise DefinitionError(f'its definition is "{schema.encoding}", not protobuf')
        proto = parse_descriptor_set(schema.name, schema.data)
        return Codec(lambda data: decode_protobuf(proto, data))
    text = schema.data.decode("utf-8", errors="replace")
    if schema.encoding == "ros2msg":
        definition = parse_ros2msg(schema.name, text)
    elif schema.encoding in ("ros2idl", "omgidl"):
        definition = parse_idl(schema.name, text)
    else:
        raise DefinitionError(
            f'its definition is written in "{schema.encoding}"; ros2msg, ros2idl and omgidl are '
            "understood for cdr"
        )
    return Codec(lambda data: decode_cdr(definition, data), definition)


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
