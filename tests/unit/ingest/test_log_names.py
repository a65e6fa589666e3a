"""A log is one by its name, however its recorder writes the ending."""

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.ingest.log_files import log_beside, logs_of
from pipeline.inputs.runs_to_identify import find_logs
from pipeline.inputs.simulated_vehicle import load_simulated
from pipeline.plan import UsageError


@pytest.fixture
def pool(tmp_path: Path) -> Path:
    folder = tmp_path / "boat/pool"
    folder.mkdir(parents=True)
    for name in ("a.mcap", "dive.MCAP", "dive.yaml", "lone.yaml", "b.csv"):
        (folder / name).touch()
    (folder / "folder.mcap").mkdir()
    return folder


def test_logs_and_their_notes(pool: Path) -> None:
    assert [log.name for log in logs_of(pool)] == ["a.mcap", "b.csv", "dive.MCAP"]
    assert logs_of(pool / "nowhere") == []
    assert log_beside(pool / "dive.yaml") == pool / "dive.MCAP"
    assert log_beside(pool / "lone.yaml") is None
    assert log_beside(pool / "dive.yaml", [pool / "a.mcap"]) is None


def test_a_run_is_found_by_its_name(pool: Path) -> None:
    boat = replace(load_simulated("rov8", Path("raw"), Path()), file=pool.parent / "vehicle.yaml")
    assert find_logs(["dive"], boat) == [pool / "dive.MCAP"]
    assert find_logs(["dive.MCAP"], boat) == [pool / "dive.MCAP"]
    assert find_logs([str(pool)], boat) == [pool / "a.mcap", pool / "b.csv", pool / "dive.MCAP"]
    with pytest.raises(
        UsageError, match=r'no run "dve".*Did you mean "dive"\? There are a, b, dive'
    ):
        find_logs(["dve"], boat)
