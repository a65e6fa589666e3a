"""The command line: help, exit codes, one message and never a traceback."""

import errno
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from pipeline import __version__
from pipeline.cli import cli

VEHICLE = """\
name: boat
title: boat
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {p: {diameter_m: 0.1}}
drives: {d: {code_min: -127, code_max: 127}}
tables: {propeller: p, drive: d}
"""

DISK_FULL = "The disk is full: free some space and run again. What is finished is kept."


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with one vehicle, one good mooring table and one that is no workbook."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "raw/boat/mooring"
    folder.mkdir(parents=True)
    (tmp_path / "raw/boat/vehicle.yaml").write_text(VEHICLE)
    rows = [f"{code};{0.002 * code * abs(code):.3f}" for code in range(-120, 121, 20)]
    (folder / "good.csv").write_text("код;упор, Н\n" + "\n".join(rows) + "\n", encoding="utf-8")
    (folder / "bad.xlsx").write_bytes(b"PK\x03\x04 cut short")
    return tmp_path


def call(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments, prog_name="rig2sea")


@pytest.mark.parametrize("command", ["run", "check", "export", "simulate", "effects"])
def test_every_command_has_help_with_an_example(command: str) -> None:
    result = call(command, "--help")
    assert result.exit_code == 0
    assert f"  rig2sea {command} " in result.output
    assert command in call("--help").output


@pytest.mark.parametrize("command", ["", *sorted(set(cli.commands) - {"stages"})])
def test_examples_stand_on_lines_of_their_own(command: str) -> None:
    text = call(*command.split(), "--help").output
    assert "\\b" not in text
    lines = text.splitlines()
    start = next(i for i, line in enumerate(lines) if line.strip() in {"Example:", "Examples:"})
    examples = lines[start + 1 : lines.index("", start)]
    assert examples
    for line in examples:
        assert line.startswith("    rig2sea ")
        assert line.count("rig2sea ") == 1


def test_version() -> None:
    assert call("--version").output.strip().endswith(__version__)


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, pipeline.cli\n"
        "print([m for m in ('numpy', 'pydantic', 'pandas', 'snakemake', 'pint', 'matplotlib')"
        " if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "--cores", "0"),
        ("nonsense",),
        ("check",),
        ("export", "boat"),
        ("check", "absent"),
        ("watch", "absent", "--once"),
    ],
)
@pytest.mark.usefixtures("here")
def test_wrong_usage_ends_with_2(arguments: tuple[str, ...]) -> None:
    result = call(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.output


@pytest.mark.usefixtures("here")
def test_unknown_vehicle_names_the_nearest() -> None:
    result = call("run", "baot")
    assert result.exit_code == 2
    assert 'Did you mean "boat"?' in result.output


@pytest.mark.parametrize(
    "arguments",
    [
        ("export", "baot", "--to", "firmware"),
        ("simulate", "rov8", "--manoeuvre", "hoover", "--to", "a.mcap"),
        ("why", "boat", "table9.KT[0]"),
    ],
)
def test_wrong_usage_names_the_command_that_was_called(
    arguments: tuple[str, ...], here: Path
) -> None:
    from pipeline.provenance import tables_text

    (here / "processed/boat").mkdir(parents=True)
    (here / "processed/boat/tables.json").write_text(tables_text({}, inputs={}, code=""))
    result = call(*arguments)
    assert result.exit_code == 2
    assert result.output.startswith(f"Usage: rig2sea {arguments[0]} [OPTIONS] ")
    assert f"Try 'rig2sea {arguments[0]} --help'" in result.output


@pytest.mark.usefixtures("here")
def test_wrong_usage_of_no_command_names_none() -> None:
    assert call("nonsense").output.startswith("Usage: rig2sea [OPTIONS] COMMAND")


@pytest.mark.parametrize("command", [("run",), ("watch", "--once")])
def test_no_vehicle_at_all_is_one_message(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = call(*command)
    assert result.exit_code == 1
    assert "raw: holds no vehicle." in result.output
    assert list(tmp_path.iterdir()) == []


def test_output_that_cannot_be_written_is_one_message(here: Path) -> None:
    (here / "file").touch()
    result = call("run", "--out", "file")
    assert result.exit_code == 1
    assert "cannot be written" in result.output
    assert "Traceback" not in result.output


def test_unusable_vehicle_file_is_one_message_with_its_line(here: Path) -> None:
    (here / "raw/boat/vehicle.yaml").write_text(VEHICLE.replace("title", "titel"))
    result = call("run")
    assert result.exit_code == 1
    assert 'unknown key "titel"' in result.output
    assert 'Did you mean "title"?' in result.output


def test_check_shows_what_was_understood_and_what_is_wrong(here: Path) -> None:
    before = sorted(path for path in here.rglob("*"))
    result = call("check", "raw/boat")
    assert result.exit_code == 1
    assert "'упор, Н': thrust in Н (unit from the header)" in result.output
    assert "thrust_n: -28.8 to 28.8 in" in result.output
    assert "error: raw/boat/mooring/bad.xlsx" in result.output
    assert sorted(path for path in here.rglob("*")) == before


@pytest.mark.usefixtures("here")
def test_check_as_json() -> None:
    result = call("check", "boat", "--json")
    body = json.loads(result.output)
    assert body["schema"] == "rig2sea/check/1"
    assert body["ok"] is False
    good = next(file for file in body["files"] if file["file"].endswith("good.csv"))
    assert good["kind"] == "mooring"
    assert good["ranges"]["thrust_n"]["max"] == 28.8
    problem = next(p for p in body["problems"] if p["severity"] == "error")
    assert problem["file"] == "raw/boat/mooring/bad.xlsx"


def test_check_of_a_good_file_ends_with_0(here: Path) -> None:
    assert call("check", "raw/boat/mooring/good.csv").exit_code == 0
    (here / "lone").mkdir()
    lone = here / "lone/table.csv"
    lone.write_bytes((here / "raw/boat/mooring/good.csv").read_bytes())
    result = call("check", str(lone))
    assert result.exit_code == 0
    assert "mooring (recognised by its content)" in result.output
    assert "are assumed for this check alone" in result.output


def test_fault_of_our_own_is_one_message_and_a_log(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fault(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("pipeline.check.files.check_paths", fault)
    monkeypatch.setattr(tempfile, "tempdir", str(here))
    result = call("check", "raw/boat")
    assert result.exit_code == 1
    assert "Traceback" not in result.output
    assert "a fault of rig2sea itself (ZeroDivisionError: division by zero)" in result.output
    (log,) = here.glob("rig2sea-error-*.log")
    assert f"The details are in {log}." in result.output
    assert "Traceback" in log.read_text()


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (
            PermissionError(errno.EACCES, "Permission denied", "raw/boat/pool"),
            "raw/boat/pool: cannot be used: Permission denied.\nMend that, then run again.",
        ),
        (
            OSError(errno.ENOSPC, "No space left on device"),
            "rig2sea: cannot go on: No space left on device.\n" + DISK_FULL,
        ),
    ],
)
def test_place_that_cannot_be_used_is_no_fault_of_our_own(
    fault: OSError, said: str, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder of somebody else, a full disk: nobody is to be asked to report that."""

    def look(*_: object, **__: object) -> None:
        raise fault

    monkeypatch.setattr("pipeline.check.files.check_paths", look)
    monkeypatch.setattr(tempfile, "tempdir", str(here))
    result = call("check", "raw/boat")
    assert result.exit_code == 1
    assert result.stderr == f"error: {said}\n"
    assert list(here.glob("rig2sea-error-*")) == []


def test_name_that_no_file_can_have_is_one_message() -> None:
    result = call("run", "x" * 300)
    assert result.exit_code == 1
    assert result.stderr.endswith(
        "/vehicle.yaml: cannot be used: File name too long.\nMend that, then run again.\n"
    )


def test_stage_that_does_not_exist_is_no_traceback_for_the_journal(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RIG2SEA_JOURNAL", str(here / "journal.jsonl"))
    step = {"vehicle": "", "stage": "nothing", "item": "", "code": "", "inputs": []}
    (here / "work.json").write_text(json.dumps([{**step, "outputs": ["x.json"]}]))
    assert call("stages", "work.json", "--done", "done").exit_code == 1
    assert not (here / "done").exists()
    events = [json.loads(line) for line in (here / "journal.jsonl").read_text().splitlines()]
    assert [event["what"] for event in events] == ["started", "failed"]
    assert "ModuleNotFoundError" in events[1]["text"]


@pytest.mark.parametrize(
    ("command", "where", "said"),
    [
        ("run", "pipeline.workflow.run.run", "Stopped. The next run goes on from here.\n"),
        ("simulate", "pipeline.actions.simulation.simulate_to_file", "Stopped.\n"),
    ],
)
@pytest.mark.usefixtures("here")
def test_ctrl_c_says_what_the_next_start_does(
    command: str, where: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(where, stop)
    more = ("--manoeuvre", "hover", "--to", "a.mcap") if command == "simulate" else ()
    result = call(command, "boat", *more)
    assert result.exit_code == 1
    assert result.stderr == said


@pytest.mark.parametrize(
    ("closed", "file", "code"),
    [("2>&-", "good.csv", 0), ("<&- >&- 2>&-", "good.csv", 0), ("2>&-", "none.csv", 2)],
)
def test_a_closed_stream_changes_no_exit_code(
    here: Path, repository: Path, closed: str, file: str, code: int
) -> None:
    """Without standard error ``check`` ended with 1 whatever the file."""
    command = f"{sys.executable} -m pipeline check {here}/raw/boat/mooring/{file} {closed}"
    done = subprocess.run(["/bin/sh", "-c", command], cwd=repository, check=False)
    assert done.returncode == code
