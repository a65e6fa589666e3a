"""`rig2sea reference`: which runs, what is written, what is said."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner, Result

from pipeline.cli import cli
from pipeline.diagnose.reference.made import Made
from pipeline.errors import CannotComputeError
from pipeline.provenance import file_digest, read_envelope
from pipeline.records.identification import RunRead
from pipeline.records.reference import AxisForce, Departure, Prediction, ReferenceRecord
from pipeline.stages import reference
from pipeline.stages.reference import reference_used
from pipeline.stages.simulated_vehicle import load_simulated

FORCE = AxisForce(
    unit="N",
    lacked=4.0,
    left=2.0,
    left_in_run=1.0,
    same_share=0.75,
    outside=1.5,
    outside_of_file=0.2,
)
MADE = Made(
    used=False,
    why="the last value predicts it no worse.",
    windows=8,
    gain_per_window=12.0,
    axes={"heave": FORCE},
    departures=tuple(
        Departure(
            name=name,
            kind="constant",
            axis="heave",
            unit="N",
            value=2.0,
            ci95=ci95,
            neutral=0.0,
            scatter=0.5,
        )
        for name, ci95 in (("constant:heave", (1.0, 3.0)), ("constant:sway", (-1.0, 5.0)))
    ),
    noise={},
    held_out="half of each run in turn",
    predictions=(
        Prediction(
            method="reference", quantity="velocity", unit="m/s", ahead_s=3.0, rmse=0.1, readings=9
        ),
    ),
)


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Two logs whose content nobody looks into."""
    monkeypatch.chdir(tmp_path)
    paths = [tmp_path / name for name in ("a.mcap", "b.mcap")]
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

    monkeypatch.setattr(reference, "read_run", read)
    monkeypatch.setattr(reference, "made", lambda *_: MADE)
    return paths


def ran(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["reference", "rov8", *arguments], prog_name="rig2sea")


def test_it_is_written_with_digests_and_told(logs: list[Path]) -> None:
    result = ran("a.mcap", "b.mcap")
    assert result.exit_code == 0, result.output
    assert "heave         4 N      75%" in result.stdout
    assert "constant:heave 2 [1, 3] N" in result.stdout
    assert "constant:sway" not in result.stdout
    assert "The reference is NOT used: the last value predicts it no worse." in result.stdout
    envelope = read_envelope(Path("processed/rov8/reference.json"), "reference", ReferenceRecord)
    assert envelope.record is not None
    assert [run.name for run in envelope.record.runs] == ["a", "b"]
    assert {path.name: file_digest(path) for path in logs}.items() <= envelope.inputs.items()


def test_its_json_is_the_record_and_its_folder_can_be_chosen(logs: list[Path]) -> None:
    result = ran(logs[0].name, logs[1].name, "--to", "here", "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["gain_per_window"] == 12.0
    assert Path("here/reference.json").is_file()


@pytest.mark.parametrize("runs", [(), ("a.mcap",)])
def test_of_fewer_than_two_runs_it_says_what_to_do(logs: list[Path], runs: tuple[str]) -> None:
    assert logs
    result = ran(*runs)
    assert result.exit_code == 1
    assert f"rov8 has {'one run that is' if runs else 'no run that is'} known" in result.stderr
    assert "`healthy: true`" in result.stderr


def test_a_reference_that_is_no_good_is_not_used_for_the_runs_it_is_of(logs: list[Path]) -> None:
    one = load_simulated("rov8", Path("raw"), Path())
    assert reference_used(one, logs, Path()) == (False, None)
    ran("a.mcap", "b.mcap")
    used, told = reference_used(one, logs, Path())
    assert not used
    assert told is not None
    assert told.endswith("the last value predicts it no worse.")
    assert reference_used(one, logs[:1], Path()) == (False, None)


def test_what_cannot_be_learned_is_said(logs: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> Made:
        raise CannotComputeError("that is all.")

    monkeypatch.setattr(reference, "made", refuse)
    result = ran(*(path.name for path in logs))
    assert (result.exit_code, result.stderr.splitlines()[-1]) == (1, "error: that is all.")
