"""Messages in protobuf, decoded by google.protobuf by the descriptor set in the log."""

from collections.abc import Callable, Iterator
from typing import Any

from pipeline.ingest.mcap_types import MOST_FIELDS, BrokenMessageError, DefinitionError

_MAX_DEPTH = 50
#: Fields of a message and of all messages in it, sent or not.
_MOST_NUMBERS = 200_000
#: An element of two bytes becomes an object of some hundred.
_MOST_BYTES = 2_000_000
#: Definitions that every program has, and that writers therefore leave out.
_WELL_KNOWN = ("any", "duration", "empty", "field_mask", "struct", "timestamp", "wrappers")


def protobuf_decoder(name: str, data: bytes) -> Callable[[bytes], dict[str, Any]]:
    """Make a decoder of messages ``package.Name`` that a serialised descriptor set defines.

    Files of ``google/protobuf/`` may be missing in it. The decoder turns bytes into numbers, texts,
    lists, dictionaries, absent messages left out, and raises `BrokenMessageError` where the bytes
    are no message of this type. Raises `DefinitionError` if `data` is no descriptor set, or does
    not define the message.
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
        raise DefinitionError(f"its descriptor set is not sound ({_line(error)})") from None

    def decode(content: bytes) -> dict[str, Any]:
        if len(content) > _MOST_BYTES:
            raise BrokenMessageError(f"it has {len(content)} bytes; at most {_MOST_BYTES} are read")
        try:
            message = message_class.FromString(content)
        except (DecodeError, RecursionError) as error:
            raise BrokenMessageError(f"it is not a message of {name} ({_line(error)})") from None
        return _Tree().of(message, 0)

    return decode


def _members(message: Any, depth: int) -> int:  # noqa: ANN401  a DescriptorProto
    """Count the fields of a message and of those that are defined in it."""
    if depth > _MAX_DEPTH:
        raise DefinitionError("messages are nested too deeply")
    return len(message.field) + sum(_members(one, depth + 1) for one in message.nested_type)


def _add_files(pool: Any, described: Any) -> None:  # noqa: ANN401  of google.protobuf
    """Add files to a pool, each after those that it needs, with what is well known and absent."""
    import importlib

    waiting = {file.name or f"file-{number}": file for number, file in enumerate(described)}
    defined = {f"{file.package}.{one.name}" for file in described for one in file.message_type}
    added = []
    for name in _WELL_KNOWN:
        known = importlib.import_module(f"google.protobuf.{name}_pb2").DESCRIPTOR
        if not defined & {f"{known.package}.{one}" for one in known.message_types_by_name}:
            pool.AddSerializedFile(known.serialized_pb)
            added.append(known.name)
    while waiting:
        ready = [
            name
            for name, file in waiting.items()
            if not any(needed in waiting and needed != name for needed in file.dependency)
        ]
        if not ready:
            raise ValueError("its files need each other")
        for name in ready:
            file = waiting.pop(name)
            file.name = name
            file.dependency.extend(one for one in added if one not in file.dependency)
            pool.Add(file)


class _Tree:
    """Turns a message into dictionaries, lists, numbers and texts."""

    def __init__(self) -> None:
        self._numbers = 0

    def of(self, message: Any, depth: int) -> dict[str, Any]:  # noqa: ANN401  of google.protobuf
        if depth > _MAX_DEPTH:
            raise BrokenMessageError("it is nested too deeply")
        fields = message.DESCRIPTOR.fields
        self._numbers += len(fields)
        if self._numbers > _MOST_NUMBERS:
            raise BrokenMessageError(f"it has more than {_MOST_NUMBERS} numbers")
        return dict(self._fields(message, fields, depth))

    def _fields(self, message: Any, fields: Any, depth: int) -> Iterator[tuple[str, Any]]:  # noqa: ANN401  of google.protobuf
        for field in fields:
            value = getattr(message, field.name)
            if field.is_repeated:
                if field.message_type is not None and field.message_type.GetOptions().map_entry:
                    continue  # a map has no numbers in an order
                self._numbers += len(value)
                yield field.name, [self._one(field, one, depth) for one in value]
            elif not field.has_presence or message.HasField(field.name):
                yield field.name, self._one(field, value, depth)

    def _one(self, field: Any, value: Any, depth: int) -> Any:  # noqa: ANN401  of any type
        if field.message_type is not None:
            return self.of(value, depth + 1)
        if isinstance(value, bytes):
            return list(value)
        return int(value) if isinstance(value, bool) else value


def _line(error: Exception) -> str:
    return str(error).splitlines()[0][:100] if str(error) else type(error).__name__
