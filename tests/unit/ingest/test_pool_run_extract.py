"""Numbers and stamps taken out of a log: one message or many, known count or not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pool_logs import START_NS, array_topic, json_topic, ros_topic, rov, ticks, write_log

from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.message_fields import NO_STAMP, Stamp, stamp_of, ticks_ns
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_codec import codec_of
from pipeline.ingest.pool_run_extract import Request, TopicData, extract

UNITS = st.sampled_from([1, 1_000, 1_000_000, 1_000_000_000])


@given(value=st.integers(-(2**63), 2**63 - 1), unit_ns=UNITS)
def test_clocks_of_whole_numbers_are_exact(value: int, unit_ns: int) -> None:
    many = ticks_ns(np.array([value]), unit_ns)[0]
    one = stamp_of({"t": value}, Stamp(("t",), unit_ns))
    assert many == one
    assert one == value * unit_ns or one == NO_STAMP
    assert one != NO_STAMP or abs(value * unit_ns) > 2**63 - 2 * unit_ns


@given(value=st.integers(0, 2**64 - 1), unit_ns=UNITS)
def test_clocks_without_sign_are_exact(value: int, unit_ns: int) -> None:
    many = ticks_ns(np.array([value], np.uint64), unit_ns)[0]
    assert many == stamp_of({"t": value}, Stamp(("t",), unit_ns))


@given(value=st.floats(width=64) | st.floats(width=32), unit_ns=UNITS)
def test_clocks_of_decimal_numbers_are_rounded_alike(value: float, unit_ns: int) -> None:
    many = ticks_ns(np.array([value]), unit_ns)[0]
    one = stamp_of({"t": value}, Stamp(("t",), unit_ns))
    assert many == one
    if abs(value) < 1e6:
        assert one == pytest.approx(value * unit_ns, abs=0.5)


@pytest.mark.parametrize("narrow", ["i4", "u4", "i2", "u1"])
def test_narrow_clocks_do_not_overflow(narrow: str) -> None:
    most = np.iinfo(narrow).max
    assert ticks_ns(np.array([most], narrow), 1_000_000_000)[0] == int(most) * 10**9


@pytest.mark.parametrize(
    ("tree", "expected"),
    [
        ({"t": "1700000000"}, 1_700_000_000 * 10**9),
        ({"t": "1.5"}, 1_500_000_000),
        ({"t": "noon"}, NO_STAMP),
        ({"t": None}, NO_STAMP),
        ({}, NO_STAMP),
    ],
)
def test_stamps_written_as_text(tree: dict[str, object], expected: int) -> None:
    assert stamp_of(tree, Stamp(("t",))) == expected


def test_a_second_part_that_is_missing_makes_no_stamp() -> None:
    stamp = Stamp(("s",), nanoseconds=("n",))
    assert stamp_of({"s": 1, "n": 2}, stamp) == 10**9 + 2
    assert stamp_of({"s": 1}, stamp) == NO_STAMP


@pytest.mark.parametrize(
    ("seconds", "nanoseconds"),
    [
        (-5, 1e30),
        (5, 1e30),
        (9_000_000_000, 9_000_000_000_000_000_000),
        (-9_000_000_000, -9_000_000_000_000_000_000),
        (1e30, 0),
        (1, float("nan")),
    ],
)
def test_two_parts_that_make_no_time(seconds: float, nanoseconds: float) -> None:
    stamp = Stamp(("s",), nanoseconds=("n",))
    assert stamp_of({"s": seconds, "n": nanoseconds}, stamp) == NO_STAMP


_PARTS = {
    "int64": st.integers(-(2**63), 2**63 - 1) | st.integers(-(10**10), 10**10),
    "uint64": st.integers(0, 2**64 - 1),
    "int32": st.integers(-(2**31), 2**31 - 1),
    "float64": st.floats() | st.floats(-1e10, 1e10),
}


@given(data=st.data(), kinds=st.tuples(*[st.sampled_from(sorted(_PARTS))] * 2))
def test_stamps_of_two_parts_are_alike_both_ways(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject, kinds: tuple[str, str]
) -> None:
    parts = data.draw(st.lists(st.tuples(*[_PARTS[kind] for kind in kinds]), min_size=1))
    contents = [{"sec": sec, "nanosec": nanosec} for sec, nanosec in parts]
    text = f"{kinds[0]} sec\n{kinds[1]} nanosec\n"
    topic = ros_topic("/a", "a/msg/T", ticks(len(parts), 10.0), contents, text)
    log = McapFile(write_log(tmp_path_factory.getbasetemp() / "run.mcap", [topic]), "run")
    stamp = Stamp(("sec",), nanoseconds=("nanosec",))
    fast, slow = (taken(log, stamp=stamp, fast=fast).stamp_ns for fast in (True, False))
    assert fast is not None
    assert slow is not None
    np.testing.assert_array_equal(fast, slow)
    for found, (sec, nanosec) in zip(fast.tolist(), parts, strict=True):
        exact = not isinstance(sec, float) and not isinstance(nanosec, float)
        assert found == NO_STAMP or not exact or found == sec * 10**9 + nanosec


def test_wild_stamps_in_json_do_not_stop_the_reader(tmp_path: Path) -> None:
    stamps = [{"sec": 1_700_000_000 + k, "nanosec": 0} for k in range(20)]
    stamps[3] = {"sec": -5, "nanosec": 1e30}
    stamps[4] = {"sec": 9_000_000_000, "nanosec": 9_000_000_000_000_000_000}
    contents = [{"header": {"stamp": one}, "depth": 0.1 * k} for k, one in enumerate(stamps)]
    path = write_log(tmp_path / "run.mcap", [json_topic("/depth", ticks(20, 1.0), contents)])
    run = read_pool_run(path, rov(channels=[{"quantity": "depth", "topic": "/depth"}]), tmp_path)
    marked = run.channels["depth"].marks["no_stamp"]
    assert np.flatnonzero(marked).tolist() == [3, 4]


def taken(
    log: McapFile, topic: str = "/a", *, stamp: Stamp | None = None, fast: bool = True
) -> TopicData:
    channels = log.directory.channels
    codecs = {n: codec_of(c, log.directory.schemas.get(c.schema_id)) for n, c in channels.items()}
    if not fast:
        codecs = {number: replace(one, definition=None) for number, one in codecs.items()}
    return extract(log, codecs, {topic: Request((("data", 0),), stamp)})[topic]


def test_counts_that_are_too_small_do_not_matter(tmp_path: Path) -> None:
    topic = array_topic("/a", ticks(3000, 100.0), [[float(i)] for i in range(3000)])
    log = McapFile(write_log(tmp_path / "run.mcap", [topic], chunk_size=3000), "run")
    log.directory.counts = dict.fromkeys(log.directory.counts, 1)
    data = taken(log)
    np.testing.assert_array_equal(data.values[:, 0], np.arange(3000.0))
    np.testing.assert_array_equal(data.log_time_ns, topic.times_ns)


def test_counts_that_are_too_large_do_not_matter(tmp_path: Path) -> None:
    topic = array_topic("/a", ticks(30, 100.0), [[float(i)] for i in range(30)])
    log = McapFile(write_log(tmp_path / "run.mcap", [topic]), "run")
    log.directory.counts = dict.fromkeys(log.directory.counts, 1_000_000)
    assert taken(log).values.shape == (30, 1)


def test_several_publishers_of_one_topic_keep_the_order_of_the_file(tmp_path: Path) -> None:
    """A node that was restarted gets a channel of its own; the numbers are one series."""
    first = array_topic("/a", ticks(100, 10.0), [[2.0 * i] for i in range(100)])
    second = array_topic(
        "/a", ticks(100, 10.0, START_NS + 50_000_000), [[2.0 * i + 1.0] for i in range(100)]
    )
    second.options = {"publisher": "second"}
    path = write_log(tmp_path / "run.mcap", [first, second], chunk_size=1500)
    np.testing.assert_array_equal(taken(McapFile(path, "run")).values[:, 0], np.arange(200.0))
    run = read_pool_run(
        path, rov(channels=[{"quantity": "depth", "topic": "/a", "field": "data"}]), tmp_path
    )
    np.testing.assert_array_equal(run.channels["depth"].values[:, 0], np.arange(200.0))


def test_json_numbers_however_they_are_written(tmp_path: Path) -> None:
    written = [1, 2.5, "3.5", "NaN", None, True, "x", [1], 10**400, 4]
    topic = json_topic("/a", ticks(10, 10.0), [{"data": [value]} for value in written])
    topic.messages[9] = b"not JSON"
    data = taken(McapFile(write_log(tmp_path / "run.mcap", [topic]), "run"))
    expected = [1.0, 2.5, 3.5, np.nan, np.nan, 1.0, np.nan, np.nan, np.nan, np.nan]
    np.testing.assert_array_equal(data.values[:, 0], expected)
    assert np.flatnonzero(data.broken).tolist() == [9]
    assert "not JSON" in data.why_broken
