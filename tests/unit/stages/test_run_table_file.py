"""A file of tables that is damaged anywhere is named, and is no fault of the program."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import InputError
from pipeline.records.run_table import RunTable
from pipeline.stages.run_table_file import read_tables, write_tables
from pipeline.types import FloatArray


def table_of(**values: FloatArray) -> RunTable:
    """A table of these quantities, all of them valid."""
    rows = len(next(iter(values.values())))
    return RunTable(
        name="run",
        time_s=np.arange(rows) * 0.02,
        values=values,
        valid={quantity: np.ones(rows, bool) for quantity in values},
        notes=("a note",),
        reading={},
        thrusters=("ahead",),
        start_time_ns=0,
        left_out={},
    )


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "tables.npz"
    write_tables(path, {"run": table_of(depth=np.sin(np.arange(500.0))[:, None])})
    return path


def test_tables_come_back(file: Path) -> None:
    found = read_tables(file)["run"]
    assert found.time_s == pytest.approx(np.arange(500) * 0.02)
    assert found.values["depth"][:, 0] == pytest.approx(np.sin(np.arange(500)), abs=1e-6)


def test_coordinates_of_a_country_keep_their_millimetres(tmp_path: Path) -> None:
    """Of UTM, where 32 bits step by half a metre; a missing one does not hide it."""
    position = np.array([4_765_432.0, 351_234.0, 3.0]) + 0.01 * np.arange(50.0)[:, None]
    position[7] = np.nan
    write_tables(tmp_path / "tables.npz", {"run": table_of(position=position)})
    np.testing.assert_array_equal(
        read_tables(tmp_path / "tables.npz")["run"].values["position"], position
    )


def test_any_damage_is_told_or_does_not_matter(file: Path) -> None:
    whole, told = file.read_bytes(), []
    for at in range(0, len(whole), 7):
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            read_tables(file)
        except InputError as error:
            told.append(str(error))
    assert len(told) > 50
    assert all("rig2sea run" in one for one in told)


def test_a_number_of_rows_that_cannot_be_is_refused(file: Path) -> None:
    with zipfile.ZipFile(file) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    about = json.loads(members["about.json"])
    about["tables"]["run"]["rows"] = 10**15
    members["about.json"] = json.dumps(about).encode()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    with pytest.raises(InputError, match="not a whole file of tables"):
        read_tables(file)
