"""A chunk of an MCAP file: its bytes unpacked, and where in them the messages are.

The message index says it at once; it is believed only if together with the other records it covers
the chunk without a rest. Without an index the records are walked one by one.
"""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import reason
from pipeline.ingest import mcap_records as mcap
from pipeline.types import IntArray

Bytes = npt.NDArray[np.uint8]
#: From the start of a message's record to its data.
MESSAGE_START = mcap.RECORD_HEAD.size + mcap.MESSAGE_HEAD.size
_TIME_AT = mcap.RECORD_HEAD.size + 6


class BrokenChunkError(ValueError):
    """A chunk cannot be unpacked; the text says why."""


@dataclass(frozen=True)
class Messages:
    """Messages of one channel (k,) in the order of the file, and where their data stand."""

    log_time_ns: IntArray
    start: IntArray
    size: IntArray


@dataclass(frozen=True)
class ChunkBlock:
    """Unpacked records: `data` their bytes, `messages` those of each channel (id) in it."""

    data: Bytes
    messages: Mapping[int, Messages]
    fault: str = ""
    """What stopped the reading inside of the block, if anything did."""


def unpack(head: mcap.ChunkHead, packed: bytes, *, cut: bool = False) -> bytes:
    """Decompress the records of a chunk, or as many bytes of them as there are.

    Where the file is `cut` inside of it, it is unpacked as far as it goes, without the checksum.
    Raises `BrokenChunkError`.
    """
    if head.uncompressed_size > mcap.MAX_CHUNK_BYTES:
        raise BrokenChunkError(
            f"it is said to hold {head.uncompressed_size} bytes; "
            f"at most {mcap.MAX_CHUNK_BYTES} are read"
        )
    if head.compression not in ("", "zstd", "lz4"):
        raise BrokenChunkError(f'its compression "{head.compression}" is not known')
    parts: list[bytes] = []
    left = head.uncompressed_size + 1  # no more, whatever the frames announce
    try:
        stream = _opened(head.compression, packed)
        while left > 0 and (part := stream.read1(min(left, 1 << 22))):
            parts.append(part)  # those before an error stay
            left -= len(part)
    except Exception as error:  # noqa: BLE001 - each library has its own
        if not cut:
            raise BrokenChunkError(f"it cannot be decompressed ({reason(error)})") from None
    data = b"".join(parts)
    if cut:
        return data
    if len(data) != head.uncompressed_size:
        raise BrokenChunkError(
            f"it holds {len(data)} bytes where {head.uncompressed_size} are stated"
        )
    if head.checksum and zlib.crc32(data) != head.checksum:
        raise BrokenChunkError("its checksum is wrong: the file was damaged after it was written")
    return data


def _opened(compression: str, packed: bytes) -> Any:  # noqa: ANN401  readers of several libraries
    """Open packed bytes as a stream of what they hold."""
    if compression == "zstd":
        import zstandard

        decompressor = zstandard.ZstdDecompressor(max_window_size=1 << 27)
        return decompressor.stream_reader(packed, read_across_frames=True)
    if compression == "lz4":
        import lz4.frame  # type: ignore[import-untyped]  # lz4 has no annotations

        return lz4.frame.LZ4FrameFile(BytesIO(packed))
    return BytesIO(packed)


def block_by_index(
    data: bytes, offsets: Mapping[int, IntArray], directory: mcap.Directory
) -> ChunkBlock | None:
    """Find the messages of a chunk by its index: channel -> offsets of the messages' records (k,).

    Notes schemas and channels in the directory. None where index and records do not agree.
    """
    buffer = np.frombuffer(data, np.uint8)
    messages: dict[int, Messages] = {}
    begins, ends = [], []
    for channel, at in offsets.items():
        begin = np.sort(at)
        if not begin.size:
            continue
        if begin[0] < 0 or begin[-1] > buffer.size - MESSAGE_START:
            return None
        length = _gather(buffer, "<u8", begin + 1)
        size = length.astype(np.int64) - mcap.MESSAGE_HEAD.size
        agrees = (
            (buffer[begin] == mcap.MESSAGE)
            & (_gather(buffer, "<u2", begin + mcap.RECORD_HEAD.size) == channel)
            & (size >= 0)
            & (begin + MESSAGE_START <= buffer.size - size)
        )
        if not agrees.all():
            return None
        messages[channel] = Messages(
            _gather(buffer, "<u8", begin + _TIME_AT).astype(np.int64), begin + MESSAGE_START, size
        )
        begins.append(begin)
        ends.append(begin + MESSAGE_START + size)
    rest = _between(buffer.size, begins, ends)
    if rest is None:
        return None
    parts = (walk(data[begin:end], directory) for begin, end in rest)
    if any(part.messages or part.fault for part in parts):
        return None
    return ChunkBlock(buffer, messages)


def _between(
    size: int, begins: list[IntArray], ends: list[IntArray]
) -> list[tuple[int, int]] | None:
    """Ranges that no message covers; None where messages overlap."""
    begin = np.concatenate([*begins, np.array([size])])
    end = np.concatenate([*ends, np.array([size])])
    order = np.argsort(begin, kind="stable")
    begin, end = begin[order], end[order]
    before = np.concatenate([np.zeros(1, np.int64), end[:-1]])
    if (before > begin).any():
        return None
    return [(int(before[i]), int(begin[i])) for i in np.flatnonzero(before < begin)]


def _gather(buffer: Bytes, kind: str, at: IntArray) -> npt.NDArray[np.generic]:
    return at_every_byte(buffer, np.dtype(kind))[at]


def at_every_byte(buffer: Bytes, kind: np.dtype[np.generic]) -> npt.NDArray[np.generic]:
    """View a buffer as numbers that start at each of its bytes; indexing then gathers them.

    >>> at_every_byte(np.array([0, 1, 0, 2], np.uint8), np.dtype("<u2"))[[1, 2]].tolist()
    [1, 512]
    """
    count = max(buffer.size - kind.itemsize + 1, 0)
    return np.ndarray((count,), kind, buffer=buffer, strides=(1,))


def walk(data: bytes, directory: mcap.Directory) -> ChunkBlock:
    """Find the messages of unpacked records by walking them, up to a `fault`.

    Notes schemas and channels in the directory.
    """
    found: dict[int, list[tuple[int, int, int]]] = {}
    view, fault, message_head = memoryview(data), "", mcap.MESSAGE_HEAD.unpack_from
    try:
        for opcode, begin, end in mcap.records_in(data):
            if opcode == mcap.MESSAGE:
                start = begin + mcap.MESSAGE_HEAD.size
                if start > end:
                    raise mcap.BrokenRecordError(f"a message has {end - begin} bytes")  # noqa: TRY301
                channel, _, time_ns, _ = message_head(data, begin)
                found.setdefault(channel, []).append((time_ns, start, end - start))
            elif opcode in (mcap.SCHEMA, mcap.CHANNEL):
                directory.note(opcode, view[begin:end])
    except mcap.BrokenRecordError as error:
        fault = str(error)
    messages = {}
    for channel, rows in found.items():
        # times beyond 2^63 ns are no times; they become negative ones, which is noticed
        table = np.array(rows, dtype=np.uint64).astype(np.int64)
        messages[channel] = Messages(table[:, 0], table[:, 1], table[:, 2])
    return ChunkBlock(np.frombuffer(data, np.uint8), messages, fault)
