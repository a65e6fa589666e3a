"""A recorded log with a simulation beside it: nothing of the recorded one is lost or changed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from pipeline.errors import CannotComputeError, InputError
from pipeline.export.overlay import write_overlay
from pipeline.ingest.mcap_file import RecordedFile
from pipeline.records.run_arrays import RecordedMessage, RecordedTopic
from pipeline.simulate.sensors import Channel

START_NS = 1_700_000_000_000_000_000
SIMULATED = {
    "command": Channel(("a", "b"), np.arange(5) / 10, np.arange(5) / 10, np.zeros((5, 2))),
    "depth": Channel(("depth_m",), np.arange(5) / 10, np.arange(5) / 10 + 0.05, np.ones((5, 1))),
}
Rows = list[tuple[str, int, int, int, bytes]]


@dataclass
class InMemory:
    """A recorded log without a file."""

    rows: list[RecordedMessage]
    topics: dict[int, RecordedTopic]
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def topic(self, number: int) -> RecordedTopic | None:
        return self.topics.get(number)

    def messages(self) -> Iterator[RecordedMessage]:
        yield from self.rows


def recorded(**changes: object) -> InMemory:
    rows = [
        RecordedMessage(i % 3, START_NS + i * 70_000_000, START_NS + i, 7 * i, bytes([i] * (i + 1)))
        for i in range(12)
    ]
    topics = {
        0: RecordedTopic("/odd", "strange", {"key": "value"}, "pkg/Odd", "own", b"\x00\xff"),
        1: RecordedTopic("/plain", "json", {}),
        2: RecordedTopic("/sim/depth", "json", {}),
    }
    return InMemory(**({"rows": rows, "topics": topics} | changes))  # type: ignore[arg-type]


def written(path: Path) -> tuple[Rows, dict[str, Mapping[str, str]]]:
    rows: Rows = []
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        for _, channel, m in reader.iter_messages(log_time_order=False):
            rows.append((channel.topic, m.log_time, m.publish_time, m.sequence, m.data))
        told = {record.name: record.metadata for record in reader.iter_metadata()}
    return rows, told


def overlay(path: Path, log: InMemory | RecordedFile, **changes: object) -> None:
    options: dict[str, object] = {
        "vehicle_name": "boat",
        "density_kgpm3": 1000.0,
        "gravity_mps2": 9.81,
        "start_time_ns": START_NS,
    }
    write_overlay(path, log, SIMULATED, **(options | changes))  # type: ignore[arg-type]


def test_recorded_messages_are_the_same_bytes_and_sim_of_before_is_gone(tmp_path: Path) -> None:
    log = recorded()
    overlay(tmp_path / "both.mcap", log, metadata={"flown": "again"})
    rows, told = written(tmp_path / "both.mcap")
    kept = [row for row in rows if not row[0].startswith("/sim/")]
    assert kept == [
        (log.topics[m.number].topic, m.log_time_ns, m.publish_time_ns, m.sequence, m.data)
        for m in log.rows
        if m.number != 2
    ]
    assert sum(row[0] == "/sim/depth" for row in rows) == 5  # ours alone
    assert {len(row[4]) for row in rows if row[0] == "/sim/depth"} != {1}
    assert told == {"rig2sea.run": {"flown": "again"}}
    with (tmp_path / "both.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    odd = next(one for one in summary.channels.values() if one.topic == "/odd")
    schema = summary.schemas[odd.schema_id]
    assert (odd.message_encoding, odd.metadata) == ("strange", {"key": "value"})
    assert (schema.name, schema.encoding, schema.data) == ("pkg/Odd", "own", b"\x00\xff")


def test_both_sides_come_in_the_order_of_their_log_times(tmp_path: Path) -> None:
    overlay(tmp_path / "both.mcap", recorded())
    times = [row[1] for row in written(tmp_path / "both.mcap")[0]]
    assert times == sorted(times)


def test_messages_out_of_order_keep_their_order(tmp_path: Path) -> None:
    log = recorded()
    log.rows.reverse()
    overlay(tmp_path / "both.mcap", log)
    kept = [row[1] for row in written(tmp_path / "both.mcap")[0] if row[0] in {"/odd", "/plain"}]
    assert kept == sorted(kept, reverse=True)


def test_metadata_stay_and_what_made_the_recorded_one_gets_another_name(tmp_path: Path) -> None:
    metadata = {
        "mission": {"day": "1"},
        "rig2sea.run": {"flown": "hover"},
        "rig2sea.log": {"density_kgpm3": "1020.0", "gravity_mps2": "9.8"},
    }
    overlay(tmp_path / "both.mcap", recorded(metadata=metadata), metadata={"flown": "again"})
    rows, told = written(tmp_path / "both.mcap")
    assert told["mission"] == {"day": "1"}
    assert told["rig2sea.recorded_run"] == {"flown": "hover"}
    assert told["rig2sea.run"] == {"flown": "again"}
    # 1 m of the log's own water, at the end of the message before the variance
    data = next(row[4] for row in rows if row[0] == "/sim/depth")
    pressure = np.frombuffer(data[-16:-8], "<f8")[0]
    assert pressure == pytest.approx(101325.0 + 1020.0 * 9.8)


@pytest.mark.parametrize("number", ["0", "-9", "nan", "inf", "much"])
@pytest.mark.parametrize("name", ["density_kgpm3", "gravity_mps2"])
def test_water_that_cannot_be_is_not_taken_from_a_log(
    tmp_path: Path, name: str, number: str
) -> None:
    stated = {"density_kgpm3": "1020.0", "gravity_mps2": "9.8"} | {name: number}
    overlay(tmp_path / "both.mcap", recorded(metadata={"rig2sea.log": stated}))
    rows, _ = written(tmp_path / "both.mcap")
    data = next(row[4] for row in rows if row[0] == "/sim/depth")
    assert np.frombuffer(data[-16:-8], "<f8")[0] == pytest.approx(101325.0 + 1000.0 * 9.81)


@pytest.mark.parametrize("index", [True, False])
def test_a_file_is_copied_whole(tmp_path: Path, index: bool) -> None:
    source = tmp_path / "recorded.mcap"
    with source.open("wb") as stream:
        writer = Writer(
            stream, chunk_size=500, compression=CompressionType.ZSTD, use_chunking=index
        )
        writer.start()
        channels = [writer.register_channel(f"/t{i}", "raw", 0) for i in range(3)]
        for i in range(300):
            writer.add_message(channels[i % 3], START_NS + i, bytes([i % 256] * 20), i, i)
        writer.finish()
    overlay(tmp_path / "both.mcap", RecordedFile(source, "recorded.mcap"))
    rows = written(tmp_path / "both.mcap")[0]
    assert [row for row in rows if row[0].startswith("/t")] == written(source)[0]
    overlay(source, RecordedFile(source, "recorded.mcap"))  # in its own place, too
    assert [row for row in written(source)[0] if row[0].startswith("/t")] == [
        row for row in rows if row[0].startswith("/t")
    ]


def test_what_cannot_be_written_leaves_no_file(tmp_path: Path) -> None:
    bad = {"command": SIMULATED["command"], "sonar": SIMULATED["depth"]}
    with pytest.raises(CannotComputeError, match="no topic is defined for sonar"):
        write_overlay(
            tmp_path / "both.mcap",
            recorded(),
            bad,
            vehicle_name="boat",
            density_kgpm3=1000.0,
            gravity_mps2=9.81,
            start_time_ns=START_NS,
        )
    (tmp_path / "short.mcap").write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(InputError, match="before anything was written"):
        RecordedFile(tmp_path / "short.mcap", "short.mcap")
    assert not list(tmp_path.glob("*both*"))
