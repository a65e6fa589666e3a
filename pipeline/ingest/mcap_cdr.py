"""Decode one message in CDR by its definition: slow, general, the reference for the fast way.

Plain CDR (versions 1 and 2), both byte orders. Alignment counts from the end of the four bytes
that say which it is; version 2 aligns 8-byte numbers to 4.

References
----------
OMG, DDS-XTYPES 1.3, section 7.4.
"""

import struct
from typing import Any

from pipeline.ingest.mcap_types import (
    PRIMITIVES,
    STRING,
    BrokenMessageError,
    Definition,
)

_CODES = {"u1": "B", "i1": "b", "u2": "H", "i2": "h", "u4": "I", "i4": "i", "u8": "Q", "i8": "q",
          "f4": "f", "f8": "d"}  # fmt: skip
#: Second byte of the header -> byte order, largest alignment. The first byte is zero.
REPRESENTATIONS = {0: (">", 8), 1: ("<", 8), 6: (">", 4), 7: ("<", 4)}
HEADER_BYTES = 4


def representation(data: memoryview | bytes) -> tuple[str, int]:
    """Return byte order and largest alignment of a message.

    Raises
    ------
    BrokenMessageError
        For parameter lists and other representations, and messages without header.
    """
    if len(data) < HEADER_BYTES:
        raise BrokenMessageError(f"it has {len(data)} bytes, not even a header")
    found = REPRESENTATIONS.get(data[1]) if data[0] == 0 else None
    if found is None:
        raise BrokenMessageError(f"its representation {data[0]:02x} {data[1]:02x} is not plain CDR")
    return found


def decode_cdr(definition: Definition, data: memoryview | bytes) -> dict[str, Any]:
    r"""Decode a message.

    Parameters
    ----------
    definition : Definition
        Its fields.
    data : bytes
        With the header.

    Returns
    -------
    dict
        Values by field: numbers, texts, lists, dictionaries.

    Raises
    ------
    BrokenMessageError
        If the bytes end too early or announce more than there is.

    Examples
    --------
    >>> from pipeline.ingest.mcap_ros2msg import parse_ros2msg
    >>> decode_cdr(parse_ros2msg("a/B", "uint8 x\nint16 y"), bytes([0, 1, 0, 0, 7, 0, 1, 1]))
    {'x': 7, 'y': 257}
    """
    return _Decoder(definition, data).message(definition.root)


class _Decoder:
    def __init__(self, definition: Definition, data: memoryview | bytes) -> None:
        self._order, self._most = representation(data)
        self._definition = definition
        self._data = data
        self._at = HEADER_BYTES

    def message(self, name: str) -> dict[str, Any]:
        return {
            part.name: self._value(part.type, part.length)
            for part in self._definition.messages[name]
        }

    def _value(self, kind: str, length: int | None) -> Any:  # noqa: ANN401  a value of any type
        if length is None:
            return self._one(kind)
        if length < 0:
            length = int(self._numbers("u4", 1)[0])
        if kind in PRIMITIVES:
            return list(self._numbers(PRIMITIVES[kind], length)) if length else []
        if length > len(self._data) - self._at:
            raise BrokenMessageError(f"{length} elements are announced, more than it has bytes")
        return [self._one(kind) for _ in range(length)]

    def _one(self, kind: str) -> Any:  # noqa: ANN401  a value of any type
        if kind in PRIMITIVES:
            return self._numbers(PRIMITIVES[kind], 1)[0]
        if kind == STRING:
            size = int(self._numbers("u4", 1)[0])
            text = self._take(size)
            return bytes(text).rstrip(b"\x00").decode("utf-8", errors="replace")
        return self.message(kind)

    def _numbers(self, code: str, count: int) -> tuple[Any, ...]:
        size = int(code[1])
        self._at += -(self._at - HEADER_BYTES) % min(size, self._most)
        part = self._take(size * count)
        return struct.unpack(f"{self._order}{count}{_CODES[code]}", part)

    def _take(self, size: int) -> memoryview | bytes:
        if size > len(self._data) - self._at:
            raise BrokenMessageError(
                f"{size} bytes are announced where {max(len(self._data) - self._at, 0)} are left"
            )
        part = self._data[self._at : self._at + size]
        self._at += size
        return part
