"""Numbers of many CDR messages at once: gathered from the bytes where they all have their place.

Where a number stands in a CDR message is settled by its definition and by the lengths of the
strings and sequences before it. So the layout is worked out on one message, together with the
places of all those lengths; every message in which they are the same has the same layout, and its
numbers are gathered with one NumPy index each. What is left over gets a layout of its own.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from pipeline.ingest.mcap_cdr import HEADER_BYTES, representation
from pipeline.ingest.mcap_chunk import Bytes, at_every_byte
from pipeline.ingest.mcap_types import (
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


@dataclass(frozen=True)
class Place:
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
    places: dict[Path, Place] = field(default_factory=dict)
    texts: dict[Path, tuple[int, int]] = field(default_factory=dict)
    """Where a text begins and how many bytes it has."""

    def place(self, path: Path) -> Place | None:
        """Return where one number stands, None where the message does not have it."""
        found = self.places.get(path)
        if found is not None:
            return found if found.count is None else None
        if path and isinstance(path[-1], int):
            array = self.places.get(path[:-1])
            if array is not None and array.count is not None and path[-1] < array.count:
                return Place(array.offset + path[-1] * array.kind.itemsize, array.kind, None)
        return None

    def matching(self, buffer: Bytes, start: IntArray) -> npt.NDArray[np.bool_]:
        """Tell which messages of the right size have this layout."""
        same = np.ones(start.size, np.bool_)
        for offset, width, value in self.fixed:
            words = at_every_byte(buffer, np.dtype(f"{self.order}u{width}"))
            same &= words[start + offset] == value
        return same


def layout_of(definition: Definition, message: bytes | memoryview) -> Layout:
    """Work out the layout of a message.

    Raises
    ------
    BrokenMessageError
        If the bytes end too early or announce more than there is.
    """
    return _Walk(definition, message).layout


class _Walk:
    def __init__(self, definition: Definition, message: bytes | memoryview) -> None:
        order, self._most = representation(message)
        self._definition = definition
        self._message = message
        self._at = HEADER_BYTES
        self.layout = Layout(order)
        self.layout.fixed.append((0, 1, message[0]))
        self.layout.fixed.append((1, 1, message[1]))
        self._message_at((), definition.root)

    def _message_at(self, path: Path, name: str) -> None:
        for part in self._definition.messages[name]:
            self._value((*path, part.name), part.type, part.length)

    def _value(self, path: Path, kind: str, length: int | None) -> None:
        if length is None:
            self._one(path, kind)
            return
        if length < 0:
            length = self._length()
        if kind in PRIMITIVES:
            if length:
                self._numbers(path, kind, length)
            else:
                self.layout.places[path] = Place(self._at, np.dtype("u1"), 0)
            return
        if length > len(self._message) - self._at:
            raise BrokenMessageError(f"{length} elements are announced, more than it has bytes")
        for number in range(length):
            self._one((*path, number), kind)

    def _one(self, path: Path, kind: str) -> None:
        if kind in PRIMITIVES:
            self._numbers(path, kind, None)
        elif kind == STRING:
            size = self._length()
            self.layout.texts[path] = (self._at, size)
            self._pass(size)
        else:
            self._message_at(path, kind)

    def _numbers(self, path: Path, kind: str, count: int | None) -> None:
        code = np.dtype(f"{self.layout.order}{PRIMITIVES[kind]}")
        self._align(code.itemsize)
        if len(self.layout.places) >= _MOST_PLACES:
            raise BrokenMessageError(f"it has more than {_MOST_PLACES} numbers")
        self.layout.places[path] = Place(self._at, code, count)
        self._pass(code.itemsize * (1 if count is None else count))

    def _length(self) -> int:
        self._align(4)
        begin = self._at
        self._pass(4)
        word = self._message[begin : begin + 4]
        value = int.from_bytes(word, "little" if self.layout.order == "<" else "big")
        self.layout.fixed.append((begin, 4, value))
        return value

    def _align(self, size: int) -> None:
        self._at += -(self._at - HEADER_BYTES) % min(size, self._most)

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
        """Sort messages by layout.

        Parameters
        ----------
        buffer : ndarray of uint8
            Bytes of a block.
        start, size : ndarray, shape (k,)
            Where in it the messages are.

        Returns
        -------
        list of (rows, Layout)
            Numbers of the messages that have this layout.
        dict of str
            Number of a message that cannot be read -> why.
        """
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
