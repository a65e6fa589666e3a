"""From ``rig2sea new`` to tables: check a blank folder, fill in a form, run."""

import contextlib
import json
from pathlib import Path

from click.testing import CliRunner, Result
from openpyxl import load_workbook
from shared_runs import rig2sea

from pipeline.cli import cli


def command(folder: Path, *arguments: str) -> Result:
    with contextlib.chdir(folder):
        return CliRunner().invoke(cli, arguments, prog_name="rig2sea")


def test_new_vehicle_becomes_tables(tmp_path: Path) -> None:
    new = command(tmp_path, "new", "boat")
    assert new.exit_code == 0, new.stderr
    assert "raw/boat/README.md" in new.stdout
    again = command(tmp_path, "new", "boat")
    assert (again.exit_code, again.stdout) == (1, "")
    assert again.stderr.startswith("error: raw/boat: is there already")
    assert command(tmp_path, "new", "../boat").exit_code == 2

    check = command(tmp_path, "check", "boat")
    assert check.exit_code == 0, check.stdout
    assert check.stdout.count("no data yet") == 3

    form = tmp_path / "raw/boat/mooring/mooring.xlsx"
    workbook = load_workbook(form)
    for code in (0, *range(30, 121, 10), 0, *range(-30, -121, -10), 0):
        workbook.worksheets[0].append((code, round(0.002 * code * abs(code), 3)))
    workbook.save(form)
    run = rig2sea(tmp_path, "run", "boat")
    assert run.returncode == 0, run.stdout + run.stderr
    tables = json.loads((tmp_path / "processed/boat/tables.json").read_text(encoding="utf-8"))
    assert tables["table3"]["positive"] is not None
    assert tables["table1"] is None
    assert (tmp_path / "reports/boat/index.html").exists()
