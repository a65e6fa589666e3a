"""`diagnose` and `identify` tell what they are doing, on standard error."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pipeline.actions import diagnosis, identification
from pipeline.cli import cli
from pipeline.diagnose.engine import Diagnosis
from pipeline.effects.library import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.inputs import runs_to_identify
from pipeline.records.run_table import RunTable


def no_more(*_: object) -> None:
    raise CannotComputeError("that is all.")


def told(*arguments: str) -> list[str]:
    result = CliRunner().invoke(cli, arguments, prog_name="rig2sea")
    assert result.exit_code == 1
    assert result.stdout == ""
    *lines, last = result.stderr.splitlines()
    assert last == "error: that is all."
    return lines


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Two logs that nobody looks into."""
    monkeypatch.chdir(tmp_path)
    for name in ("a.mcap", "b.mcap"):
        (tmp_path / name).touch()
    return ["a.mcap", "b.mcap"]


def test_identify_tells(logs: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    class Read:
        file = "a.mcap"

    monkeypatch.setattr(runs_to_identify, "read_run", lambda *_: (Read(), None))
    monkeypatch.setattr(identification, "_whole", no_more)
    read = ["reading a.mcap", "reading b.mcap"]
    assert told("identify", "rov8", *logs) == [*read, "fitting the vehicle to the runs (2)"]
    assert told("identify", "rov8", *logs, "--method", "straight-line") == read


def test_diagnose_tells(logs: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    found = Diagnosis(diagnosis_records.diagnosis(channels=("w",), windows=1), ())
    spec = EffectSpec("residual_buoyancy", {"force_n": 5.0})
    table = RunTable("run", np.zeros(0), {}, {})
    monkeypatch.setattr(runs_to_identify, "read_run", lambda *_: (None, table))
    monkeypatch.setattr(diagnosis, "diagnose_fully", lambda *_: replace(found, specs=(spec,)))
    monkeypatch.setattr(diagnosis, "simulate_to_file", no_more)
    monkeypatch.setattr(diagnosis, "write_page", no_more)
    assert told("diagnose", "rov8", *logs[:1], "--holdout", *logs[1:]) == [
        "reading a.mcap",
        "reading b.mcap",
        "weighing what explains the runs (2)",
        "simulating b.mcap with the effect",
    ]
