"""The page that describes pool-run logs is enough: its writer and its mapping are run."""

import re
import subprocess
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from pool_logs import rov

from pipeline.ingest.pool_run import read_pool_run
from pipeline.records.pool_run import BallastItem, RunEvent, RunNotes, TetherNotes, WaterNotes
from pipeline.records.pool_schema import UNITS, PoolChannel, PoolColumns
from pipeline.records.run_arrays import LEFT_OUT_OF_TABLES, MARKS
from pipeline.records.run_table import QUANTITIES
from pipeline.records.trial import ManoeuvreName
from pipeline.vehicle.run_notes import read_run_notes
from pipeline.vehicle.yaml_text import parse


@pytest.fixture(name="page", scope="module")
def page_fixture(repository: Path) -> str:
    return (repository / "docs" / "pool_runs.md").read_text(encoding="utf-8")


def test_the_small_writer_needs_nothing_but_a_vehicle_file(
    repository: Path, tmp_path: Path
) -> None:
    script = repository / "docs/examples/write_json_log.py"
    subprocess.run([sys.executable, str(script)], cwd=tmp_path, check=True)
    run = read_pool_run(tmp_path / "run.mcap", rov(), tmp_path)
    assert set(run.channels) == {"thruster_command", "angular_velocity", "specific_force", "depth"}
    assert run.channels["thruster_command"].columns == ("command.port", "command.starboard")
    time_s = np.arange(1000) / 50
    np.testing.assert_allclose(
        run.channels["depth"].values[:, 0], 2.0 + 0.1 * np.sin(0.2 * time_s), rtol=1e-15
    )
    assert {p.what for p in run.problems if p.severity != "note"} == {
        "there are no commands for bow, side.",
        "angular_velocity (/imu): p_radps, q_radps never changes.",
        "specific_force (/imu): fy_mps2, fz_mps2 never changes.",
    }


def test_the_mapping_shown_is_accepted(page: str) -> None:
    text = page.split("```yaml\n")[1].split("```", maxsplit=1)[0]
    columns = PoolColumns.model_validate(parse(text.encode(), "page").plain()["pool"])
    assert len(columns.channels) == 5
    assert columns.channels[1].clock_unit == "ms"


def test_the_page_knows_every_key_quantity_unit_and_mark(page: str) -> None:
    for name in (*PoolChannel.model_fields, *PoolColumns.model_fields):
        assert f"`{name}`" in page, name
    for quantity, units in UNITS.items():
        row = re.search(rf"^\| `{quantity}` \|.*$", page, re.MULTILINE)
        assert row is not None, quantity
        if "the same" not in row[0]:
            for unit in units:
                assert f"`{unit}`" in row[0], (quantity, unit)
    for mark in MARKS:
        row = re.search(rf"^\| `{mark}` \|.*\|(.*)\|$", page, re.MULTILINE)
        assert row is not None, mark
        assert (row[1].strip() == "yes") == (mark in LEFT_OUT_OF_TABLES), mark


def test_the_notes_shown_are_accepted_and_complete(page: str, tmp_path: Path) -> None:
    text = page.split("```yaml\n")[2].split("```", maxsplit=1)[0]
    (tmp_path / "run.yaml").write_text(text, encoding="utf-8")
    notes = read_run_notes(tmp_path / "run.yaml", "run.yaml")
    assert notes.who == ("Ivanova", "Petrov")
    stated = RunNotes.model_fields.keys() - {"file"}
    for model in (BallastItem, RunEvent, WaterNotes, TetherNotes):
        stated |= model.model_fields.keys()
    for key in stated:
        assert f"{key}: " in text, key


def test_the_page_knows_every_quantity_of_the_table_and_every_manoeuvre(page: str) -> None:
    for name in (*QUANTITIES, *get_args(ManoeuvreName)):
        assert f"`{name}`" in page, name
