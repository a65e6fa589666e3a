"""Water that a log states: taken where it can be true."""

from pathlib import Path

import numpy as np
import pytest
from pool_logs import json_topic, rov, ticks, write_log

from pipeline.ingest.mcap_file import McapFile
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_channel import water_of
from pipeline.ingest.pool_run_convert import WaterOfRun

STATED = {"density_kgpm3": "1020.0", "gravity_mps2": "9.8", "atmospheric_pressure_pa": "100000.0"}
OF_THE_VEHICLE = WaterOfRun(1000.0, 9.81)


def log_stating(folder: Path, **stated: str) -> Path:
    contents = [{"pressure": 101_325.0 + 1000.0 * k} for k in range(20)]
    topic = json_topic("/pressure", ticks(20, 10.0), contents)
    return write_log(folder / "run.mcap", [topic], metadata={"rig2sea.log": STATED | stated})


def read_through(path: Path) -> McapFile:
    """A log whose metadata were met."""
    log = McapFile(path, "run")
    assert not list(log.blocks(frozenset()))
    return log


def test_the_water_that_a_log_states_is_taken(tmp_path: Path) -> None:
    log = read_through(log_stating(tmp_path))
    assert water_of(rov(), log.directory.metadata) == WaterOfRun(1020.0, 9.8, 100_000.0)


@pytest.mark.parametrize("key", STATED)
@pytest.mark.parametrize("value", ["0", "-9", "nan", "inf", "-inf", "1e999", "much", ""])
def test_water_that_cannot_be_is_not_believed(tmp_path: Path, key: str, value: str) -> None:
    path = log_stating(tmp_path, **{key: value})
    assert water_of(rov(), read_through(path).directory.metadata) == OF_THE_VEHICLE
    run = read_pool_run(
        path, rov(channels=[{"quantity": "pressure", "topic": "/pressure"}]), tmp_path
    )
    np.testing.assert_allclose(
        run.channels["depth"].values[:, 0], np.arange(20) * 1000.0 / 9810.0, atol=1e-9
    )
