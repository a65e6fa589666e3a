"""Serialise many messages of one type and one size at once, in ROS 2's CDR.

The layout is plain CDR (XCDR version 1), little endian: a header of four bytes, then the fields in
order, each aligned to its own size counted from the end of the header. A string is its length with
the closing zero, its bytes, the zero; a sequence is its length and its elements. All messages of a
call have the same strings and lengths of sequences, so they have one size, and each field is one
column of a matrix of bytes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    `type` is a primitive's name or a message's full one; `length` is None for a single value, 0
    for a sequence of any length, else the length of a fixed array.
    """

    name: str
    type: str
    length: int | None


@cache
def _messages() -> "Typestore":
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_HUMBLE)


@cache
def fields(message_type: str) -> tuple[MessageField, ...]:
    """Fields of a message, ``package/msg/Name``, as they are serialised; constants left out.

    Raises
    ------
    KeyError
        For a message that there is not.

    >>> [field.name for field in fields("sensor_msgs/msg/FluidPressure")]
    ['header', 'fluid_pressure', 'variance']
    """
    from rosbags.interfaces import Nodetype

    found = []
    # rosbags' nested tuples: of an array or a sequence what each element is, and how many
    members: Any = _messages().fielddefs[message_type][1]
    for name, (whole, own) in members:
        (kind, inner), length = (
            own if whole in (Nodetype.ARRAY, Nodetype.SEQUENCE) else ((whole, own), None)
        )
        found.append(MessageField(name, str(inner if kind == Nodetype.NAME else inner[0]), length))
    return tuple(found)


def is_message(field_type: str) -> bool:
    """Whether a field's type is a message, not a primitive.

    >>> is_message("geometry_msgs/msg/Vector3"), is_message("float64")
    (True, False)
    """
    return "/" in field_type


def schema_text(message_type: str) -> str:
    """Definition with those of all messages in it appended, as MCAP's ``ros2msg`` wants it.

    >>> print(schema_text("std_msgs/msg/Header"))  # doctest: +ELLIPSIS
    builtin_interfaces/Time stamp
    string frame_id
    =====...
    MSG: builtin_interfaces/Time
    int32 sec
    uint32 nanosec
    <BLANKLINE>
    """
    return _messages().generate_msgdef(message_type, ros_version=2)[0]


#: What a field may be filled with: one value for all messages, or an array with a row a message.
Filling = float | str | tuple[str, ...] | npt.NDArray[np.generic]
Bytes = npt.NDArray[np.uint8]

#: Representation identifier of plain CDR, little endian, and two bytes of options.
_HEADER = b"\x00\x01\x00\x00"
_PRIMITIVES = {
    "bool": np.dtype("?"),
    "uint8": np.dtype("u1"),
    "int32": np.dtype("<i4"),
    "uint32": np.dtype("<u4"),
    "float32": np.dtype("<f4"),
    "float64": np.dtype("<f8"),
}


def serialise(message_type: str, count: int, values: Mapping[str, Filling]) -> Bytes:
    """Serialise `count` messages of one type, ``package/msg/Name``: bytes (count, size).

    Parameters
    ----------
    values : mapping
        Path of a field (``header.stamp.sec``) to what fills it: a number or text for all
        messages, an array (k,) for a single field, (k, m) for an array or a sequence of m, or for
        a message of m numbers (``angular_velocity``), whose fields take the columns in order.
        Fields that are not named are zero or empty.

    Raises
    ------
    ValueError, TypeError
        For a path that the message does not have, or values of another shape; for text where
        numbers belong, and the other way round.

    References
    ----------
    OMG, DDS Interoperability Wire Protocol 2.2, section 10; OMG, DDS-XTYPES 1.3, section 7.4.

    >>> time = serialise("builtin_interfaces/msg/Time", 2, {"sec": np.array([1, 2]), "nanosec": 9})
    >>> time.tolist()
    [[0, 1, 0, 0, 1, 0, 0, 0, 9, 0, 0, 0], [0, 1, 0, 0, 2, 0, 0, 0, 9, 0, 0, 0]]
    """
    layout = _Layout(count, values)
    layout.message(message_type, "")
    unknown = set(values) - layout.used
    if unknown:
        raise ValueError(f"{message_type} has no field {', '.join(sorted(unknown))}")
    return layout.rows()


class _Layout:
    """Bytes common to all messages, and the columns that differ."""

    def __init__(self, count: int, values: Mapping[str, Filling]) -> None:
        self.used: set[str] = set()
        self._count = count
        self._values = values
        self._common = bytearray(_HEADER)
        self._columns: list[tuple[int, Bytes]] = []

    def rows(self) -> Bytes:
        rows = np.tile(np.frombuffer(bytes(self._common), np.uint8), (self._count, 1))
        for begin, column in self._columns:
            rows[:, begin : begin + column.shape[1]] = column
        return rows

    def message(self, message_type: str, path: str) -> None:
        filling = self._take(path) if path else None
        parts = fields(message_type)
        columns = None if filling is None else self._matrix(filling, len(parts), path)
        for i, field in enumerate(parts):
            below = f"{path}.{field.name}" if path else field.name
            self._field(field, below, None if columns is None else columns[:, i])

    def _field(self, field: MessageField, path: str, given: npt.NDArray[np.generic] | None) -> None:
        if is_message(field.type):
            if field.length is not None or given is not None:
                raise ValueError(f"{path}: only messages of plain numbers take columns")
            self.message(field.type, path)
            return
        filling = self._take(path) if given is None else given
        if field.type == "string":
            self._text(field, filling, path)
            return
        kind = _PRIMITIVES[field.type]
        if field.length is None:
            self._numbers(kind, 0.0 if filling is None else filling, 1, path)
        elif field.length > 0:
            self._numbers(kind, 0.0 if filling is None else filling, field.length, path)
        else:
            # the length of a sequence comes from what fills it
            length = 0 if filling is None else _width(filling, path)
            self._number_of_elements(length)
            if filling is not None and length > 0:
                self._numbers(kind, filling, length, path)

    def _text(self, field: MessageField, filling: Filling | None, path: str) -> None:
        if field.length is None:
            if not isinstance(filling, str | None):
                raise TypeError(f"{path}: text is expected")
            self._string(filling or "")
            return
        texts = () if filling is None else filling
        if not isinstance(texts, tuple):
            raise TypeError(f"{path}: a tuple of texts is expected")
        self._number_of_elements(len(texts))
        for text in texts:
            self._string(text)

    def _numbers(
        self, kind: np.dtype[np.generic], filling: Filling, length: int, path: str
    ) -> None:
        self._align(kind.itemsize)
        begin = len(self._common)
        if isinstance(filling, np.ndarray):
            matrix = np.ascontiguousarray(self._matrix(filling, length, path), dtype=kind)
            self._columns.append((begin, matrix.view(np.uint8)))
            self._common += bytes(kind.itemsize * length)
        elif isinstance(filling, int | float):
            self._common += np.full(length, filling, kind).tobytes()
        else:
            raise TypeError(f"{path}: numbers are expected")

    def _matrix(self, filling: Filling, length: int, path: str) -> npt.NDArray[np.generic]:
        matrix = np.asarray(filling)
        if matrix.ndim == 1 and length == 1:
            matrix = matrix[:, None]
        if matrix.shape != (self._count, length):
            raise ValueError(
                f"{path}: values of shape {np.shape(filling)} do not fill {self._count} messages "
                f"with {length} each"
            )
        return matrix

    def _string(self, text: str) -> None:
        content = text.encode() + b"\x00"
        self._number_of_elements(len(content))
        self._common += content

    def _number_of_elements(self, length: int) -> None:
        self._align(4)
        self._common += length.to_bytes(4, "little")

    def _align(self, size: int) -> None:
        self._common += bytes(-(len(self._common) - len(_HEADER)) % size)

    def _take(self, path: str) -> Filling | None:
        self.used.add(path)
        return self._values.get(path)


def _width(filling: Filling, path: str) -> int:
    if not isinstance(filling, np.ndarray) or filling.ndim != 2:
        raise TypeError(f"{path}: a sequence takes an array with a row a message")
    return int(filling.shape[1])
