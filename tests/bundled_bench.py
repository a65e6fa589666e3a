"""mmt300 run by the real command, once for all tests: with a short pool run, or the bench alone.

A module of the tests.
"""

import json
import shutil
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from shared_runs import digests, once, rig2sea

#: The pool run, and how much of it is taken. [s]
POOL_RUN, BEGINNING_S = "2024-05-14-zig-zag.mcap", 36.0
#: What a pool run leaves in ``processed/mmt300``, and what tells of it.
_OF_RUNS = (
    "pool", "run_trials", "run_pages", "trial_days", "day_tables", "trial_pages", "run_diagnoses",
    "day_diagnoses", "vehicle_page.json", ".rig2sea",
)  # fmt: skip


def run_of_mmt300(repository: Path, factory: pytest.TempPathFactory) -> Path:
    """Run the bundled vehicle; ``said.json`` holds what was printed and the raw files' digests."""

    def build(root: Path) -> None:
        raw, own = repository / "raw/mmt300", root / "raw/mmt300"
        shutil.copytree(raw, own, ignore=shutil.ignore_patterns("pool"))
        (own / "pool").mkdir()
        # the beginning of one of its pool runs is enough
        _beginning(raw / "pool" / POOL_RUN, own / "pool" / POOL_RUN)
        before = digests(root / "raw")
        done = rig2sea(root, "run", "--cores", "1")  # the other core has its own tests
        said = {"code": done.returncode, "out": done.stdout, "err": done.stderr, "raw": before}
        (root / "said.json").write_text(json.dumps(said), encoding="utf-8")

    return once(factory, "bundled", build)


def _beginning(source: Path, target: Path) -> None:
    """Copy the beginning of a log."""
    with source.open("rb") as log, target.open("wb") as copy:
        reader, writer = make_reader(log), Writer(copy)
        writer.start(profile=reader.get_header().profile)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        channels: dict[int, int] = {}
        end_ns = None
        for schema, channel, message in reader.iter_messages():
            end_ns = end_ns or message.log_time + int(1e9 * BEGINNING_S)
            if message.log_time > end_ns:
                break
            if channel.id not in channels:
                assert schema is not None
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, known, channel.metadata
                )
            writer.add_message(
                channels[channel.id], message.log_time, message.data, message.publish_time
            )
        writer.finish()


def bench_of_mmt300(repository: Path, factory: pytest.TempPathFactory) -> Path:
    """Return its raw files and bench results, without pool runs and pages."""

    def build(folder: Path) -> None:
        whole = run_of_mmt300(repository, factory)
        for top in ("raw", "processed"):
            shutil.copytree(whole / top, folder / top, ignore=shutil.ignore_patterns(*_OF_RUNS))

    return once(factory, "bundled_bench", build)
