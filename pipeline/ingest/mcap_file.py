"""An MCAP file on disk: what is in it, and its messages block by block in bounded memory.

It is read forwards, so that one that was cut off or has no index is read as far as it goes. The
summary at its end saves a first pass that collects the topics; the message index saves walking the
records of a chunk and unpacking those that hold nothing wanted.
"""

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pipeline.errors import InputError, Place
from pipeline.ingest import mcap_records as mcap
from pipeline.ingest.log_source import MessageLog
from pipeline.ingest.mcap_chunk import BrokenChunkError, ChunkBlock, block_by_index, unpack, walk
from pipeline.ingest.pool_run_plan import TopicFound
from pipeline.records.run_arrays import RecordedMessage, RecordedTopic
from pipeline.types import IntArray

_MAX_SUMMARY_BYTES = 64 * 1024 * 1024
_MAX_INDEX_BYTES = 64 * 1024 * 1024
#: Messages outside of chunks are put together to blocks of about this size.
_LOOSE_BYTES = 4 * 1024 * 1024
_INDEX_ENTRY = np.dtype([("time", "<u8"), ("offset", "<u8")])
#: A header and a footer at least.
_SMALLEST_FILE = 2 * len(mcap.MAGIC) + mcap.RECORD_HEAD.size + 8
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


class McapFile(MessageLog):
    """A log on disk."""

    def __init__(self, path: Path, shown_as: str) -> None:
        """Look at both ends; raises `InputError` if it cannot be opened or is no MCAP file."""
        super().__init__(path, shown_as)
        self._end = 0
        self._at = 0
        self._unpacked = 0
        self._is_counted = False
        """Whether its messages were counted one by one, not by its summary."""
        with self._open() as stream:
            self.size = stream.seek(0, io.SEEK_END)
            stream.seek(0)
            _check_start(stream.read(64), self.size, self.place)
            self._read_summary(stream)
        if not self.directory.indexed:
            self._scan()

    def topics(self) -> list[TopicFound]:
        """Find its topics with one message each; count them anew where the summary forgot some."""
        found = super().topics()
        if self.directory.counts and not self.directory.indexed and not self._is_counted:
            self._scan()
            found = super().topics()
        return found

    def blocks(self, wanted: frozenset[int]) -> Iterator[ChunkBlock]:
        """Yield the messages of some channels, perhaps with others, in the order of the file."""
        with self._open() as stream:
            yield from self._blocks(stream, wanted)

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

    def _read_summary(self, stream: BinaryIO) -> None:
        """Take topics and counts from the summary; leave `indexed` False where that fails."""
        self._end = self.size
        if self.size < mcap.FOOTER_BYTES:
            return
        stream.seek(-mcap.FOOTER_BYTES, io.SEEK_END)
        start = mcap.start_of_summary(stream.read(mcap.FOOTER_BYTES))
        if start is None:
            return
        self.directory.complete = True
        end = self.size - mcap.FOOTER_BYTES
        self._end = end
        if start == 0 or start >= end or end - start > _MAX_SUMMARY_BYTES:
            return
        stream.seek(start)
        if self.directory.take_summary(memoryview(stream.read(end - start)), self.size):
            self._end = start

    def _scan(self) -> None:
        found, self._is_counted = self.directory, True
        found.counts = {}
        counts: dict[int, int] = {}
        with self._open() as stream:
            for block in self._blocks(stream, None):
                for channel, messages in block.messages.items():
                    counts[channel] = counts.get(channel, 0) + messages.size.size
        found.counts = {number: counts.get(number, 0) for number in found.channels}
        lost = sum(count for number, count in counts.items() if number not in found.channels)
        if lost:
            self.add_fault(
                f"{lost} messages belong to topics that are not described before them; left out."
            )

    def _blocks(self, stream: BinaryIO, wanted: frozenset[int] | None) -> Iterator[ChunkBlock]:
        """Walk the top level of the file; `wanted` None takes everything."""
        self._at = len(mcap.MAGIC)
        self._unpacked = 0
        loose = bytearray()
        for opcode, begin, length in self._records(stream):
            if loose and (opcode != mcap.MESSAGE or len(loose) >= _LOOSE_BYTES):
                yield self._loose(loose)
            if opcode == mcap.CHUNK:
                block = self._chunk(stream, begin, length, wanted)
                if block is not None:
                    yield block
            elif opcode != mcap.MESSAGE:
                self._small(stream, opcode, begin, length)
            elif length <= mcap.MAX_CHUNK_BYTES:
                loose += mcap.RECORD_HEAD.pack(opcode, length) + stream.read(length)
            else:
                self.add_fault(f"a message of {length} bytes at byte {begin} is passed over.")
        if loose:
            yield self._loose(loose)
        whole = self._cut_at
        self.read_bytes = min(self._at, self.size) if whole is None else whole
        if not self.directory.complete:
            self.cut(self.read_bytes)

    def _records(self, stream: BinaryIO) -> Iterator[tuple[int, int, int]]:
        """Yield opcode, place of the content and its length; `_at` is where the next one begins."""
        while self._at < self._end:
            stream.seek(self._at)
            head = stream.read(mcap.RECORD_HEAD.size)
            if len(head) < mcap.RECORD_HEAD.size:
                return
            opcode, length = mcap.RECORD_HEAD.unpack(head)
            begin = self._at + mcap.RECORD_HEAD.size
            if opcode in (mcap.DATA_END, mcap.FOOTER):
                return
            if begin + length > self._end and opcode != mcap.CHUNK:
                how = "" if opcode < 0x80 else f"(no record is {opcode:#x}) "
                self.cut(self._at, how)
                return
            self._at = begin + length
            yield opcode, begin, length

    def _small(self, stream: BinaryIO, opcode: int, begin: int, length: int) -> None:
        """Take a record in that is neither a chunk nor a message; large ones are passed over."""
        if opcode in mcap.OF_START:
            try:
                content = stream.read(min(length, mcap.MAX_RECORD_BYTES + 1))
                self.directory.note(opcode, memoryview(content))
            except mcap.BrokenRecordError as error:
                self.add_fault(f"a record at byte {begin} is passed over: {error}.")

    def _loose(self, loose: bytearray) -> ChunkBlock:
        """Make a block of messages that stand outside of chunks."""
        data = bytes(loose)
        loose.clear()
        return walk(data, self.directory)

    def _chunk(
        self, stream: BinaryIO, begin: int, length: int, wanted: frozenset[int] | None
    ) -> ChunkBlock | None:
        """Read a chunk and its message index; None if nothing in it is wanted or can be read."""
        first = begin - mcap.RECORD_HEAD.size
        where, is_cut = f"the chunk at byte {first}", begin + length > self._end
        try:
            start = stream.read(min(length, mcap.MOST_OF_CHUNK_HEAD))
            head = mcap.parse_chunk_head(memoryview(start))
            where += f", {(head.end_time_ns - head.start_time_ns) / 1e9:.1f} s of the run,"
            self._check(head, length)
            index = {} if is_cut else self._message_index(stream)
            new = index.keys() - self.directory.channels.keys()
            if index and not new and wanted is not None and wanted.isdisjoint(index):
                return None
            stream.seek(begin + head.length)
            packed = stream.read(min(head.size, max(self._end - begin - head.length, 0)))
            data = unpack(head, packed, cut=is_cut)
        except (mcap.BrokenRecordError, BrokenChunkError) as error:
            if is_cut:
                self.cut(first)
            else:
                self.add_fault(f"{where} is damaged: {error}; its messages were left out.")
            return None
        if not is_cut:
            return self._found_in(data, index, where)
        block = walk(data, self.directory)
        parts = list(block.messages.values())
        rescued = sum(part.size.size for part in parts)
        walked = max((int(part.start[-1] + part.size[-1]) for part in parts), default=0)
        whole = begin + head.length + len(packed) * walked // len(data) if rescued else first
        how = f"in the middle of a chunk, of which {rescued} messages were rescued, "
        self.cut(whole, how)
        return block

    def _check(self, head: mcap.ChunkHead, length: int) -> None:
        """Count what a pass unpacks; raises `BrokenChunkError` for a chunk not to be read."""
        if head.length + head.size > length or head.size > mcap.MAX_CHUNK_BYTES:
            raise BrokenChunkError(f"it holds {head.size} packed bytes in {length}")
        size = head.uncompressed_size
        if head.compression and size <= mcap.MAX_CHUNK_BYTES:  # more is refused when it is unpacked
            self._unpacked += size
        if self._unpacked > mcap.MAX_UNPACKED_BYTES + mcap.MAX_RATIO * self.size:
            self._unpacked -= size
            raise BrokenChunkError(
                f"it takes the log to more than {mcap.MAX_RATIO} times its size, unpacked: this "
                "looks like a bomb"
            )

    def _found_in(self, data: bytes, index: Mapping[int, IntArray], where: str) -> ChunkBlock:
        """Find the messages of a chunk by its index, or without where that does not agree."""
        block = block_by_index(data, index, self.directory) if index else None
        if block is None:
            # where the file was cut off, the index of the last chunk may be cut, too
            if index and self.directory.complete:
                what = "its message index does not agree with it; its records were walked."
                self.add_fault(f"{where} is damaged: {what}")
            block = walk(data, self.directory)
        if block.fault:
            what = f"{block.fault}; what follows in it was left out."
            self.add_fault(f"{where} is damaged: {what}")
        known = self.directory
        for number in block.messages.keys() & known.channels.keys() if known.counts else ():
            if not known.counts.get(number):
                topic = known.channels[number].topic
                self.add_fault(f"the log's summary counts no messages of {topic}; there are some.")
                known.indexed = False
        return block

    def _message_index(self, stream: BinaryIO) -> dict[int, IntArray]:
        """Read the message index that follows a chunk, and move behind it."""
        index: dict[int, IntArray] = {}
        while self._at + mcap.RECORD_HEAD.size <= self._end:
            stream.seek(self._at)
            opcode, length = mcap.RECORD_HEAD.unpack(stream.read(mcap.RECORD_HEAD.size))
            if (
                opcode != mcap.MESSAGE_INDEX
                or self._at + mcap.RECORD_HEAD.size + length > self._end
            ):
                break
            self._at += mcap.RECORD_HEAD.size + length
            if length > _MAX_INDEX_BYTES or length < 6:
                return {}
            content = stream.read(length)
            number = int.from_bytes(content[:2], "little")
            entries = np.frombuffer(content, _INDEX_ENTRY, (length - 6) // 16, 6)
            offsets = entries["offset"].astype(np.int64)
            if offsets.size:
                known = index.get(number)
                index[number] = offsets if known is None else np.concatenate([known, offsets])
        return index


def _check_start(start: bytes, size: int, place: Place) -> None:
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
    if size < _SMALLEST_FILE:
        raise InputError.at(
            place,
            f"the log ends after {size} bytes, before anything was written to it.",
            expected="a header and messages.",
            remedy=remedy,
        )


class RecordedFile(McapFile):
    """A log whose messages are copied as bytes, not understood, with the memory of a chunk."""

    @property
    def metadata(self) -> Mapping[str, Mapping[str, str]]:
        """Metadata records by name, as far as the file was read."""
        return self.directory.metadata

    def topic(self, number: int) -> RecordedTopic | None:
        """Topic of a number; None where the log does not describe it."""
        channel = self.directory.channels.get(number)
        if channel is None:
            return None
        schema = self.directory.schemas.get(channel.schema_id)
        own = () if schema is None else (schema.name, schema.encoding, schema.data)
        return RecordedTopic(channel.topic, channel.message_encoding, channel.metadata, *own)

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield all messages in the order of the file; raises `InputError`."""
        for block in self.blocks(frozenset(self.directory.channels)):
            if not block.messages:
                continue
            begin = np.concatenate([part.start for part in block.messages.values()])
            size = np.concatenate([part.size for part in block.messages.values()])
            order = np.argsort(begin, kind="stable")
            content = block.data.tobytes()
            for start, length in zip(begin[order].tolist(), size[order].tolist(), strict=True):
                head = mcap.MESSAGE_HEAD.unpack_from(content, start - mcap.MESSAGE_HEAD.size)
                number, sequence, log_time, publish_time = head
                data = content[start : start + length]
                yield RecordedMessage(number, log_time, publish_time, sequence, data)
