"""A new vehicle's folder: loads as it is, says that it holds no data, is never written over."""

import errno
import re
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from openpyxl import load_workbook

from pipeline.bundled.new_vehicle import COLUMNS, new_vehicle_files
from pipeline.check.files import check_paths
from pipeline.cli import cli
from pipeline.errors import InputError
from pipeline.plan import RAW_KINDS, UsageError
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.run_notes import read_run_notes
from pipeline.workflow.new import vehicles_to_begin_with, write_new_vehicle

LONGEST = "a" * 48


@pytest.mark.parametrize("name", ["boat", "null", "yes", "e5", "a-b_c", LONGEST])
def test_vehicle_file_loads_as_it_is(tmp_path: Path, name: str) -> None:
    files = write_new_vehicle(name, tmp_path / "raw")
    assert files[0] == tmp_path / "raw" / name / "vehicle.yaml"
    vehicle = load_vehicle(files[0])
    assert (vehicle.name, vehicle.drive.code_max) == (name, 127)
    assert vehicle.thrusters == ()


def test_every_optional_line_is_valid_and_fits_the_rest(tmp_path: Path) -> None:
    path, *_ = write_new_vehicle("boat", tmp_path)
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r"^#(?=\S|  )", "", text, flags=re.MULTILINE), encoding="utf-8")
    vehicle = load_vehicle(path)
    assert vehicle.allocator is not None
    assert len(vehicle.thrusters) == 4
    assert vehicle.columns.load_test.warm_up_s == 10.0
    assert check_paths([str(path)], raw=tmp_path).vehicles[0].notes == ()


def test_template_of_the_notes_is_valid_notes(tmp_path: Path) -> None:
    write_new_vehicle("boat", tmp_path)
    text = (tmp_path / "boat/pool/README.md").read_text(encoding="utf-8")
    notes = tmp_path / "boat/pool/run.yaml"
    notes.write_text(text.partition("```yaml\n")[2].partition("```")[0], encoding="utf-8")
    read = read_run_notes(notes, "boat/pool/run.yaml")
    assert None not in dict(read).values(), "every key is shown"
    assert read.ballast


def test_same_name_gives_the_same_bytes() -> None:
    assert new_vehicle_files("boat") == new_vehicle_files("boat")


def test_check_says_that_there_are_no_data_yet(tmp_path: Path) -> None:
    write_new_vehicle("boat", tmp_path)
    findings = check_paths(["boat"], raw=tmp_path)
    assert not findings.failed
    assert [file.kind for file in findings.files] == list(RAW_KINDS)
    assert {(p.severity, p.what) for p in findings.all_problems} == {
        ("note", "no data yet: the form is still blank.")
    }
    assert len(findings.all_problems) == 3


ROWS: dict[str, list[tuple[object, ...]]] = {
    "load_test": [
        (code, 12 * code - 20 * i, 3e-6 * code**2 * (1 + i))
        for code in (40, 80, 120)
        for i in range(6)
    ],
    "mooring": [(code, 0.002 * code * abs(code)) for code in range(-120, 121, 20)],
    "open_water": [(0.1 * i, 0.139 - 0.015 * i, 0.0171 - 0.0016 * i) for i in range(8)],
}


@pytest.mark.parametrize("kind", RAW_KINDS)
def test_filled_form_is_read(tmp_path: Path, kind: str) -> None:
    write_new_vehicle("boat", tmp_path)
    fill(tmp_path / "boat", kind, ROWS[kind])
    findings = check_paths(["boat"], raw=tmp_path)
    (file,) = [file for file in findings.files if file.kind == kind]
    assert file.points == len(ROWS[kind])
    columns = {column.header: column.unit for sheet in file.sheets for column in sheet.columns}
    assert {name: unit for name, unit in COLUMNS[kind] if unit is not None} == {
        header: unit for header, unit in columns.items() if unit
    }
    said = [str(p) for p in findings.all_problems if p.severity != "note"]
    assert said == []


def fill(folder: Path, kind: str, rows: list[tuple[object, ...]]) -> None:
    """Write rows under the units of a form, as a person would."""
    path = folder / kind / f"{kind}.xlsx"
    workbook = load_workbook(path)
    for row in rows:
        workbook.worksheets[0].append(row)
    workbook.save(path)


@pytest.mark.parametrize(
    "name", ["", ".", "..", "../boat", "a/b", "/boat", "-x", "1st", "ä", "a\n", LONGEST + "a"]
)
def test_name_that_is_none_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match="cannot be the name of a vehicle"):
        write_new_vehicle(name, tmp_path / "raw")
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_is_left_alone(tmp_path: Path) -> None:
    write_new_vehicle("boat", tmp_path)
    mine = tmp_path / "boat/vehicle.yaml"
    mine.write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(InputError, match="is there already; nothing was written"):
        write_new_vehicle("boat", tmp_path)
    assert mine.read_text() == "mine"
    assert sorted(tmp_path.rglob("*")) == before
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    with pytest.raises(InputError, match="link: is there already"):
        write_new_vehicle("link", tmp_path)
    assert not (tmp_path / "nowhere").exists()


def test_file_in_the_place_of_the_raw_folder(tmp_path: Path) -> None:
    (tmp_path / "raw").write_text("in the way")
    with pytest.raises(InputError, match="raw: "):
        write_new_vehicle("boat", tmp_path / "raw")


def test_half_a_folder_is_not_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was in the way of the next try, with a vehicle file that was cut off, perhaps."""
    whole = Path.open

    def full(path: Path, mode: str = "r", **more: Any) -> Any:  # noqa: ANN401 - as Path has it
        if mode == "xb" and path.suffix == ".xlsx":
            raise OSError(errno.ENOSPC, "No space left on device")
        return whole(path, mode, **more)

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(InputError, match="boat: cannot be written: No space left on device"):
        write_new_vehicle("boat", tmp_path)
    monkeypatch.undo()
    assert list(tmp_path.iterdir()) == []
    assert write_new_vehicle("boat", tmp_path)


def test_example_comes_with_its_raw_files(tmp_path: Path) -> None:
    written = write_new_vehicle("mmt300", tmp_path / "raw", example=True)
    folder = tmp_path / "raw/mmt300"
    assert load_vehicle(folder / "vehicle.yaml").name == "mmt300"
    for kind in (*RAW_KINDS, "pool"):
        assert any(path.is_relative_to(folder / kind) for path in written), kind
    with pytest.raises(InputError, match="is there already"):
        write_new_vehicle("mmt300", tmp_path / "raw", example=True)
    with pytest.raises(UsageError, match="There is: mmt300"):
        write_new_vehicle("boat", tmp_path / "raw", example=True)


@pytest.mark.parametrize("like", vehicles_to_begin_with())
def test_a_vehicle_begins_like_a_bundled_one(tmp_path: Path, like: str) -> None:
    (tmp_path / "raw").mkdir()
    said = CliRunner().invoke(cli, ["new", "boat", "--like", like, "--raw", str(tmp_path / "raw")])
    assert said.exit_code == 0
    vehicle = load_vehicle(tmp_path / "raw/boat/vehicle.yaml")
    assert vehicle.name == "boat"
    assert vehicle.model is not None
    assert vehicle.sensors is not None
    assert vehicle.published is None
    assert len(vehicle.thrusters) == {"bluerov2": 6, "remus100": 1, "mmt300": 5}.get(like, 8)


def test_a_vehicle_that_nobody_bundled_is_refused_with_the_names(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match='Did you mean "bluerov2"'):
        write_new_vehicle("boat", tmp_path, like="bluerov")
    assert list(tmp_path.iterdir()) == []


def test_the_command_that_is_named_finds_the_folder(tmp_path: Path) -> None:
    raw = tmp_path / "bench raw"
    said = CliRunner().invoke(cli, ["new", "mmt300", "--example", "--raw", str(raw)]).output
    command = said.splitlines()[-1].partition("Next: rig2sea ")[2]
    assert command == f"run mmt300 --raw '{raw}'"
