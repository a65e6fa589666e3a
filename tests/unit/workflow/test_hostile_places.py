"""Nothing in the working folder is obeyed; what the engine remembers may be any bytes."""

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from pipeline.cli import cli
from pipeline.workflow.start import _environment, forget_engine_state, snakefile


def test_the_engine_looks_for_nothing_in_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", f":{tmp_path}:relative")
    monkeypatch.setenv("SNAKEMAKE_PROFILE", "default")
    environment = _environment(tmp_path / "journal.jsonl")
    assert environment["PYTHONPATH"] == str(tmp_path)
    assert environment["PYTHONSAFEPATH"] == "1"
    assert not [name for name in environment if name.startswith("SNAKEMAKE")]


def test_a_home_that_cannot_be_written_is_no_obstacle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    for variable in ("XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    environment = _environment(tmp_path / "journal.jsonl")
    assert environment["XDG_CACHE_HOME"] == str(tmp_path / "cache")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert "XDG_CACHE_HOME" not in _environment(tmp_path / "journal.jsonl")


def test_modules_beside_the_data_are_not_imported(tmp_path: Path) -> None:
    for name in ("numpy.py", "queue.py", "click.py"):
        (tmp_path / name).write_text("raise SystemExit('imported')\n")
    done = subprocess.run(
        [sys.executable, "-m", "pipeline", "--version"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout.split()[0]) == (0, "rig2sea,")


def test_the_rules_quote_the_interpreter() -> None:
    """An environment may lie in a path with a blank."""
    assert "PYTHON = shlex.quote(sys.executable)" in snakefile().read_text(encoding="utf-8")


def test_what_the_engine_remembers_is_forgotten_but_for_its_logs(tmp_path: Path) -> None:
    state = tmp_path / ".snakemake"
    state.write_bytes(b"")
    forget_engine_state(tmp_path)
    assert not state.exists()
    for room in ("metadata", "incomplete", "log"):
        (state / room).mkdir(parents=True)
        (state / room / "bytes").write_bytes(b"\xff\x00\x81")
    forget_engine_state(tmp_path)
    assert [path.name for path in state.iterdir()] == ["log"]


@pytest.mark.parametrize(
    "words",
    [
        "validate boat --to raw/boat/vehicle.yaml",
        "export boat --to raw/boat/mooring",
        "simulate raw/boat --manoeuvre hover --to raw/boat/pool/x.mcap",
        "identify {lab} run.mcap --to {lab}/pool/out",
        "validate {lab} --to {lab}/vehicle.yaml",
        "design tether cable.yaml --to raw/boat",
    ],
)
def test_no_command_writes_among_raw_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("raw/boat/mooring", "lab/pool"):
        (tmp_path / folder).mkdir(parents=True)
    for file in ("raw/boat/vehicle.yaml", "lab/vehicle.yaml"):
        (tmp_path / file).write_text("name: boat\n")
    before = sorted(tmp_path.rglob("*"))
    done = CliRunner().invoke(cli, words.format(lab=tmp_path / "lab").split())
    assert done.exit_code == 2
    assert "raw data lie there" in done.output
    assert sorted(tmp_path.rglob("*")) == before
