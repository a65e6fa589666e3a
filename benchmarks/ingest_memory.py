"""Memory that the ingest of a long log takes: 2 GB must fit into 1 GB.

python -m benchmarks.ingest_memory [--gigabytes 2] [--most 1.0]

Writes an uncompressed log of the given size without a summary (so that it is read twice), reads it
in a process of its own, and ends with exit code 1 if that took more memory than allowed.
"""

import argparse
import resource
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.ingest_mcap import vehicle, write
from pipeline.ingest.mcap_chunk import at_every_byte
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.mcap_records import (
    CHANNEL,
    CHUNK,
    FOOTER,
    HEADER,
    MAGIC,
    MESSAGE_INDEX,
    RECORD_HEAD,
    SCHEMA,
    ChannelRecord,
    SchemaRecord,
)
from pipeline.ingest.pool_run import read_pool_run, resample

_SECONDS = 10


def text(value: str) -> bytes:
    """Serialise a text as MCAP does."""
    return struct.pack("<I", len(value)) + value.encode()


def record(opcode: int, content: bytes) -> bytes:
    """Serialise a record."""
    return RECORD_HEAD.pack(opcode, len(content)) + content


def definitions(schemas: list[SchemaRecord], channels: list[ChannelRecord]) -> bytes:
    """Serialise schemas and channels."""
    found = b""
    for schema in schemas:
        head = struct.pack("<H", schema.id) + text(schema.name) + text(schema.encoding)
        found += record(SCHEMA, head + struct.pack("<I", len(schema.data)) + schema.data)
    for channel in channels:
        head = struct.pack("<HH", channel.id, channel.schema_id)
        head += text(channel.topic) + text(channel.message_encoding)
        found += record(CHANNEL, head + struct.pack("<I", 0))
    return found


def write_long(path: Path, size: float) -> int:
    """Repeat ten seconds, later each time, until the file has the size; return the seconds."""
    short = path.with_name("short.mcap")
    write(short, _SECONDS)
    log = McapFile(short, short.name)
    channels = log.directory.channels
    blocks = list(log.blocks(frozenset(channels)))
    begins = np.concatenate([[0], np.cumsum([block.data.size for block in blocks])])
    whole = np.concatenate([block.data for block in blocks])
    at = {
        number: np.concatenate(
            [
                block.messages[number].start + begin
                for block, begin in zip(blocks, begins[:-1], strict=True)
                if number in block.messages
            ]
        )
        for number in channels
    }
    every = np.sort(np.concatenate(list(at.values())))
    seconds = 0
    with path.open("wb") as stream:
        stream.write(MAGIC + record(HEADER, text("ros2") + text("benchmark")))
        stream.write(definitions(list(log.directory.schemas.values()), list(channels.values())))
        while stream.tell() < size:
            for start in (every - 16, every - 8):  # log time, publish time
                at_every_byte(whole, np.dtype("<u8"))[start] += _SECONDS * 10**9 * (seconds > 0)
            at_every_byte(whole, np.dtype("<i4"))[every + 4] += _SECONDS * (seconds > 0)
            times = at_every_byte(whole, np.dtype("<u8"))[every - 16]
            head = struct.pack("<QQQI", times.min(), times.max(), whole.size, 0) + text("")
            stream.write(record(CHUNK, head + struct.pack("<Q", whole.size) + whole.tobytes()))
            for number, start in at.items():
                entries = np.empty((start.size, 2), "<u8")
                entries[:, 0] = at_every_byte(whole, np.dtype("<u8"))[start - 16]
                entries[:, 1] = start - 31
                index = struct.pack("<HI", number, entries.nbytes) + entries.tobytes()
                stream.write(record(MESSAGE_INDEX, index))
            seconds += _SECONDS
        stream.write(record(FOOTER, bytes(20)) + MAGIC)
    return seconds


def read(path: Path) -> None:
    """Read a log and print what it took."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    begin = time.perf_counter()
    run = read_pool_run(path, vehicle(), path.parent)
    taken = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    table = resample(run, 10.0)
    last = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    readings = sum(channel.values.size for channel in run.channels.values())
    print(f"{readings / 1e6:.1f} million numbers, {run.duration_s / 3600:.2f} h, in {taken:.1f} s")
    print(
        f"memory: {before:.2f} GB at the start, {after:.2f} GB after reading, {last:.2f} GB after"
    )
    print(f"a table of {len(table.time_s)} rows at 10 Hz")
    print(f"{last:.3f}")


def main() -> int:
    """Write, read apart, judge."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gigabytes", type=float, default=2.0)
    parser.add_argument("--most", type=float, default=1.0, help="memory allowed [GB]")
    parser.add_argument("--read", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.read:
        read(arguments.read)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.mcap"
        write_long(path, arguments.gigabytes * 1e9)
        print(f"{path.stat().st_size / 1e9:.2f} GB written")
        command = [sys.executable, "-m", "benchmarks.ingest_memory", "--read", str(path)]
        said = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603  our own program
    *lines, last = said.stdout.splitlines()
    print("\n".join(lines))
    return int(float(last) > arguments.most)


if __name__ == "__main__":
    sys.exit(main())
