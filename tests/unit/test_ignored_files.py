"""Nothing in a folder of raw files is passed over in silence."""

from pathlib import Path

import pytest

from pipeline.check.files import Findings, check_paths

VEHICLE = """\
name: boat
title: boat
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {p: {diameter_m: 0.1}}
drives: {d: {code_min: -127, code_max: 127}}
tables: {propeller: p, drive: d}
"""
MOORING = "code;thrust, N\n0;0\n40;4\n80;14\n120;30\n"


@pytest.fixture
def boat(tmp_path: Path) -> Path:
    """A vehicle folder with one mooring table."""
    folder = tmp_path / "boat"
    for kind in ("mooring", "pool"):
        (folder / kind).mkdir(parents=True)
    (folder / "vehicle.yaml").write_text(VEHICLE)
    (folder / "mooring/a.csv").write_text(MOORING)
    return folder


def check(*paths: Path) -> Findings:
    return check_paths([str(path) for path in paths], raw=Path("raw"))


def said(findings: Findings, severity: str) -> str:
    return "\n".join(str(one) for one in findings.all_problems if one.severity == severity)


def test_folders_with_raw_files_are_pointed_out(boat: Path) -> None:
    for name in ("mooring/day1/b.csv", "mooring/day1/deep/c.xlsx", "pool/2024/base.mcap"):
        (boat / name).parent.mkdir(parents=True, exist_ok=True)
        (boat / name).write_text(MOORING)
    (boat / "mooring/photos").mkdir()
    (boat / "mooring/photos/rig.jpg").write_text("")
    text = said(check(boat), "warning")
    assert "mooring/day1: holds raw files (2) that are not read" in text
    assert "pool/2024: holds raw files (1) that are not read" in text
    assert "Move them into pool/ itself." in text
    assert "photos" not in text
    assert "mooring/day1: holds raw files (2)" in said(check(boat / "mooring"), "warning")


def test_a_link_to_nothing_is_refused_and_the_rest_is_read(boat: Path) -> None:
    (boat / "mooring/bollard-02.xlsx").symlink_to("gone.xlsx")
    findings = check(boat)
    assert "mooring/bollard-02.xlsx: this is no file, or a link" in said(findings, "error")
    assert findings.failed
    assert [file.points for file in findings.files] == [4]


def test_a_link_that_leads_round_is_refused_and_the_rest_is_read(boat: Path) -> None:
    (boat / "mooring/loop.csv").symlink_to("loop.csv")
    for path in (boat, boat / "mooring"):
        findings = check(path)
        assert "mooring/loop.csv: this is no file, or a link" in said(findings, "error")
        assert [file.points for file in findings.files] == [4]


def test_an_empty_folder_with_the_name_of_a_file_is_told(boat: Path) -> None:
    (boat / "mooring/bollard-02.csv").mkdir()
    (boat / "pool/dive.mcap").mkdir()
    text = said(check(boat), "warning")
    assert "mooring/bollard-02.csv: this is a folder, named like a file" in text
    assert "pool/dive.mcap: this is a folder" in text


def test_a_folder_within_hides_no_problem_of_the_whole_folder(boat: Path) -> None:
    (boat / "mooring/a.csv").write_text("code;thrust, N\n40;4\n40;4.1\n")
    (boat / "mooring/day1").mkdir()
    assert "there is one code only" in said(check(boat), "error")


def test_a_folder_as_it_should_be_says_nothing(boat: Path) -> None:
    assert said(check(boat), "error") == ""
    assert "not read" not in said(check(boat), "warning")
