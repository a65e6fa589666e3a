"""Logs are read back as the tables say; labels stay sealed."""

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.blind.generate import GeneratedCase
from pipeline.blind.label import open_label, seal
from pipeline.campaign.blind_case import write_case
from pipeline.errors import InputError
from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_resample import resample
from pipeline.vehicle.load import load_vehicle


def test_the_log_says_what_the_table_says(sagging: GeneratedCase, tmp_path: Path) -> None:
    write_case(sagging, "case", tmp_path / "cases", tmp_path / "sealed")
    vehicle = load_vehicle(tmp_path / "cases" / "case")
    path = tmp_path / "cases" / "case" / "pool" / "run_1.mcap"
    read = resample(read_pool_run(path, vehicle, tmp_path), 50.0)
    table = sagging.runs[0]
    assert read.thrusters == table.thrusters
    assert read.start_time_ns == table.start_time_ns
    assert set(read.values) == set(table.values)
    for quantity, values in table.values.items():
        count = min(len(values), len(read.time_s))
        both = table.valid[quantity][:count] & read.valid[quantity][:count]
        assert both.mean() > 0.9
        # the voltage is single precision in its message
        np.testing.assert_allclose(
            read.values[quantity][:count][both], values[:count][both], atol=2e-6
        )


def test_nothing_beside_the_sealed_label_tells_the_truth(
    sagging: GeneratedCase, tmp_path: Path
) -> None:
    write_case(sagging, "case", tmp_path / "cases", tmp_path / "sealed")
    for path in tmp_path.rglob("*"):
        if path.is_file():
            assert b"voltage_sag" not in path.read_bytes()


def test_a_label_opens_after_the_verdict(
    sagging: GeneratedCase, tmp_path: Path, verdict_file: Path
) -> None:
    seal(sagging.label, tmp_path / "label.json")
    assert open_label(tmp_path / "label.json", verdict_file) == sagging.label


def test_a_label_stays_sealed_without_a_verdict(sagging: GeneratedCase, tmp_path: Path) -> None:
    seal(sagging.label, tmp_path / "label.json")
    with pytest.raises(InputError, match="stays sealed"):
        open_label(tmp_path / "label.json", tmp_path / "none.json")


@pytest.mark.parametrize("change", ["sha256", "sealed"])
def test_a_changed_label_is_noticed(
    sagging: GeneratedCase, tmp_path: Path, verdict_file: Path, change: str
) -> None:
    path = tmp_path / "label.json"
    seal(sagging.label, path)
    content = json.loads(path.read_text())
    content[change] = "0" * 64
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match="cannot be opened"):
        open_label(path, verdict_file)
