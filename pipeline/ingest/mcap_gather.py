"""Numbers of many messages of ROS at once: gathered from the bytes where they have their place.

Where a number stands in CDR (ROS 2) or a message of ROS 1 is settled by its definition and by the
lengths of the strings and sequences before it. So the layout is worked out on one message; every
message with the same lengths in the same places has it, and its numbers are gathered with one NumPy
index each. Plain CDR, versions 1 and 2, both byte orders: OMG, DDS-XTYPES 1.3, section 7.4. Of ROS
1: wiki.ros.org/msg, "Serialization".
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.ingest.mcap_chunk import Bytes, at_every_byte
from pipeline.ingest.message_definitions import (
    PRIMITIVES,
    STRING,
    BrokenMessageError,
    Definition,
    Path,
)
from pipeline.types import IntArray

#: Layouts kept for one channel; beyond, they are worked out anew.
_MOST_LAYOUTS = 256
_MOST_PLACES = 200_000
#: Second byte of the header -> byte order, largest alignment. The first byte is zero.
REPRESENTATIONS = {0: (">", 8), 1: ("<", 8), 6: (">", 4), 7: ("<", 4)}
HEADER_BYTES = 4


@dataclass(frozen=True)
class FieldPlace:
    """Where a number or an array of numbers stands in a message: offset, kind, how many."""

    offset: int
    kind: np.dtype[np.generic]
    count: int | None


@dataclass
class Layout:
    """Layout of messages of one size, in one byte order ("<" or ">")."""

    order: str
    fixed: list[tuple[int, int, int]] = field(default_factory=list)
    """Offset, width in bytes, value of what a message must have there to be laid out like this:
    each length, and the representation."""
    places: dict[Path, FieldPlace] = field(default_factory=dict)
    texts: dict[Path, tuple[int, int]] = field(default_factory=dict)
    """Where a text begins and how many bytes it has."""

    def place(self, path: Path) -> FieldPlace | None:
        """Return where one number stands, None where the message does not have it."""
        found = self.places.get(path)
        if found is not None:
            return found if found.count is None else None
        if path and isinstance(path[-1], int):
            array = self.places.get(path[:-1])
            if array is not None and array.count is not None and path[-1] < array.count:
                return FieldPlace(array.offset + path[-1] * array.kind.itemsize, array.kind, None)
        return None

    def matching(self, buffer: Bytes, start: IntArray) -> npt.NDArray[np.bool_]:
        """Tell which messages of the right size have this layout."""
        same = np.ones(start.size, np.bool_)
        for offset, width, value in self.fixed:
            words = at_every_byte(buffer, np.dtype(f"{self.order}u{width}"))
            same &= words[start + offset] == value
        return same


def layout_of(definition: Definition, message: bytes | memoryview) -> Layout:
    """Work out the layout of a message; raises `BrokenMessageError`."""
    return _Walk(definition, message, with_values=False).layout


def decode(definition: Definition, message: bytes | memoryview) -> dict[str, Any]:
    r"""Decode one message, slow and general: numbers, texts, lists, dictionaries by field.

    Raises `BrokenMessageError` if the bytes end too early or announce more than there is.

    >>> from pipeline.ingest.message_definitions import parse_definition
    >>> definition = parse_definition("a/msg/B", "uint8 x\nint16 y", "ros2msg")
    >>> decode(definition, bytes([0, 1, 0, 0, 7, 0, 1, 1]))
    {'x': 7, 'y': 257}
    """
    return _Walk(definition, message, with_values=True).tree


class _Walk:
    """Goes through a message field by field, and notes where everything stands."""

    def __init__(
        self, definition: Definition, message: bytes | memoryview, *, with_values: bool
    ) -> None:
        self._definition = definition
        self._message = message
        self._with_values = with_values
        # ROS 1 has no header, no alignment and no zero at the end of a text
        self._begin, order, self._most = 0, "<", 1
        if definition.wire == "cdr":
            self._begin = HEADER_BYTES
            if len(message) < HEADER_BYTES:
                raise BrokenMessageError(f"it has {len(message)} bytes, not even a header")
            if message[0] != 0 or message[1] not in REPRESENTATIONS:
                shown = bytes(message[:2]).hex(" ")
                raise BrokenMessageError(f"its representation {shown} is not plain CDR")
            order, self._most = REPRESENTATIONS[message[1]]
        self._at = self._begin
        self.layout = Layout(order)
        if self._begin:
            self.layout.fixed += [(0, 1, message[0]), (1, 1, message[1])]
        self.tree = self._message_at((), definition.root)

    def _message_at(self, path: Path, name: str) -> dict[str, Any]:
        return {
            part.name: self._value((*path, part.name), part.type, part.length)
            for part in self._definition.messages[name]
        }

    def _value(self, path: Path, kind: str, length: int | None) -> Any:  # noqa: ANN401  any type
        if length is None:
            return self._one(path, kind)
        if length < 0:
            length = self._length()
        if kind in PRIMITIVES:
            if length:
                return self._numbers(path, kind, length)
            self.layout.places[path] = FieldPlace(self._at, np.dtype("u1"), 0)
            return []
        if length > len(self._message) - self._at:
            raise BrokenMessageError(f"{length} elements are announced, more than it has bytes")
        return [self._one((*path, number), kind) for number in range(length)]

    def _one(self, path: Path, kind: str) -> Any:  # noqa: ANN401  any type
        if kind in PRIMITIVES:
            return self._numbers(path, kind, None)
        if kind != STRING:
            return self._message_at(path, kind)
        size = self._length()
        begin = self._at
        self.layout.texts[path] = (begin, size)
        self._pass(size)
        text = bytes(self._message[begin : begin + size]) if self._with_values else b""
        return text.rstrip(b"\x00").decode("utf-8", errors="replace")

    def _numbers(self, path: Path, kind: str, count: int | None) -> Any:  # noqa: ANN401  one or many
        code = np.dtype(f"{self.layout.order}{PRIMITIVES[kind]}")
        self._align(code.itemsize)
        if len(self.layout.places) >= _MOST_PLACES:
            raise BrokenMessageError(f"it has more than {_MOST_PLACES} numbers")
        begin = self._at
        self.layout.places[path] = FieldPlace(begin, code, count)
        self._pass(code.itemsize * (1 if count is None else count))
        if not self._with_values:
            return None
        values = np.frombuffer(self._message, code, count or 1, begin).tolist()
        return values[0] if count is None else values

    def _length(self) -> int:
        self._align(4)
        begin = self._at
        self._pass(4)
        word = self._message[begin : begin + 4]
        value = int.from_bytes(word, "little" if self.layout.order == "<" else "big")
        self.layout.fixed.append((begin, 4, value))
        return value

    def _align(self, size: int) -> None:
        self._at += -(self._at - self._begin) % min(size, self._most)

    def _pass(self, size: int) -> None:
        if size > len(self._message) - self._at:
            left = max(len(self._message) - self._at, 0)
            raise BrokenMessageError(f"{size} bytes are announced where {left} are left")
        self._at += size


class Layouts:
    """The layouts of one channel that were met so far."""

    def __init__(self, definition: Definition) -> None:
        self._definition = definition
        self._known: dict[int, list[Layout]] = {}
        self._count = 0

    def groups(
        self, buffer: Bytes, start: IntArray, size: IntArray
    ) -> tuple[list[tuple[IntArray, Layout]], dict[int, str]]:
        """Return the rows (of k messages) of each layout, and why others cannot be read, by row."""
        groups: list[tuple[IntArray, Layout]] = []
        broken: dict[int, str] = {}
        same_size = size.size > 0 and bool((size == size[0]).all())
        for length in size[:1].tolist() if same_size else np.unique(size).tolist():
            rows = np.arange(size.size) if same_size else np.flatnonzero(size == length)
            for layout in self._known.get(length, ()):
                if not rows.size:
                    break
                fits = layout.matching(buffer, start[rows])
                if fits.any():
                    groups.append((rows[fits], layout))
                    rows = rows[~fits]
            while rows.size:
                first = int(rows[0])
                begin = int(start[first])
                try:
                    layout = layout_of(self._definition, buffer[begin : begin + length].tobytes())
                except BrokenMessageError as error:
                    broken[first] = str(error)
                    rows = rows[1:]
                    continue
                if self._count < _MOST_LAYOUTS:
                    self._known.setdefault(length, []).append(layout)
                    self._count += 1
                fits = layout.matching(buffer, start[rows])
                groups.append((rows[fits], layout))
                rows = rows[~fits]
        return groups, broken
