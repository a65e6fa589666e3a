"""An MCAP file on disk: what is in it, and its messages block by block in bounded memory.

The file is read forwards, chunk after chunk, so that one that was cut off or has no index is read
as far as it goes. The summary at its end, where there is one, saves a first pass that collects
the topics; the message index saves walking the records of a chunk and unpacking those that hold
nothing wanted.
"""

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pipeline.errors import InputError, Place, Problem
from pipeline.ingest.mcap_chunk import Block, BrokenChunkError, block_by_index, unpack, walk
from pipeline.ingest.mcap_records import (
    CHANNEL,
    CHUNK,
    DATA_END,
    FOOTER,
    HEADER,
    MAGIC,
    MAX_CHUNK_BYTES,
    MAX_METADATA_BYTES,
    MAX_SCHEMA_BYTES,
    MESSAGE,
    MESSAGE_INDEX,
    METADATA,
    MOST_OF_CHUNK_HEAD,
    RECORD_HEAD,
    SCHEMA,
    STATISTICS,
    BrokenRecordError,
    ChannelRecord,
    ChunkHead,
    SchemaRecord,
    StatisticsRecord,
    parse_channel,
    parse_chunk_head,
    parse_footer,
    parse_header,
    parse_metadata,
    parse_schema,
    parse_statistics,
)
from pipeline.types import IntArray

_FOOTER_BYTES = RECORD_HEAD.size + 20 + len(MAGIC)
_MAX_SUMMARY_BYTES = 64 * 1024 * 1024
_MAX_INDEX_BYTES = 64 * 1024 * 1024
_MOST_CHANNELS = 20_000
#: Messages outside of chunks are put together to blocks of about this size.
_LOOSE_BYTES = 4 * 1024 * 1024
_SMALLEST = 2 * len(MAGIC) + RECORD_HEAD.size + 8
_INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])
_KNOWN_STARTS = (
    (b"#ROSBAG V", "a ROS 1 bag", "Convert it: rosbags-convert --src FILE.bag --dst FOLDER "
     "--dst-storage mcap"),
    (b"SQLite format 3", "a ROS 2 bag in SQLite", "Convert it: ros2 bag convert with storage mcap."),
    (b"version https://git-lfs", "a pointer of Git LFS, not the log", "Fetch the log: git lfs pull"),
    (b"PK\x03\x04", "a ZIP archive or a workbook", "Unpack it."),
    (b"\x1f\x8b", "gzip", "Unpack it."),
    (b"\x28\xb5\x2f\xfd", "compressed as a whole with zstd", "Unpack it: zstd -d FILE"),
    (b"\xa3\x95", "an ArduPilot data-flash log", "Record the topics as MCAP."),
)  # fmt: skip


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
    complete: bool = False
    """The file has its footer: the writer closed it."""
    indexed: bool = False
    """The summary lists the channels."""


class McapFile:
    """A log on disk. `problems` collects what is wrong while it is read."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Look at both ends of the file.

        Parameters
        ----------
        path : Path
            The file.
        shown_as : str
            Its name in messages.

        Raises
        ------
        InputError
            If it cannot be opened or is no MCAP file.
        """
        self.path = path
        self.place = Place(shown_as)
        self.problems: list[Problem] = []
        self.directory = Directory()
        self.size = 0
        self.read_bytes = 0
        """How far the last pass got."""
        self._end = 0
        self._faults: set[str] = set()
        with self._open() as stream:
            self.size = stream.seek(0, io.SEEK_END)
            stream.seek(0)
            self._check_start(stream.read(max(_SMALLEST, 64)))
            self._read_summary(stream)
        if not self.directory.indexed:
            self._scan()

    def blocks(self, wanted: frozenset[int]) -> Iterator[Block]:
        """Yield the messages of some channels in the order of the file.

        Parameters
        ----------
        wanted : frozenset of int
            Ids of channels; chunks whose index names none of them are passed over.

        Yields
        ------
        Block
            May hold messages of other channels, too.
        """
        with self._open() as stream:
            yield from self._blocks(stream, wanted)

    # ------------------------------------------------------------------ opening

    def _open(self) -> BinaryIO:
        try:
            return self.path.open("rb")
        except OSError as error:
            raise InputError.at(
                self.place,
                f"the log cannot be read: {error.strerror or error}.",
                expected="an MCAP file.",
                remedy="Check the path and its permissions.",
            ) from None

    def _check_start(self, start: bytes) -> None:
        remedy = "Copy the log from the vehicle again."
        expected = "an MCAP file, which begins with 89 4D 43 41 50 30 0D 0A."
        if self.size == 0:
            raise InputError.at(self.place, "the file is empty.", expected=expected, remedy=remedy)
        if not start.startswith(MAGIC):
            for known, name, what_to_do in _KNOWN_STARTS:
                if start.startswith(known):
                    what, remedy = f"this is {name}, not MCAP.", what_to_do
                    break
            else:
                what = f"this is not MCAP: {self.size} bytes that begin with {start[:8].hex(' ')}."
            raise InputError.at(self.place, what, expected=expected, remedy=remedy)
        if self.size < _SMALLEST:
            raise InputError.at(
                self.place,
                f"the log ends after {self.size} bytes, before anything was written to it.",
                expected="a header and messages.",
                remedy=remedy,
            )

    def _read_summary(self, stream: BinaryIO) -> None:
        """Take topics and counts from the summary; leave `indexed` False where that fails."""
        found = self.directory
        self._end = self.size
        stream.seek(-_FOOTER_BYTES, io.SEEK_END)
        tail = stream.read(_FOOTER_BYTES)
        if not tail.endswith(MAGIC) or tail[0] != FOOTER:
            return
        found.complete = True
        start, _, _ = parse_footer(memoryview(tail)[RECORD_HEAD.size : -len(MAGIC)])
        end = self.size - _FOOTER_BYTES
        self._end = end
        if start == 0 or start >= end or end - start > _MAX_SUMMARY_BYTES:
            return
        stream.seek(start)
        summary = memoryview(stream.read(end - start))
        at = 0
        while at + RECORD_HEAD.size <= len(summary):
            opcode, length = RECORD_HEAD.unpack_from(summary, at)
            begin, at = at + RECORD_HEAD.size, at + RECORD_HEAD.size + length
            if at > len(summary):
                return
            try:
                self._note(opcode, summary[begin:at])
            except BrokenRecordError:
                return
        stated = found.statistics
        if stated is None or not found.channels:
            return
        if set(stated.channel_message_counts) - set(found.channels):
            return
        if sum(stated.channel_message_counts.values()) != stated.message_count:
            return
        if stated.message_count * RECORD_HEAD.size > self.size * 2000:
            return
        found.counts = dict(stated.channel_message_counts)
        found.indexed = True
        self._end = start

    def _note(self, opcode: int, content: memoryview) -> None:
        """Take a record of the directory in."""
        found = self.directory
        if opcode == SCHEMA:
            schema = parse_schema(content)
            found.schemas.setdefault(schema.id, schema)
        elif opcode == CHANNEL:
            channel = parse_channel(content)
            if len(found.channels) >= _MOST_CHANNELS:
                raise BrokenRecordError(f"there are more than {_MOST_CHANNELS} channels")
            found.channels.setdefault(channel.id, channel)
        elif opcode == STATISTICS:
            found.statistics = parse_statistics(content)

    def _scan(self) -> None:
        """Collect topics and counts by reading everything once."""
        found = self.directory
        found.counts = {}
        counts: dict[int, int] = {}
        with self._open() as stream:
            for block in self._blocks(stream, None):
                for channel, messages in block.messages.items():
                    counts[channel] = counts.get(channel, 0) + messages.size.size
        found.counts = {number: counts.get(number, 0) for number in found.channels}
        lost = sum(count for number, count in counts.items() if number not in found.channels)
        if lost:
            self._fault(
                f"{lost} messages belong to topics that are not described before them; left out."
            )

    # ------------------------------------------------------------------ reading

    def _blocks(self, stream: BinaryIO, wanted: frozenset[int] | None) -> Iterator[Block]:
        """Walk the top level of the file; `wanted` None takes everything."""
        stream.seek(len(MAGIC))
        at = len(MAGIC)
        loose = bytearray()
        while at < self._end:
            head = stream.read(RECORD_HEAD.size)
            if len(head) < RECORD_HEAD.size:
                self._cut(at, "")
                break
            opcode, length = RECORD_HEAD.unpack(head)
            begin, after = at + RECORD_HEAD.size, at + RECORD_HEAD.size + length
            is_cut = after > self._end
            if opcode == CHUNK:
                if loose:
                    yield from self._loose(loose)
                block, after = self._chunk(stream, begin, length, wanted, is_cut=is_cut)
                if block is not None:
                    yield block
            elif is_cut:
                self._cut(at, "" if opcode <= DATA_END else f"(there is no record {opcode:#x}) ")
                break
            elif opcode == MESSAGE:
                if length > MAX_CHUNK_BYTES:
                    self._fault(f"a message of {length} bytes at byte {at} is passed over.")
                else:
                    loose += head + stream.read(length)
                if len(loose) >= _LOOSE_BYTES:
                    yield from self._loose(loose)
            elif opcode in (DATA_END, FOOTER):
                at = after
                break
            else:
                self._small(stream, opcode, length, at)
            at = after
            self.read_bytes = min(at, self.size)
            stream.seek(at)
        if loose:
            yield from self._loose(loose)
        if not self.directory.complete and not self._faults:
            self._cut(at, "")

    def _small(self, stream: BinaryIO, opcode: int, length: int, at: int) -> None:
        """Take a record in that is neither a chunk nor a message; large ones are passed over."""
        most = max(MAX_SCHEMA_BYTES, MAX_METADATA_BYTES) + 100_000
        if opcode not in (HEADER, SCHEMA, CHANNEL, METADATA):
            return
        if length > most:
            self._fault(f"a record of {length} bytes at byte {at} is passed over.")
            return
        content = memoryview(stream.read(length))
        try:
            if opcode == HEADER:
                self.directory.profile, self.directory.library = parse_header(content)
            elif opcode == METADATA:
                name, entries = parse_metadata(content)
                self.directory.metadata[name] = entries
            else:
                self._note(opcode, content)
        except BrokenRecordError as error:
            self._fault(f"a record at byte {at} is broken: {error}.")

    def _loose(self, loose: bytearray) -> Iterator[Block]:
        """Yield messages that stand outside of chunks."""
        data = bytes(loose)
        loose.clear()
        yield self._taken_in(walk(data))

    def _chunk(
        self,
        stream: BinaryIO,
        begin: int,
        length: int,
        wanted: frozenset[int] | None,
        *,
        is_cut: bool,
    ) -> tuple[Block | None, int]:
        """Read a chunk; return its messages and the place after its message index."""
        after = begin + length
        where = f"the chunk at byte {begin - RECORD_HEAD.size}"
        try:
            head = parse_chunk_head(memoryview(stream.read(min(length, MOST_OF_CHUNK_HEAD))))
        except BrokenRecordError as error:
            if is_cut:
                self._cut(begin, "")
            else:
                self._fault(f"{where} is broken ({error}); its messages were left out.")
            return None, after
        if head.length + head.size > length or head.size > MAX_CHUNK_BYTES:
            self._fault(
                f"{where} holds {head.size} packed bytes in {length}; its messages were left out."
            )
            return None, after
        if is_cut:
            return self._cut_chunk(stream, begin, head), after
        stream.seek(after)
        index, after = self._message_index(stream, after)
        known = self.directory.channels
        if (
            index
            and wanted is not None
            and not any(number in wanted or number not in known for number in index)
        ):
            return None, after
        stream.seek(begin + head.length)
        try:
            data = unpack(head, stream.read(head.size))
        except BrokenChunkError as error:
            seconds = (head.end_time_ns - head.start_time_ns) / 1e9
            self._fault(
                f"{where}, {seconds:.1f} s of the run, is damaged: {error}; its messages were left "
                "out."
            )
            return None, after
        block = block_by_index(data, index) if index else None
        if block is None:
            if index:
                self._fault(
                    f"the message index of {where} does not agree with it; its records were walked."
                )
            block = walk(data)
        if block.fault:
            self._fault(f"in {where} {block.fault}; what follows in it was left out.")
        return self._taken_in(block), after

    def _cut_chunk(self, stream: BinaryIO, begin: int, head: ChunkHead) -> Block | None:
        """Rescue what the file still holds of its last chunk."""
        stream.seek(begin + head.length)
        packed = stream.read(max(self._end - begin - head.length, 0))
        try:
            block = walk(unpack(head, packed, cut=True))
        except BrokenChunkError:
            block = None
        rescued = 0 if block is None else sum(part.size.size for part in block.messages.values())
        self._cut(begin, f"in the middle of a chunk, of which {rescued} messages were rescued, ")
        return None if block is None else self._taken_in(block)

    def _message_index(self, stream: BinaryIO, at: int) -> tuple[dict[int, IntArray], int]:
        """Read the message index that follows a chunk; return it and the place after it."""
        index: dict[int, IntArray] = {}
        while at + RECORD_HEAD.size <= self._end:
            head = stream.read(RECORD_HEAD.size)
            if len(head) < RECORD_HEAD.size:
                break
            opcode, length = RECORD_HEAD.unpack(head)
            if opcode != MESSAGE_INDEX or at + RECORD_HEAD.size + length > self._end:
                break
            if length > _MAX_INDEX_BYTES or length < 6:
                index = {}
                at += RECORD_HEAD.size + length
                break
            content = stream.read(length)
            number = int.from_bytes(content[:2], "little")
            entries = np.frombuffer(content, _INDEX_ENTRY, (length - 6) // 16, 6)
            offsets = entries["offset"].astype(np.int64)
            if offsets.size:
                index[number] = (
                    np.concatenate([index[number], offsets]) if number in index else offsets
                )
            at += RECORD_HEAD.size + length
        return index, at

    def _taken_in(self, block: Block) -> Block:
        """Add the schemas and channels of a block to the directory."""
        found = self.directory
        for schema in block.schemas:
            found.schemas.setdefault(schema.id, schema)
        for channel in block.channels:
            if len(found.channels) < _MOST_CHANNELS:
                found.channels.setdefault(channel.id, channel)
        return block

    # ------------------------------------------------------------------ faults

    def _cut(self, at: int, how: str) -> None:
        share = 100.0 * at / self.size if self.size else 0.0
        key = "cut"
        if key in self._faults:
            return
        self._faults.add(key)
        self.problems.append(
            Problem(
                "warning",
                self.place,
                f"the log ends {how}at byte {self.size} without its closing record: the recorder "
                f"was stopped hard, or the copy is not complete. Whole records were read up to "
                f"byte {at} ({share:.0f} %).",
                "a file that ends with 89 4D 43 41 50 30 0D 0A.",
                "Copy it again; if it is no longer elsewhere, mcap recover FILE makes an index.",
            )
        )

    def _fault(self, what: str) -> None:
        """Say a fault once, however many passes meet it."""
        if what not in self._faults:
            self._faults.add(what)
            self.problems.append(Problem("warning", self.place, what))
