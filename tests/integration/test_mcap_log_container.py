"""The log's container, byte by byte: index, order, checksums, and copies that are not whole."""

import struct
import zlib
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import CRCValidationError, StreamReader
from mcap.summary import Summary
from rosbags.highlevel import AnyReader, AnyReaderError
from run_log_cases import DENSITY_KGPM3, GRAVITY_MPS2, make_log, make_truth

from pipeline.export.mcap_log import write_run_log

MESSAGE, CHUNK, MESSAGE_INDEX, DATA_END = 0x05, 0x06, 0x07, 0x0F
MAGIC_BYTES, RECORD_HEADER, DATA_END_BYTES, FOOTER_BYTES = 8, 9, 13, 29


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of several chunks."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    write_run_log(
        path,
        make_log(20.0),
        vehicle_name="plain",
        density_kgpm3=DENSITY_KGPM3,
        gravity_mps2=GRAVITY_MPS2,
        truth=make_truth(20.0),
    )
    return path


def summary_of(path: Path) -> Summary:
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return summary


def chunk_content(content: bytes, begin: int) -> bytes:
    """Uncompressed records of the chunk that begins at a place of the file."""
    assert content[begin] == CHUNK
    _, _, size, checksum, name = struct.unpack_from("<QQQII", content, begin + RECORD_HEADER)
    at = begin + RECORD_HEADER + 32
    assert content[at : at + name] == b"zstd"
    (length,) = struct.unpack_from("<Q", content, at + name)
    raw = zstandard.decompress(content[at + name + 8 : at + name + 8 + length])
    assert len(raw) == size
    assert zlib.crc32(raw) == checksum
    return raw


def index_entries(content: bytes, begin: int) -> Iterator[tuple[int, int]]:
    """Time and offset of each entry of the message index at a place of the file."""
    assert content[begin] == MESSAGE_INDEX
    _, length = struct.unpack_from("<HI", content, begin + RECORD_HEADER)
    first = begin + RECORD_HEADER + 6
    return struct.iter_unpack("<QQ", content[first : first + length])


def test_message_index_points_at_every_message(path: Path) -> None:
    """Each entry leads to a message of its channel and time; none is missing."""
    content, summary = path.read_bytes(), summary_of(path)
    assert len(summary.chunk_indexes) > 1
    found = 0
    for index in summary.chunk_indexes:
        raw = chunk_content(content, index.chunk_start_offset)
        for channel_id, place in index.message_index_offsets.items():
            for time_ns, offset in index_entries(content, place):
                channel, _, logged = struct.unpack_from("<HIQ", raw, offset + RECORD_HEADER)
                assert (raw[offset], channel, logged) == (MESSAGE, channel_id, time_ns)
                found += 1
    assert summary.statistics is not None
    assert found == summary.statistics.message_count


def test_messages_of_a_topic_have_one_size(path: Path) -> None:
    """So a reader may gather them as a matrix."""
    sizes: dict[int, set[int]] = defaultdict(set)
    for message in messages_of(path):
        sizes[message.channel_id].add(len(message.data))
    assert len(sizes) == 9
    assert all(len(of_channel) == 1 for of_channel in sizes.values())


def test_messages_lie_in_the_order_of_arrival(path: Path) -> None:
    messages = messages_of(path)
    arrival = [message.log_time for message in messages]
    assert arrival == sorted(arrival)
    numbers: dict[int, list[int]] = defaultdict(list)
    for message in messages:
        numbers[message.channel_id].append(message.sequence)
    assert all(one == list(range(len(one))) for one in numbers.values())


def messages_of(path: Path) -> list[Message]:
    with path.open("rb") as stream:
        records = StreamReader(stream, validate_crcs=True).records
        return [record for record in records if isinstance(record, Message)]


def test_a_truncated_copy_is_detected(path: Path, tmp_path: Path) -> None:
    """No reader takes a part for the whole; what it raises is its own affair."""
    content = path.read_bytes()
    size = len(content)
    lengths = {0, 1, 7, 8, 9, 40, size - 1, size - 8, size - 9, size - 37, size - 38}
    lengths |= set(np.linspace(9, size - 10, 30).astype(int).tolist())
    copy = tmp_path / "copy.mcap"
    for length in sorted(lengths):
        copy.write_bytes(content[:length])
        with copy.open("rb") as stream, pytest.raises((McapError, struct.error, OSError)):
            make_reader(stream).get_summary()
        with pytest.raises((AnyReaderError, TypeError)), AnyReader([copy]) as reader:
            list(reader.messages())


def test_a_changed_bit_is_detected(path: Path, tmp_path: Path) -> None:
    """Anywhere between the first byte and the end of the data, by the data section's checksum."""
    content = path.read_bytes()
    stated, computed = data_section_checksums(content)
    assert stated == computed != 0
    end = data_section_end(content)
    for place in np.linspace(MAGIC_BYTES, end - 1, 60).astype(int).tolist():
        changed = bytearray(content)
        changed[place] ^= 0x10
        stated, computed = data_section_checksums(bytes(changed))
        assert stated != computed
    # and a reader that is not ours looks at it: a bit of the last message index, outside all chunks
    changed = bytearray(content)
    changed[end - 1] ^= 0x10
    copy = tmp_path / "changed.mcap"
    copy.write_bytes(changed)
    with pytest.raises(CRCValidationError, match="DataEnd"):
        messages_of(copy)


def data_section_end(content: bytes) -> int:
    """Place of the record that ends the data section; the summary follows it."""
    (summary,) = struct.unpack_from("<Q", content, len(content) - MAGIC_BYTES - FOOTER_BYTES + 9)
    return int(summary) - DATA_END_BYTES


def data_section_checksums(content: bytes) -> tuple[int, int]:
    """Checksum that the file states of its data section, and the one that it has."""
    end = data_section_end(content)
    assert content[end] == DATA_END
    (stated,) = struct.unpack_from("<I", content, end + RECORD_HEADER)
    return stated, zlib.crc32(content[:end])
