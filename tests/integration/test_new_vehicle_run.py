"""From ``rig2sea new`` to tables: check a blank folder, fill in a form, run."""

import json
from pathlib import Path

from openpyxl import load_workbook
from shared_runs import rig2sea


def test_new_vehicle_becomes_tables(tmp_path: Path) -> None:
    new = rig2sea(tmp_path, "new", "boat")
    assert new.returncode == 0, new.stderr
    assert "raw/boat/README.md" in new.stdout
    again = rig2sea(tmp_path, "new", "boat")
    assert (again.returncode, again.stdout) == (1, "")
    assert again.stderr.startswith("error: raw/boat: is there already")
    assert rig2sea(tmp_path, "new", "../boat").returncode == 2

    check = rig2sea(tmp_path, "check", "boat")
    assert check.returncode == 0, check.stdout
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
