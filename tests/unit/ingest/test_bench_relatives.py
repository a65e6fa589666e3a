"""Tables that read well and say, somewhere beside the numbers, that they mean something else."""

from pathlib import Path

import numpy as np
import pytest
from bench_workbooks import vehicle, write_workbook

from pipeline.check.bench_files import READERS, RawRecord

SHARE = np.linspace(-1.0, 1.0, 21)
CODE = np.round(127.0 * SHARE)
THRUST = 40.0 * np.sign(SHARE) * np.clip((np.abs(SHARE) - 0.06) / 0.94, 0.0, None) ** 1.8
Rows = list[list[object]]


def rows_of(head: str, *columns: object) -> Rows:
    rows = zip(*(np.asarray(one, object) for one in columns), strict=True)
    return [[*head.split(";")], *map(list, rows)]


def read(tmp_path: Path, kind: str, rows: Rows, sheet: str = "Data") -> RawRecord:
    path = write_workbook(tmp_path / kind / "a.xlsx", {sheet: rows})
    return READERS[kind]([path], vehicle(), tmp_path)


def said(record: RawRecord, severity: str) -> str:
    return "\n".join(one.what for one in record.problems if one.severity == severity)


@pytest.mark.parametrize(
    ("title", "sheet"),
    [
        ("Force in kg, time in s", "Data"),
        ("Values in lbf", "Data"),
        ("Thrust [gf] over the code", "Data"),
        ("Упор в кгс", "Data"),
        ("", "lbf"),
        ("", "Thrust kgf"),
    ],
)
def test_a_unit_beside_the_table_contradicts_its_names(
    title: str, sheet: str, tmp_path: Path
) -> None:
    record = read(tmp_path, "mooring", [[title], *rows_of("Code;Thrust (N)", CODE, THRUST)], sheet)
    assert "it states N, " in said(record, "error")
    assert not record.points


@pytest.mark.parametrize(
    ("title", "sheet"),
    [("Thrust in N, test 3 at 16 V, range 500 kgf", "A"), ("Thruster A, tank N, 20 kg", "N")],
)
def test_a_size_or_a_letter_beside_the_table_is_no_unit(
    title: str, sheet: str, tmp_path: Path
) -> None:
    record = read(tmp_path, "mooring", [[title], *rows_of("Code;Thrust (N)", CODE, THRUST)], sheet)
    assert len(record.points) == CODE.size
    assert not said(record, "warning")


def test_a_command_over_microseconds(tmp_path: Path) -> None:
    rows = rows_of("Command;Thrust", 1500 + 400 * SHARE, THRUST)
    record = read(tmp_path, "mooring", [rows[0], ["us", "N"], *rows[1:]])
    assert [one.code for one in record.points] == pytest.approx(127 * SHARE)
