"""Ingest of a pool-run log against mcap-ros2-support, in one run: time, and the same arrays.

python -m benchmarks.ingest_mcap [--minutes 10]

Both read the same numbers of the same topics of a log with an IMU at 200 Hz, with the simulated
side of the run in it, too. The peer decodes the messages of the wanted topics only. "gather"
is the way
from the file to arrays of numbers and stamps; "whole" is `read_pool_run`, which chooses topics,
aligns clocks, converts, looks for faults and compares channels with each other. Medians of five
rounds in which all take turns, in seconds of the processor.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from pipeline.export.mcap_log import write_run_log
from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.message_fields import Stamp
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_codec import codec_of
from pipeline.ingest.pool_run_extract import Request, TopicData, extract
from pipeline.simulate.sensors import Channel
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

NAMES = ("upper", "lower", "left", "right", "bow")
STAMP = Stamp(("header", "stamp", "sec"), nanoseconds=("header", "stamp", "nanosec"))
#: Topic -> fields of its messages whose numbers are read.
WANTED: dict[str, tuple[str, ...]] = {
    "/thrusters/command": ("position",),
    "/thrusters/state": ("velocity",),
    "/imu/data": ("angular_velocity", "linear_acceleration", "orientation"),
    "/dvl/velocity": ("twist.linear",),
    "/depth": ("fluid_pressure",),
    "/position": ("point",),
    "/battery": ("voltage",),
}
PARTS = {"position": 5, "velocity": 5, "fluid_pressure": 0, "voltage": 0, "orientation": 4}


def write(path: Path, seconds: float) -> None:
    """Write a log of plausible motion with noise."""
    generator = np.random.default_rng(1)

    def channel(columns: tuple[str, ...], rate_hz: float, delay_s: float, size: float) -> Channel:
        valid = np.arange(int(seconds * rate_hz)) / rate_hz
        speed = np.linspace(0.3, 1.1, len(columns))
        values = size * np.sin(speed * valid[:, None])
        values += 0.01 * size * generator.standard_normal(values.shape)
        return Channel(columns, valid, valid + delay_s, values)

    rate = ("p_radps", "q_radps", "r_radps")
    force = ("fx_mps2", "fy_mps2", "fz_mps2")
    log = {
        "command": channel(NAMES, 50.0, 0.0, 60.0),
        "imu": channel((*rate, *force, "qw", "qx", "qy", "qz"), 200.0, 0.005, 1.0),
        "dvl": channel(("vx_mps", "vy_mps", "vz_mps"), 8.0, 0.1, 1.0),
        "depth": channel(("depth_m",), 20.0, 0.02, 2.0),
        "position": channel(("north_m", "east_m", "down_m"), 2.0, 0.3, 5.0),
        "shaft_speed": channel(NAMES, 20.0, 0.0, 1000.0),
        "voltage": channel(("supply_v",), 5.0, 0.0, 48.0),
    }
    write_run_log(
        path, log, vehicle_name="bench", density_kgpm3=1000.0, gravity_mps2=9.81, simulated=log
    )


def paths(topic: str) -> tuple[tuple[str | int, ...], ...]:
    """Paths of the numbers that are read of a topic."""
    found: list[tuple[str | int, ...]] = []
    for field in WANTED[topic]:
        steps = tuple(field.split("."))
        count = PARTS.get(field, 3)
        if topic.startswith("/thrusters"):
            found += [(*steps, i) for i in range(count)]
        elif count == 0:
            found.append(steps)
        else:
            found += [(*steps, letter) for letter in "xyzw"[:count]]
    return tuple(found)


def gather(path: Path) -> dict[str, TopicData]:
    """Read the numbers with the message index and NumPy."""
    log = McapFile(path, path.name)
    channels = log.directory.channels
    codecs = {
        number: codec_of(channel, log.directory.schemas.get(channel.schema_id))
        for number, channel in channels.items()
        if channel.topic in WANTED
    }
    return extract(log, codecs, {topic: Request(paths(topic), STAMP) for topic in WANTED})


def peer(path: Path) -> dict[str, tuple[IntArray, FloatArray]]:
    """Read the same with mcap-ros2-support."""
    takers = {topic: [taker(one) for one in paths(topic)] for topic in WANTED}
    stamps: dict[str, list[int]] = {topic: [] for topic in WANTED}
    rows: dict[str, list[list[float]]] = {topic: [] for topic in WANTED}
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages(
            topics=list(WANTED), log_time_order=False
        ):
            stamp = message.header.stamp
            stamps[channel.topic].append(stamp.sec * 1_000_000_000 + stamp.nanosec)
            rows[channel.topic].append([take(message) for take in takers[channel.topic]])
    return {topic: (np.array(stamps[topic]), np.array(rows[topic], float)) for topic in WANTED}


def taker(path: tuple[str | int, ...]) -> Callable[[Any], float]:
    """Return a function that takes the number at a path out of a decoded message."""

    def take(message: Any) -> float:  # noqa: ANN401  the library makes the type at run time
        for step in path:
            message = message[step] if isinstance(step, int) else getattr(message, step)
        return float(message)

    return take


def vehicle() -> Vehicle:
    """Return a vehicle with the thrusters of the log."""
    thruster = {"propeller": "screw", "drive": "drive", "position_m": (0, 0, 0)}
    return Vehicle.model_validate(
        {
            "name": "bench",
            "title": "benchmark",
            "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
            "propellers": {"screw": {"diameter_m": 0.14}},
            "drives": {"drive": {"code_min": -127, "code_max": 127}},
            "thrusters": [{"name": name, "direction": (1, 0, 0), **thruster} for name in NAMES],
            "tables": {"propeller": "screw", "drive": "drive"},
        }
    )


def rounds(works: dict[str, Callable[[], Any]], count: int) -> dict[str, FloatArray]:
    """Time works by turns (count,) each, in seconds of the processor: others may use the rest."""
    taken: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(count):
        for name, work in works.items():
            begin = time.process_time()
            work()
            taken[name].append(time.process_time() - begin)
    return {name: np.array(times) for name, times in taken.items()}


def main() -> None:
    """Write the logs, read them, compare, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    minutes = parser.parse_args().minutes
    with tempfile.TemporaryDirectory() as folder:
        path, longer = Path(folder) / "run.mcap", Path(folder) / "longer.mcap"
        write(path, 60.0 * minutes)
        write(longer, 120.0 * minutes)
        ours, theirs = gather(path), peer(path)
        for topic, (stamps, values) in theirs.items():
            np.testing.assert_array_equal(ours[topic].stamp_ns, stamps)
            np.testing.assert_array_equal(ours[topic].values, values)
        messages = sum(len(stamps) for stamps, _ in theirs.values())
        megabytes = path.stat().st_size / 1e6
        print(f"{minutes:g} min, {messages} messages of {len(WANTED)} topics, {megabytes:.1f} MB")
        print("arrays of numbers and stamps: identical")
        works: dict[str, Callable[[], Any]] = {
            "mcap-ros2-support": lambda: peer(path),
            "gather": lambda: gather(path),
            "gather, a log twice as long": lambda: gather(longer),
            "whole": lambda: read_pool_run(path, vehicle(), path.parent),
            "whole, a log twice as long": lambda: read_pool_run(longer, vehicle(), path.parent),
        }
        taken = rounds(works, 5)
        slow = taken["mcap-ros2-support"]
        for name, times in taken.items():
            print(f"{name:28}{np.median(times):8.3f} s  {np.median(slow / times):6.1f} x")
        for name in ("gather", "whole"):
            ratio = np.median(taken[f"{name}, a log twice as long"] / taken[name])
            print(f"{name}: twice the log takes {ratio:.2f} times as long")


if __name__ == "__main__":
    main()
