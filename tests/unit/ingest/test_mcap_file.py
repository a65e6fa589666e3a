"""The container: whole, without index, cut off anywhere, damaged anywhere."""

import struct
import tracemalloc
from contextlib import suppress
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType, Writer
from pool_logs import array_topic, json_topic, log_bytes, ros_topic, ticks, write_log

from pipeline.errors import InputError
from pipeline.ingest.mcap_chunk import block_by_index, walk
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_records import CHUNK, MAGIC, RECORD_HEAD, Directory

Messages = dict[str, list[tuple[int, bytes]]]
TOPICS = [
    array_topic("/a", ticks(300, 100.0), [[float(i)] for i in range(300)]),
    # texts of many lengths between the numbers
    ros_topic(
        "/b", "std_msgs/msg/String", ticks(40, 13.0), [{"data": "x" * i} for i in range(40)],
        "string data",
    ),
]  # fmt: skip


def messages_of(log: McapFile, wanted: set[str] | None = None) -> Messages:
    """Every message by topic, in the order of the file."""
    channels = log.directory.channels
    numbers = {n for n, c in channels.items() if wanted is None or c.topic in wanted}
    found: Messages = {}
    for block in log.blocks(frozenset(numbers)):
        for number, part in block.messages.items():
            topic = log.directory.channels[number].topic
            for time, start, size in zip(part.log_time_ns, part.start, part.size, strict=True):
                content = block.data[start : start + size].tobytes()
                found.setdefault(topic, []).append((int(time), content))
    return found


def expected() -> Messages:
    return {
        topic.name: list(zip(map(int, topic.times_ns), topic.messages, strict=True))
        for topic in TOPICS
    }


def opened(path: Path) -> McapFile:
    return McapFile(path, path.name)


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"use_chunking": False},
        {"index_types": IndexType.NONE},
        {"use_statistics": False},
        {"repeat_channels": False},
        {"index_types": IndexType.NONE, "use_statistics": False, "use_summary_offsets": False},
        {"enable_crcs": False},
    ],
    ids=lambda options: "-".join(options) or "whole",
)
def test_the_same_messages_however_it_was_written(
    tmp_path: Path, compression: CompressionType, options: dict[str, object]
) -> None:
    log = opened(
        write_log(
            tmp_path / "run.mcap", TOPICS, chunk_size=2000, compression=compression, **options
        )
    )
    assert messages_of(log) == expected()
    assert log.directory.complete
    assert log.problems == []
    topics = {log.directory.channels[n].topic: k for n, k in log.directory.counts.items()}
    assert topics == {"/a": 300, "/b": 40}


def test_chunks_that_hold_nothing_wanted_are_not_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    early = array_topic("/early", ticks(200, 100.0), [[1.0]] * 200)
    late = array_topic("/late", ticks(200, 100.0) + 10**12, [[2.0]] * 200)
    log = opened(write_log(tmp_path / "run.mcap", [early, late], chunk_size=1000))
    unpacked = []
    monkeypatch.setattr(
        "pipeline.ingest.mcap_file.unpack", lambda head, *_, **__: unpacked.append(head)
    )
    monkeypatch.setattr(McapFile, "_found_in", lambda *_: walk(b"", Directory()))
    messages_of(log, {"/late"})
    assert unpacked
    assert min(head.end_time_ns for head in unpacked) > int(early.times_ns[-1])


def test_cut_off_anywhere_it_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    """What is read of a cut file is the beginning of what the whole file holds."""
    whole = log_bytes(TOPICS, chunk_size=2000)
    complete, path = expected(), tmp_path / "cut.mcap"
    most = 0
    for end in range(0, len(whole), 97):
        path.write_bytes(whole[:end])
        try:
            log = opened(path)
        except InputError:
            assert end < 40
            continue
        found = messages_of(log)
        for topic, rows in found.items():
            assert rows == complete[topic][: len(rows)]
        count = sum(map(len, found.values()))
        assert count >= most
        most = count
        assert len(log.problems) == 1
        assert "without its closing record" in log.problems[0].what
    assert most == 340


@pytest.mark.parametrize("compression", list(CompressionType))
def test_messages_of_a_chunk_that_was_cut_off_are_rescued(
    tmp_path: Path, compression: CompressionType
) -> None:
    noise = np.random.default_rng(0).standard_normal((20_000, 4))
    topic = array_topic("/a", ticks(20_000, 100.0), noise.tolist())
    path = write_log(tmp_path / "a.mcap", [topic], chunk_size=10**9, compression=compression)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    log = opened(path)
    rows = messages_of(log)["/a"]
    assert 3000 < len(rows) < 16_000
    assert [content for _, content in rows] == topic.messages[: len(rows)]
    assert f"of which {len(rows)} messages were rescued" in log.problems[0].what
    at = log.read_bytes
    assert 0.9 * log.size < at <= log.size
    assert f"up to byte {at} ({100 * at / log.size:.0f} %)" in log.problems[0].what


@given(st.data())
def test_damaged_anywhere_it_never_breaks_the_reader(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    whole = bytearray(log_bytes(TOPICS[:1], chunk_size=1000, compression=CompressionType.NONE))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(whole) - 1))
        whole[at] = data.draw(st.integers(0, 255))
    path = tmp_path_factory.mktemp("damaged") / "run.mcap"
    path.write_bytes(bytes(whole))
    with suppress(InputError):
        log = opened(path)
        for block in log.blocks(frozenset(log.directory.channels)):
            for part in block.messages.values():
                assert (part.start >= 0).all()
                assert (part.start + part.size <= block.data.size).all()


def test_a_damaged_chunk_is_left_out_and_named(tmp_path: Path) -> None:
    topic = TOPICS[0]
    whole = bytearray(
        log_bytes([topic], chunk_size=2000, compression=CompressionType.NONE, enable_crcs=True)
    )
    # a byte in a message of the second chunk
    at = whole.find(topic.messages[100])
    whole[at + 20] ^= 0xFF
    path = tmp_path / "run.mcap"
    path.write_bytes(bytes(whole))
    log = opened(path)
    rows = messages_of(log)["/a"]
    assert 200 < len(rows) < 300
    assert set(rows) < set(expected()["/a"])
    assert "checksum is wrong" in log.problems[0].what


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "the file is empty"),
        (b"nonsense" * 5, "not MCAP: 40 bytes that begin with"),
        (MAGIC, "ends after 8 bytes"),
        (MAGIC + bytes(10), "ends after 18 bytes"),
        (b"#ROSBAG V2.0\n" + bytes(50), "a ROS 1 bag"),
        (b"SQLite format 3\0" + bytes(50), "SQLite"),
        (b"version https://git-lfs.github.com/spec/v1\n" + bytes(50), "Git LFS"),
        (b"PK\3\4" + bytes(50), "ZIP"),
    ],
)
def test_what_is_no_log_is_named(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=says):
        opened(path)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        opened(tmp_path / "none.mcap")


@pytest.mark.parametrize("stated", [2**62, 2**40, 200 * 2**20])
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_that_unpacks_without_end_is_refused(
    tmp_path: Path, stated: int, compression: str
) -> None:
    """A small file must not take the memory that it asks for."""
    import lz4.frame
    import zstandard

    pack = zstandard.ZstdCompressor().compress if compression == "zstd" else lz4.frame.compress
    packed = pack(bytes(400 * 2**20))
    name = compression.encode()
    head = struct.pack("<QQQI", 0, 1, stated, 0) + struct.pack("<I", len(name)) + name
    chunk = head + struct.pack("<Q", len(packed)) + packed
    whole = log_bytes(TOPICS[:1])
    at = len(MAGIC) + RECORD_HEAD.size + RECORD_HEAD.unpack_from(whole, len(MAGIC))[1]
    path = tmp_path / "bomb.mcap"
    path.write_bytes(whole[:at] + RECORD_HEAD.pack(CHUNK, len(chunk)) + chunk + whole[at:])
    del packed, chunk
    tracemalloc.start()
    log = opened(path)
    found = messages_of(log)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 700 * 2**20
    assert len(found["/a"]) == 300
    assert "left out" in log.problems[0].what


def record(opcode: int, content: bytes) -> bytes:
    return RECORD_HEAD.pack(opcode, len(content)) + content


def message(channel: int, time: int, content: bytes) -> bytes:
    return record(5, struct.pack("<HIQQ", channel, 0, time, time) + content)


CHUNK_OF_THREE = message(1, 10, b"abc") + message(2, 20, b"") + message(1, 30, b"defg")
AT = [0, len(message(1, 10, b"abc")), len(message(1, 10, b"abc") + message(2, 20, b""))]


def test_by_index_and_by_walking_are_the_same() -> None:
    block = block_by_index(
        CHUNK_OF_THREE, {1: np.array([AT[2], AT[0]]), 2: np.array([AT[1]])}, Directory()
    )
    other = walk(CHUNK_OF_THREE, Directory())
    assert block is not None
    for number in (1, 2):
        for name in ("log_time_ns", "start", "size"):
            ours, theirs = (getattr(one.messages[number], name) for one in (block, other))
            np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize(
    "index",
    [
        {1: [AT[0]], 2: [AT[1]]},  # one message is missing
        {1: [AT[0], AT[2]]},  # a channel is missing
        {1: [AT[0], AT[1], AT[2]]},  # of another channel
        {1: [AT[0], AT[2], AT[2]], 2: [AT[1]]},  # one twice
        {1: [AT[0] + 1, AT[2]], 2: [AT[1]]},  # beside it
        {1: [AT[0], 10**9], 2: [AT[1]]},  # beyond the end
        {1: [-5, AT[2]], 2: [AT[1]]},
    ],
)
def test_an_index_that_does_not_agree_is_not_believed(index: dict[int, list[int]]) -> None:
    offsets = {number: np.array(at) for number, at in index.items()}
    assert block_by_index(CHUNK_OF_THREE, offsets, Directory()) is None


@given(st.binary(max_size=200))
def test_walking_anything_ends(data: bytes) -> None:
    block = walk(data, Directory())
    for part in block.messages.values():
        assert (part.start + part.size <= len(data)).all()


class Forgetful(Writer):
    """A writer whose summary knows nothing of the messages of its first channel."""

    def finish(self) -> None:
        """Close the last chunk, forget, and write the summary."""
        getattr(self, "_Writer__finalize_chunk")()  # noqa: B009  private to the library
        statistics = getattr(self, "_Writer__statistics")  # noqa: B009
        statistics.message_count -= statistics.channel_message_counts.pop(1)
        for index in getattr(self, "_Writer__chunk_indices"):  # noqa: B009
            index.message_index_offsets.pop(1, None)
        super().finish()


def test_a_summary_that_forgets_a_topic(tmp_path: Path) -> None:
    times = ticks(400, 20.0)
    topics = [json_topic(name, times, [{"depth": 1.0 + k} for k in range(400)]) for name in "ab"]
    with patch("pool_logs.Writer", Forgetful):
        log = McapFile(write_log(tmp_path / "run.mcap", topics, chunk_size=2000), "run.mcap")
    assert {topic.name: topic.messages for topic in log.topics()} == {"a": 400, "b": 400}
    assert "the log's summary counts no messages of a" in log.problems[0].what
