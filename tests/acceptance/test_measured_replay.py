"""The commands of a measured log simulated, and both sides in one log."""

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from pipeline.actions.simulation import SimulationRequest, simulate_to_file

HERE = Path(__file__).parent


def messages(path: Path) -> dict[str, list[tuple[int, bytes]]]:
    found: dict[str, list[tuple[int, bytes]]] = {}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            found.setdefault(channel.topic, []).append((message.log_time, message.data))
    return found


def test_a_run_of_the_pool_with_its_simulation_beside_it(shared_data: Path, tmp_path: Path) -> None:
    """Topics without our names or a slash before them, an own message, and no velocity."""
    logs = sorted((shared_data / "exjobbrov_pool").glob("stepDepth*.mcap"))
    if not logs:
        pytest.skip("no measured logs")
    target = tmp_path / "both.mcap"
    result = simulate_to_file(
        SimulationRequest(str(HERE / "exjobbrov"), target, log=logs[0], raw=tmp_path)
    )
    recorded, both = messages(logs[0]), messages(target)
    assert {topic: both[topic] for topic in recorded} == recorded
    assert set(both) - set(recorded) == {
        "/sim/thrusters/command",
        "/sim/imu/data",
        "/sim/depth",
        "/sim/odometry",
        "/sim/thrusters/thrust",
    }
    assert any("velocity and position not measured then" in text for text in result.warnings)
    # it starts from the measured attitude and depth, and both sides share one clock
    with target.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        firsts = {}
        for _, channel, message, content in reader.iter_decoded_messages(
            topics=["/sim/imu/data", "rovio/imu/data", "/sim/odometry"]
        ):
            firsts.setdefault(channel.topic, (message.log_time, content))
    apart_s = (firsts["/sim/imu/data"][0] - firsts["rovio/imu/data"][0]) * 1e-9
    assert abs(apart_s) < 1.0
    turn = firsts["/sim/odometry"][1].pose.pose.orientation
    assert np.linalg.norm([turn.x, turn.y, turn.z, turn.w]) == pytest.approx(1.0)
    assert 0.1 < firsts["/sim/odometry"][1].pose.pose.position.z < 3.0
