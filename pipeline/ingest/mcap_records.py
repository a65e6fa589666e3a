"""The records of an MCAP file, from bytes that nobody vouches for, and what they say it holds.

A record is an opcode (1 byte), a length (8 bytes, little endian) and that many bytes of content,
which the library of MCAP parses (https://mcap.dev/spec, version 0). Every length is checked against
what is there before it is used.
"""

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

from mcap import records
from mcap.data_stream import ReadDataStream

SchemaRecord = records.Schema
ChannelRecord = records.Channel
StatisticsRecord = records.Statistics
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
#: Limits on what one record may hold; logs stay far below them.
MAX_RECORD_BYTES = 1_000_000
MAX_CHUNK_BYTES = 256 * 1024 * 1024
#: All chunks may unpack to `MAX_UNPACKED_BYTES` and `MAX_RATIO` times the size of the file.
MAX_RATIO = 200
MAX_UNPACKED_BYTES = 64 * 1024 * 1024
#: A message takes more than this share of a byte, however well it is compressed.
_MOST_MESSAGES_A_BYTE = 50
_MOST_CHANNELS = 20_000


class BrokenRecordError(ValueError):
    """The content of a record is not what its opcode promises; the text says how."""


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


class _Whole(ReadDataStream):
    """Reads a record's fields in order; refuses to read beyond its end."""

    def __init__(self, content: memoryview) -> None:
        super().__init__(BytesIO(content))
        self._size = len(content)

    def read(self, length: int) -> bytes:
        left = self._size - self.count
        if length > left:
            raise BrokenRecordError(f"{length} bytes are announced where {left} are left")
        return super().read(length)

    def read_prefixed_string(self) -> str:
        return self.read(self.read4()).decode("utf-8", errors="replace")


#: Records that say what a log holds: in its summary, and before its messages.
OF_SUMMARY = frozenset({SCHEMA, CHANNEL, STATISTICS, CHUNK_INDEX})
OF_START = frozenset({HEADER, SCHEMA, CHANNEL, METADATA})
_PARSERS: Mapping[int, Callable[[ReadDataStream], Any]] = {
    HEADER: records.Header.read,
    SCHEMA: records.Schema.read,
    CHANNEL: records.Channel.read,
    CHUNK_INDEX: records.ChunkIndex.read,
    STATISTICS: records.Statistics.read,
    METADATA: records.Metadata.read,
}


def parse(opcode: int, content: memoryview) -> Any:  # noqa: ANN401  the record of the opcode
    """Parse a record that is neither a chunk nor a message; raises `BrokenRecordError`."""
    if len(content) > MAX_RECORD_BYTES:
        what = f"a record of {len(content)} bytes; at most {MAX_RECORD_BYTES} are read"
        raise BrokenRecordError(what)
    return _PARSERS[opcode](_Whole(content))


def records_in(data: bytes | memoryview) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each record's content; raises `BrokenRecordError` at the end.

    Only where that is in the middle of a record.
    """
    at, size = 0, len(data)
    while at < size:
        if at + RECORD_HEAD.size > size:
            raise BrokenRecordError("the records end in the middle of one")
        opcode, length = RECORD_HEAD.unpack_from(data, at)
        begin, at = at + RECORD_HEAD.size, at + RECORD_HEAD.size + length
        if at > size:
            raise BrokenRecordError("the records end in the middle of one")
        yield opcode, begin, at


def start_of_summary(tail: bytes) -> int | None:
    """Return what the last bytes of a file say; 0 for no summary, None where it was not closed."""
    if len(tail) < FOOTER_BYTES or not tail.endswith(MAGIC) or tail[0] != FOOTER:
        return None
    return int(_FOOTER.unpack_from(tail, RECORD_HEAD.size)[0])


#: A chunk's head is at most this long: four numbers, the compression's name, the size.
MOST_OF_CHUNK_HEAD = 28 + 4 + 64 + 8


def parse_chunk_head(content: memoryview) -> ChunkHead:
    """Parse the head of a chunk from its first bytes; raises `BrokenRecordError`."""
    stream = _Whole(content)
    times = stream.read8(), stream.read8()
    sizes = stream.read8(), stream.read4()
    compression, size = stream.read_prefixed_string(), stream.read8()
    return ChunkHead(*times, *sizes, compression, size, stream.count)


@dataclass
class Directory:
    """What a file holds: schemas and channels by id, counts, metadata by name."""

    profile: str = ""
    library: str = ""
    schemas: dict[int, SchemaRecord] = field(default_factory=dict)
    channels: dict[int, ChannelRecord] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    metadata: dict[str, Mapping[str, str]] = field(default_factory=dict)
    statistics: StatisticsRecord | None = None
    in_chunks: set[int] = field(default_factory=set)
    """Channels of which the summary says that a chunk holds messages."""
    complete: bool = False
    """The file has its footer: the writer closed it."""
    indexed: bool = False
    """The summary lists the channels."""

    def note(self, opcode: int, content: memoryview) -> None:
        """Take a record in that is neither a chunk nor a message; raises `BrokenRecordError`."""
        record = parse(opcode, content)
        if opcode == HEADER:
            self.profile, self.library = record.profile, record.library
        elif opcode == METADATA:
            self.metadata[record.name] = record.metadata
        elif opcode == SCHEMA:
            self.schemas.setdefault(record.id, record)
        elif opcode == CHANNEL:
            if len(self.channels) < _MOST_CHANNELS:
                self.channels.setdefault(record.id, record)
        elif opcode == STATISTICS:
            self.statistics = record
        else:
            self.in_chunks |= set(record.message_index_offsets)

    def take_summary(self, summary: memoryview, file_size: int) -> bool:
        """Take schemas, channels and counts from a summary; say whether it can be relied on."""
        try:
            for opcode, begin, end in records_in(summary):
                if opcode in OF_SUMMARY:
                    self.note(opcode, summary[begin:end])
        except BrokenRecordError:
            return False
        if self.statistics is None or not self.channels:
            return False
        counts = self.statistics.channel_message_counts
        # a topic without a count has no messages, or a writer that forgot it
        silent = {number for number in self.channels if not counts.get(number)}
        forgotten = silent & self.in_chunks if self.in_chunks else silent
        self.indexed = (
            not forgotten
            and set(counts) <= set(self.channels)
            and sum(counts.values()) == self.statistics.message_count
            # arrays are made by these counts: they must be possible in a file of this size
            and self.statistics.message_count <= file_size * _MOST_MESSAGES_A_BYTE
        )
        self.counts = dict(counts) if self.indexed else {}
        return self.indexed
