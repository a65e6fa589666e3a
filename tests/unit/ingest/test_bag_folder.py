"""Bags of ROS 2 as folders: a run whose parts are read one after the other."""

from pathlib import Path

import numpy as np
import pytest
import zstandard
from pool_logs import rov
from recorded_runs import Run, run, write_db3, write_mcap

from pipeline.errors import InputError
from pipeline.ingest.log_files import day_of, logs_of
from pipeline.ingest.pool_run import read_pool_run
from pipeline.plan import VehicleFolder
from pipeline.records.run_arrays import PoolRun
from pipeline.vehicle.run_notes import run_of
from pipeline.workflow.pool_runs import pool_logs

ROV = rov(defaults=True)


def halves() -> tuple[Run, Run, Run]:
    whole = run()
    parts = [
        Run(*(getattr(whole, name)[rows] for name in Run.__dataclass_fields__))
        for rows in (slice(0, 150), slice(150, None))
    ]
    return whole, parts[0], parts[1]


def bag(folder: Path, kind: str) -> Path:
    """A folder of two parts; returns its metadata.yaml."""
    _, first, second = halves()
    folder.mkdir(parents=True)
    names = []
    for number, part in enumerate((first, second)):
        path = folder / f"bag_{number}.{kind.removesuffix('.zstd')}"
        if "mcap" in kind:
            write_mcap(path, part)
        else:
            write_db3(path, part, folder.parent / f"made{number}")
        if kind.endswith(".zstd"):
            packed = zstandard.compress(path.read_bytes())
            path.unlink()
            path = path.with_name(f"{path.name}.zstd")
            path.write_bytes(packed)
        names.append(path.name)
    listed = "".join(f"\n    - {name}" for name in names)
    text = (
        "rosbag2_bagfile_information:\n  version: 5\n"
        f"  starting_time:\n    nanoseconds_since_epoch: {int(first.time_ns[0])}\n"
        f"  relative_file_paths:{listed}\n"
    )
    (folder / "metadata.yaml").write_text(text)
    return folder / "metadata.yaml"


def same(found: PoolRun, expected: PoolRun) -> None:
    assert found.complete
    assert set(found.channels) == set(expected.channels)
    for name, channel in expected.channels.items():
        assert np.array_equal(found.channels[name].time_ns, channel.time_ns)
        assert np.array_equal(found.channels[name].values, channel.values)


@pytest.mark.parametrize("kind", ["mcap", "db3", "mcap.zstd", "db3.zstd"])
def test_two_parts_are_one_run(kind: str, tmp_path: Path) -> None:
    expected = read_pool_run(write_mcap(tmp_path / "whole.mcap", run()), ROV, tmp_path)
    log = bag(tmp_path / "pool" / "rosbag2_1", kind)
    same(read_pool_run(log, ROV, tmp_path), expected)


def test_a_folder_is_a_run_of_the_workflow(tmp_path: Path) -> None:
    log = bag(tmp_path / "raw" / "rov" / "pool" / "rosbag2_2.a", "mcap")
    pool = log.parent.parent
    (pool / "rosbag2_2.a.yaml").write_text("what: a test\n")
    assert logs_of(pool) == logs_of(log.parent) == [log]
    assert (run_of(log), day_of(log)) == ("rosbag2_2.a", "2023-11-14")
    (one,) = pool_logs(VehicleFolder("rov", "raw/rov"), tmp_path)
    place = "raw/rov/pool/rosbag2_2.a"
    assert one.run == "rosbag2_2.a"
    assert one.inputs == (
        f"{place}/metadata.yaml",
        f"{place}.yaml",
        f"{place}/bag_0.mcap",
        f"{place}/bag_1.mcap",
    )
    notes = read_pool_run(log, ROV, tmp_path).notes
    assert notes is not None
    assert notes.what == "a test"


def test_a_part_that_is_missing(tmp_path: Path) -> None:
    log = bag(tmp_path / "rosbag2_3", "mcap")
    (log.parent / "bag_1.mcap").unlink()
    found = read_pool_run(log, ROV, tmp_path)
    assert not found.complete
    assert "the part bag_1.mcap of the bag is left out" in str(found.problems)
    (log.parent / "bag_0.mcap").unlink()
    with pytest.raises(InputError, match="no part of the bag can be read"):
        read_pool_run(log, ROV, tmp_path)


@pytest.mark.parametrize("text", ["", "a: [", "rosbag2_bagfile_information: 5", "- 1\n- 2"])
def test_metadata_of_any_content(text: str, tmp_path: Path) -> None:
    path = tmp_path / "rosbag2_4" / "metadata.yaml"
    path.parent.mkdir()
    path.write_text(text)
    with pytest.raises(InputError, match="metadata of the bag"):
        read_pool_run(path, ROV, tmp_path)
    assert day_of(path) == "undated"
