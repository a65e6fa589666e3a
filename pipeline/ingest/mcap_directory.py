"""What an MCAP file holds, as its summary or its records tell it, and what is wrong with it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.errors import InputError, Place
from pipeline.ingest import mcap_records as mcap
from pipeline.ingest.mcap_chunk import ChunkBlock

#: A message takes more than this share of a byte, however well it is compressed.
_MOST_MESSAGES_A_BYTE = 50
_MOST_CHANNELS = 20_000
#: A header and a footer at least.
SMALLEST_FILE = 2 * len(mcap.MAGIC) + mcap.RECORD_HEAD.size + 8
_KNOWN_STARTS = (
    (b"#ROSBAG V", "a ROS 1 bag", "Name it *.bag: then it is read as one."),
    (b"SQLite format 3", "a ROS 2 bag in SQLite", "Name it *.db3: then it is read as one."),
    (b"ULog", "a log of PX4", "Name it *.ulg: then it is read as one."),
    (b"version https://git-lfs", "a pointer of Git LFS", "Fetch the log: git lfs pull"),
    (b"PK\x03\x04", "a ZIP archive or a workbook", "Unpack it."),
    (b"\x1f\x8b", "gzip", "Unpack it."),
    (b"\x28\xb5\x2f\xfd", "compressed as a whole with zstd", "Unpack it: zstd -d FILE"),
    (b"\xa3\x95", "an ArduPilot data-flash log", "Name it *.BIN: then it is read as one."),
)  # fmt: skip


@dataclass
class Directory:
    """What a file holds: schemas and channels by id, counts, metadata by name."""

    profile: str = ""
    library: str = ""
    schemas: dict[int, mcap.SchemaRecord] = field(default_factory=dict)
    channels: dict[int, mcap.ChannelRecord] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    metadata: dict[str, Mapping[str, str]] = field(default_factory=dict)
    statistics: mcap.StatisticsRecord | None = None
    in_chunks: set[int] = field(default_factory=set)
    """Channels of which the summary says that a chunk holds messages."""
    complete: bool = False
    """The file has its footer: the writer closed it."""
    indexed: bool = False
    """The summary lists the channels."""

    def note(self, opcode: int, content: memoryview) -> None:
        """Take a record in that is neither a chunk nor a message; raises `BrokenRecordError`."""
        record = mcap.parse(opcode, content)
        if opcode == mcap.HEADER:
            self.profile, self.library = record.profile, record.library
        elif opcode == mcap.METADATA:
            self.metadata[record.name] = record.metadata
        elif opcode == mcap.SCHEMA:
            self.schemas.setdefault(record.id, record)
        elif opcode == mcap.CHANNEL:
            if len(self.channels) >= _MOST_CHANNELS:
                raise mcap.BrokenRecordError(f"there are more than {_MOST_CHANNELS} channels")
            self.channels.setdefault(record.id, record)
        elif opcode == mcap.STATISTICS:
            self.statistics = record
        else:
            self.in_chunks |= set(record.message_index_offsets)

    def take_in(self, block: ChunkBlock) -> ChunkBlock:
        """Add the schemas and channels of a block, and return the block."""
        for schema in block.schemas:
            self.schemas.setdefault(schema.id, schema)
        for channel in block.channels:
            if len(self.channels) < _MOST_CHANNELS:
                self.channels.setdefault(channel.id, channel)
        return block

    def take_summary(self, summary: memoryview, file_size: int) -> bool:
        """Take schemas, channels and counts from a summary; say whether it can be relied on."""
        at = 0
        try:
            while at + mcap.RECORD_HEAD.size <= len(summary):
                opcode, length = mcap.RECORD_HEAD.unpack_from(summary, at)
                begin, at = at + mcap.RECORD_HEAD.size, at + mcap.RECORD_HEAD.size + length
                if at > len(summary):
                    return False
                if opcode in mcap.OF_SUMMARY:
                    self.note(opcode, summary[begin:at])
        except mcap.BrokenRecordError:
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


def check_start(start: bytes, size: int, place: Place) -> None:
    """Check the first bytes of a file of `size` bytes; raises `InputError` if it is no log."""
    remedy = "Copy the log from the vehicle again."
    expected = "an MCAP file, which begins with 89 4D 43 41 50 30 0D 0A."
    if size == 0:
        raise InputError.at(place, "the file is empty.", expected=expected, remedy=remedy)
    if not start.startswith(mcap.MAGIC):
        what = f"this is not MCAP: {size} bytes that begin with {start[:8].hex(' ')}."
        for known, name, what_to_do in _KNOWN_STARTS:
            if start.startswith(known):
                what, remedy = f"this is {name}, not MCAP.", what_to_do
        raise InputError.at(place, what, expected=expected, remedy=remedy)
    if size < SMALLEST_FILE:
        raise InputError.at(
            place,
            f"the log ends after {size} bytes, before anything was written to it.",
            expected="a header and messages.",
            remedy=remedy,
        )
