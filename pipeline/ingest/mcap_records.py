"""The records of an MCAP file, parsed one by one from bytes that nobody vouches for.

A record is an opcode (1 byte), a length (8 bytes, little endian) and that many bytes of content.
Every length is checked against what is there before it is used.

References
----------
MCAP specification, version 0, https://mcap.dev/spec.
"""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = range(1, 8)
CHUNK_INDEX, ATTACHMENT, STATISTICS, METADATA, DATA_END = 0x08, 0x09, 0x0B, 0x0C, 0x0F
RECORD_HEAD = struct.Struct("<BQ")
#: Content of a message before its data: channel, sequence, log time, publish time.
MESSAGE_HEAD = struct.Struct("<HIQQ")
#: Of a footer: start of the summary, start of the summary's offsets, checksum.
_FOOTER = struct.Struct("<QQI")
#: Of the end of a file: its last record and the magic.
FOOTER_BYTES = RECORD_HEAD.size + _FOOTER.size + len(MAGIC)
#: A time before 2000 is of a clock that nobody set, one after 2100 is none. [ns since 1970]
SET_NS, LATEST_NS = 946_684_800_000_000_000, 4_102_444_800_000_000_000
_CHUNK_HEAD = struct.Struct("<QQQI")
_STATISTICS_HEAD = struct.Struct("<QHIIIIQQ")
#: Limits on what one record may hold; logs stay far below them.
MAX_SCHEMA_BYTES = 1_000_000
MAX_TEXT_BYTES = 10_000
MAX_METADATA_BYTES = 1_000_000
MAX_CHUNK_BYTES = 256 * 1024 * 1024
#: All chunks may unpack to `MAX_UNPACKED_BYTES` and `MAX_RATIO` times the size of the file.
MAX_RATIO = 200
MAX_UNPACKED_BYTES = 64 * 1024 * 1024


class BrokenRecordError(ValueError):
    """The content of a record is not what its opcode promises; the text says how."""


@dataclass(frozen=True)
class SchemaRecord:
    """Definition of a kind of message."""

    id: int
    name: str
    encoding: str
    data: bytes


@dataclass(frozen=True)
class ChannelRecord:
    """A topic with the encoding of its messages."""

    id: int
    schema_id: int
    topic: str
    message_encoding: str
    metadata: Mapping[str, str]


@dataclass(frozen=True)
class ChunkHead:
    """What precedes the (compressed) records of a chunk; `size` is that of the compressed ones."""

    start_time_ns: int
    end_time_ns: int
    uncompressed_size: int
    checksum: int
    compression: str
    size: int
    length: int
    """Of the head itself, in bytes."""


@dataclass(frozen=True)
class StatisticsRecord:
    """Counts of messages that the writer made, and the log times of the first and the last."""

    message_count: int
    start_time_ns: int
    end_time_ns: int
    channel_message_counts: Mapping[int, int]


class _Cursor:
    """Reads a record's fields in order; refuses to read beyond its end."""

    def __init__(self, data: memoryview) -> None:
        self._data = data
        self.at = 0

    def raw(self, size: int) -> memoryview:
        if size < 0 or self.at + size > len(self._data):
            raise BrokenRecordError(
                f"{size} bytes are announced where {len(self._data) - self.at} are left"
            )
        part = self._data[self.at : self.at + size]
        self.at += size
        return part

    def number(self, size: int) -> int:
        return int.from_bytes(self.raw(size), "little")

    def sized(self, most: int, refused: Callable[[int], str]) -> bytes:
        """Return bytes behind their number; `refused` says that there are too many."""
        size = self.number(4)
        if size > most:
            raise BrokenRecordError(refused(size))
        return bytes(self.raw(size))

    def text(self) -> str:
        content = self.sized(
            MAX_TEXT_BYTES, lambda n: f"a text of {n} bytes; at most {MAX_TEXT_BYTES} are read"
        )
        return content.decode("utf-8", errors="replace")

    def texts(self) -> dict[str, str]:
        """Return a map of texts."""
        content = self.sized(
            MAX_METADATA_BYTES,
            lambda n: f"a map of {n} bytes; at most {MAX_METADATA_BYTES} are read",
        )
        inside = _Cursor(memoryview(content))
        found: dict[str, str] = {}
        while inside.at < len(inside._data):
            key = inside.text()
            found[key] = bytes(inside.raw(inside.number(4))).decode("utf-8", errors="replace")
        return found

    def by_channel(self, width: int) -> dict[int, int]:
        """Return a map of channels (ids) to whole numbers of so many bytes."""
        size = self.number(4)
        pairs, step = self.raw(size), 2 + width
        return {
            int.from_bytes(pairs[at : at + 2], "little"): int.from_bytes(
                pairs[at + 2 : at + step], "little"
            )
            for at in range(0, size - step + 1, step)
        }


def parse_schema(content: memoryview) -> SchemaRecord:
    """Parse a schema; raises `BrokenRecordError`."""
    cursor = _Cursor(content)
    number, name, encoding = cursor.number(2), cursor.text(), cursor.text()
    content_of_schema = cursor.sized(
        MAX_SCHEMA_BYTES, lambda n: f"a schema of {n} bytes; at most {MAX_SCHEMA_BYTES} are read"
    )
    return SchemaRecord(number, name, encoding, content_of_schema)


def parse_channel(content: memoryview) -> ChannelRecord:
    """Parse a channel; raises `BrokenRecordError`."""
    cursor = _Cursor(content)
    number, schema = cursor.number(2), cursor.number(2)
    return ChannelRecord(number, schema, cursor.text(), cursor.text(), cursor.texts())


def parse_metadata(content: memoryview) -> tuple[str, dict[str, str]]:
    """Parse a metadata record: its name and its entries; raises `BrokenRecordError`."""
    cursor = _Cursor(content)
    return cursor.text(), cursor.texts()


def parse_header(content: memoryview) -> tuple[str, str]:
    """Parse the header: profile and the library that wrote the file."""
    cursor = _Cursor(content)
    return cursor.text(), cursor.text()


def start_of_summary(tail: bytes) -> int | None:
    """Return what the last bytes of a file say; 0 for no summary, None where it was not closed."""
    if len(tail) < FOOTER_BYTES or not tail.endswith(MAGIC) or tail[0] != FOOTER:
        return None
    return int(_FOOTER.unpack_from(tail, RECORD_HEAD.size)[0])


def parse_statistics(content: memoryview) -> StatisticsRecord:
    """Parse the statistics; raises `BrokenRecordError`."""
    cursor = _Cursor(content)
    head = _STATISTICS_HEAD.unpack(cursor.raw(_STATISTICS_HEAD.size))
    return StatisticsRecord(head[0], head[6], head[7], cursor.by_channel(8))


def parse_indexed_channels(content: memoryview) -> set[int]:
    """Parse the index of a chunk: the channels that it has messages of."""
    cursor = _Cursor(content)
    cursor.raw(4 * 8)  # times and place of the chunk
    return set(cursor.by_channel(8))


#: A chunk's head is at most this long: four numbers, the compression's name, the size.
MOST_OF_CHUNK_HEAD = _CHUNK_HEAD.size + 4 + 64 + 8


def parse_chunk_head(content: memoryview) -> ChunkHead:
    """Parse the head of a chunk from its first bytes; raises `BrokenRecordError`."""
    cursor = _Cursor(content)
    start, end, uncompressed, checksum = _CHUNK_HEAD.unpack(cursor.raw(_CHUNK_HEAD.size))
    compression = cursor.text()
    size = cursor.number(8)
    return ChunkHead(start, end, uncompressed, checksum, compression, size, cursor.at)
