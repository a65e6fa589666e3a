"""Two logs of one run: a part of it, one by another clock; two runs of one vehicle are two."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import SECOND_NS, imu_topic, json_topic, rov, ticks, write_log

from pipeline.ingest.pool_run import read_pool_run, summarize
from pipeline.ingest.same_run import repeated_runs
from pipeline.records.pool_run import PoolRunRecord

HZ, COUNT = 20.0, 1200


def log(path: Path, *, seed: int = 0, late_s: int = 0, part: slice = slice(None)) -> PoolRunRecord:
    noise = np.random.default_rng(seed).standard_normal((COUNT, 7))
    times = (ticks(COUNT, HZ) + late_s * SECOND_NS)[part]
    depth = [{"depth": 3.0 + float(one)} for one in noise[part, 6]]
    topics = [imu_topic(times, noise[part, :3], forces=noise[part, 3:6] - [0.0, 0.0, 9.81])]
    file = write_log(path / "run.mcap", [*topics, json_topic("/depth", times, depth)])
    return summarize(read_pool_run(file, rov(), path))


@pytest.mark.parametrize(
    ("seed", "late_s", "part", "is_copy"),
    [
        (0, 0, slice(0, 700), True),
        (0, 3 * 3600, slice(None), True),
        (1, 0, slice(0, 700), False),
        (1, 600, slice(None), False),
    ],
)
def test_a_part_or_another_clock_is_the_same_run(
    seed: int, late_s: int, part: slice, is_copy: bool, tmp_path: Path
) -> None:
    other = log(tmp_path, seed=seed, late_s=late_s, part=part)
    runs = {"a": other, "b": log(tmp_path)}
    kept, copy = ("b", "a") if part.stop else ("a", "b")
    assert repeated_runs(runs) == ({copy: kept} if is_copy else {})
