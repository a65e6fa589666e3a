"""Exit codes of commands that did their work without some of the raw files."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner, Result

from pipeline.cli import cli
from pipeline.errors import Place, Problem
from pipeline.plan import VehicleFolder
from pipeline.workflow import one_result
from pipeline.workflow.one_result import OneResult
from pipeline.workflow.start import StoppedError
from pipeline.workflow.watch import Watcher

REFUSED = Problem("error", Place("raw/boat/load_test/a.xlsx"), "is damaged.")


def call(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments, prog_name="rig2sea")


@pytest.mark.parametrize("refused", [(), (REFUSED,)])
def test_validate_ends_with_1_when_a_file_was_refused(
    refused: tuple[Problem, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    record = SimpleNamespace(model_dump=lambda **_: {"flight_s": 40.0})
    boat = VehicleFolder("boat", "raw/boat")
    done = OneResult(boat, Path("validation.json"), record, refused)
    monkeypatch.setattr(one_result, "validated", lambda *_: (done, None))
    result = call("validate", "boat", "--json")
    assert result.exit_code == len(refused)
    assert '"flight_s": 40.0' in result.stdout, "the result is there all the same"
    assert ("error: raw/boat/load_test/a.xlsx: is damaged." in result.stderr) is bool(refused)


@pytest.mark.parametrize(("options", "code"), [((), 0), (("--once",), 1)])
def test_watch_that_was_stopped_has_done_its_work_but_not_with_once(
    options: tuple[str, ...], code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(_: Watcher) -> list[str]:
        raise StoppedError("stopped.")

    monkeypatch.setattr("pipeline.workflow.run.vehicles_to_run", lambda _: None)
    monkeypatch.setattr(Watcher, "look", stopped)
    result = call("watch", *options)
    assert result.exit_code == code
    assert result.stderr == "Stopped watching. The next start goes on from here.\n"


@pytest.mark.parametrize("failed", [False, True])
def test_watch_once_ends_with_1_when_something_failed(
    *, failed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "raw/boat").mkdir(parents=True)
    (tmp_path / "raw/boat/vehicle.yaml").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("pipeline.workflow.run.vehicles_to_run", lambda _: None)
    monkeypatch.setattr(Watcher, "look", lambda _: ["error: boat: failed."] if failed else [])
    monkeypatch.setattr(Watcher, "failed", property(lambda _: failed))
    result = call("watch", "--once", "--settle", "0")
    assert result.exit_code == int(failed)
    assert ("error: boat: failed." in result.stderr) is failed
