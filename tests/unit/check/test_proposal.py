"""What was understood of bench files, as lines of vehicle.yaml, and written into it."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from pipeline.cli import cli
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.write_back import with_columns

VEHICLE = """\
name: thr  # a comment that stays
title: a thruster
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {screw: {diameter_m: 0.14}}
drives: {motor: {code_min: -127, code_max: 127}}
tables: {propeller: screw, drive: motor}
"""
ROWS = "Code,Dir,Thrust (N),Lamp (lx)\n0,FWD,0,1\n40,FWD,6,1\n80,FWD,20,2\n127,FWD,42,3\n"
BACK = "0,REV,0,1\n40,REV,5,1\n80,REV,15,2\n127,REV,31,2\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "thr" / "mooring").mkdir(parents=True)
    (tmp_path / "thr" / "vehicle.yaml").write_text(VEHICLE, encoding="utf-8")
    (tmp_path / "thr" / "mooring" / "a.csv").write_text(ROWS + BACK, encoding="utf-8")
    return tmp_path / "thr"


def run(*arguments: str, answer: str = "") -> str:
    return CliRunner().invoke(cli, ["check", *arguments], input=answer).output


def test_every_column_is_used_or_named_with_the_reason(folder: Path) -> None:
    said = run(str(folder))
    assert "column D 'Lamp (lx)': not used, no quantity of this kind of test" in said
    assert 'direction: {header: "Dir", reverse: ["REV"]}' in said
    assert (folder / "vehicle.yaml").read_text(encoding="utf-8") == VEHICLE


def test_written_after_showing_the_difference(folder: Path) -> None:
    said = run(str(folder), "--write", answer="y\n")
    assert '+    thrust: {header: "Thrust (N)", unit: "N"}' in said
    text = (folder / "vehicle.yaml").read_text(encoding="utf-8")
    assert text.startswith(VEHICLE)
    columns = load_vehicle(folder).columns.mooring
    assert columns.direction is not None
    assert columns.direction.reverse == ("REV",)
    again = run(str(folder), "--write", "--yes")
    assert "states every column already" in again
    assert "codes -127 to 127" in again


def test_nothing_is_written_without_a_yes(folder: Path) -> None:
    run(str(folder), "--write", answer="n\n")
    assert (folder / "vehicle.yaml").read_text(encoding="utf-8") == VEHICLE


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("columns: {load_test: {warm_up_s: 9}}\n", "mooring: {code: {header: N}}, load_test"),
        ("columns:\n  mooring:\n    code: {header: X}\n", "code: {header: X}\n"),
        ("columns:\n  load_test:\n    warm_up_s: 9\n", "  mooring:\n    code: {header: N}\n"),
    ],
)
def test_what_is_stated_stays(before: str, after: str) -> None:
    text = with_columns(VEHICLE + before, {"mooring": {"code": "{header: N}"}})
    assert after in text
    assert text.startswith(VEHICLE)
