"""`rig2sea reference`: which runs, what is written, what is said."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner, Result

from pipeline.actions import reference
from pipeline.cli import cli
from pipeline.errors import CannotComputeError
from pipeline.inputs import runs_to_identify
from pipeline.provenance import file_digest, read_envelope
from pipeline.records.identification import RunRead
from pipeline.records.reference import Prediction, ReferenceRecord, Width

LEARNED = SimpleNamespace(
    used=False,
    why="the vehicle file predicts it no worse.",
    best=SimpleNamespace(response=SimpleNamespace(period_s=0.2), trusted=0.5),
    force={"u": {"surge": 0.05}},
    widths=(
        Width(name="thrust_deduction:t", unit="1", stated=0.1, learned=0.15),
        Width(name="residual_buoyancy:force_n", unit="N", stated=2.0, learned=1.0),
    ),
    table=(
        Prediction(
            method="reference", quantity="velocity", unit="m/s", ahead_s=3.0, rmse=0.1, readings=9
        ),
    ),
)


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Three logs whose content nobody looks into."""
    monkeypatch.chdir(tmp_path)
    paths = [tmp_path / name for name in ("a.mcap", "b.mcap", "c.mcap")]
    for path in paths:
        path.write_text(path.name)

    def read(path: Path, *_: object) -> tuple[RunRead, object]:
        run = RunRead(
            name=path.stem,
            file=str(path),
            sha256=file_digest(path),
            seconds=20.0,
            quantities=("velocity",),
            warnings=(),
        )
        return run, SimpleNamespace(name=path.stem)

    monkeypatch.setattr(runs_to_identify, "read_run", read)
    monkeypatch.setattr(reference, "learned", lambda *_: LEARNED)
    return paths


def ran(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["reference", "rov8", *arguments], prog_name="rig2sea")


def test_it_is_written_with_digests_and_told(logs: list[Path]) -> None:
    result = ran("a.mcap", "b.mcap", "c.mcap")
    assert result.exit_code == 0, result.output
    assert "thrust_deduction:t 0.15 (0.1)" in result.stdout
    assert "residual_buoyancy:force_n 1 N (2 N)" in result.stdout
    assert "The reference is NOT used: the vehicle file predicts it no worse." in result.stdout
    envelope = read_envelope(Path("processed/rov8/reference.json"), "reference", ReferenceRecord)
    assert envelope.record is not None
    assert [run.name for run in envelope.record.runs] == ["a", "b", "c"]
    assert {path.name: file_digest(path) for path in logs}.items() <= envelope.inputs.items()


def test_its_json_is_the_record_and_its_folder_can_be_chosen(logs: list[Path]) -> None:
    result = ran(*(path.name for path in logs), "--to", "here", "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["noise_trusted"] == 0.5
    assert Path("here/reference.json").is_file()


@pytest.mark.parametrize("runs", [(), ("a.mcap",)])
def test_of_too_few_runs_it_says_what_to_do(logs: list[Path], runs: tuple[str]) -> None:
    assert logs
    result = ran(*runs)
    assert result.exit_code == 1
    assert f"rov8 has {'one run that is' if runs else 'no run that is'} known" in result.stderr
    assert "`healthy: true`" in result.stderr


def test_what_cannot_be_learned_is_said(logs: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise CannotComputeError("that is all.")

    monkeypatch.setattr(reference, "learned", refuse)
    result = ran(*(path.name for path in logs))
    assert (result.exit_code, result.stderr.splitlines()[-1]) == (1, "error: that is all.")
