"""The page that describes the log is enough: its writer is run, its bytes are compared."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from pipeline.export import attachment_topics, log_topics
from pipeline.export.mcap_log import LAYOUT_VERSION, write_run_log
from pipeline.simulate.sensors import Channel

Records = dict[str, list[tuple[int, int, int, bytes]]]


def page(repository: Path) -> str:
    return (repository / "docs" / "formats_log.md").read_text(encoding="utf-8")


def section(text: str, title: str) -> str:
    return text.split(f"\n## {title}\n")[1].split("\n## ", maxsplit=1)[0]


def read(path: Path) -> tuple[Records, dict[str, tuple[str, str]]]:
    records: Records = {}
    schemas = {}
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            assert schema is not None
            schemas[channel.topic] = (schema.name, schema.data.decode())
            entry = (message.log_time, message.publish_time, message.sequence, message.data)
            records.setdefault(channel.topic, []).append(entry)
    return records, schemas


def test_the_small_writer_writes_what_ours_writes(repository: Path, tmp_path: Path) -> None:
    """Every message and definition, byte for byte."""
    script = repository / "docs/examples/write_ros2_log.py"
    subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=True)
    time = np.arange(101) / 50
    codes = np.stack([np.where(time < 1.0, 0.0, 60.0), np.zeros(101)], axis=1)
    valid = np.arange(1, 21) / 10 - 0.02
    log = {
        "command": Channel(("port", "starboard"), time, time, codes),
        "depth": Channel(("depth_m",), valid, valid + 0.02, np.full((20, 1), 3.0)),
    }
    write_run_log(
        tmp_path / "ours.mcap", log, vehicle_name="small", density_kgpm3=1000.0, gravity_mps2=9.81
    )
    assert read(tmp_path / "run.mcap") == read(tmp_path / "ours.mcap")


def test_the_page_knows_every_topic_and_frame(repository: Path) -> None:
    text = page(repository)
    files = [log_topics.__file__, attachment_topics.__file__]
    sources = [Path(one).read_text(encoding="utf-8") for one in files]
    topics = [set(re.findall(r'"(?:\{prefix\})?(/[a-z/]+)"', source)) for source in sources]
    assert [len(one) >= least for one, least in zip(topics, (9, 3), strict=True)] == [True, True]
    for topic in set().union(*topics):
        assert f"`{topic}`" in text or f"`/sim{topic}`" in text
    frames = set(re.findall(r'"([a-z_]+_frd|ned)"', "".join(sources)))
    assert len(frames) >= 5
    for frame in frames:
        assert f"`{frame}`" in text
    assert f"version of this page: `{LAYOUT_VERSION}`" in text


def test_the_conversion_from_ros_axes_is_right(repository: Path) -> None:
    """A body 30 degrees left of east, in ROS's axes, looks at 60 degrees from north here."""
    from scipy.spatial.transform import Rotation

    half = 1 / np.sqrt(2)
    text = section(page(repository), "Axes")
    assert "a = (w 0, x s, y s, z 0)" in text
    assert "b = (w 0, x 1, y 0, z 0)" in text.replace("\n", " ")
    a, b = Rotation.from_quat([half, half, 0, 0]), Rotation.from_quat([1, 0, 0, 0])
    ros = Rotation.from_euler("ZYX", [30, 10, -5], degrees=True)
    ours = a * ros * b
    body_ros = np.array([0.3, -0.4, 1.2])
    east, north, up = ros.apply(body_ros)
    x, y, z = body_ros
    np.testing.assert_allclose(ours.apply([x, -y, -z]), [north, east, -up], atol=1e-15)
    level = a * Rotation.from_euler("z", 30, degrees=True) * b
    np.testing.assert_allclose(level.as_euler("ZYX", degrees=True), [60, 0, 0], atol=1e-12)
