"""A check reads what the workflow reads: the files of one kind of a folder together."""

import json
import os
from pathlib import Path

import pytest

from pipeline.check.files import Findings, check_paths
from pipeline.check.text import as_text, to_json
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.plan import UsageError
from pipeline.vehicle.load import load_vehicle

VEHICLE = """\
name: boat
title: boat
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {p: {diameter_m: 0.14}}
drives: {d: {code_min: -127, code_max: 127}}
tables: {propeller: p, drive: d}
"""


@pytest.fixture
def boat(tmp_path: Path) -> Path:
    """A vehicle folder without raw files."""
    folder = tmp_path / "boat"
    (folder / "load_test").mkdir(parents=True)
    (folder / "vehicle.yaml").write_text(VEHICLE)
    return folder


def load_test(path: Path, scale: float) -> Path:
    rows = [f"{900 * scale - 60 * i:g};{0.1 * scale * i:.3f}" for i in range(12)]
    path.write_text("rpm;torque, N m\n" + "\n".join(rows) + "\n")
    return path


def texts(findings: Findings, severity: str) -> list[str]:
    return [str(problem) for problem in findings.all_problems if problem.severity == severity]


def check(*paths: Path) -> Findings:
    return check_paths([str(path) for path in paths], raw=Path("raw"))


def test_load_test_without_a_code_is_shown(boat: Path) -> None:
    load_test(boat / "load_test/drive.csv", 1.0)
    findings = check(boat)
    assert findings.files[0].codes == {}
    assert "there is no control code" in "".join(texts(findings, "warning"))
    assert "torque_nm: 0 to 1.1 in 12 points" in as_text(findings)
    assert json.loads(to_json(findings))["files"][0]["codes"] == {}


def test_one_code_a_file_is_no_fault_of_the_files(boat: Path) -> None:
    files = [load_test(boat / f"load_test/code_{code:03}.csv", code / 40) for code in (40, 80, 120)]
    for paths in ([boat], [boat / "load_test"], files, files[:1]):
        findings = check(*paths)
        assert not texts(findings, "error")
        assert not texts(findings, "warning")
    assert [file.codes for file in check(boat).files] == [{"40": 12}, {"80": 12}, {"120": 12}]


def test_what_the_folder_lacks_is_said_once_and_only_of_the_whole(boat: Path) -> None:
    for name in ("a_code_40.csv", "b_code_40.csv"):
        load_test(boat / "load_test" / name, 1.0 + 0.01 * len(name[0]) * ord(name[0]))
    alone = check(boat / "load_test/a_code_40.csv")
    assert not [text for text in texts(alone, "error") if "one control code" in text]
    (text,) = texts(check(boat), "error")
    assert text.startswith(f"{boat}/load_test: ")
    assert "one code only (40)" in text


def test_repeats_between_files_are_seen(boat: Path) -> None:
    for name in ("a_code_40.csv", "b_code_40.csv"):
        load_test(boat / "load_test" / name, 1.0)
    assert any("again as in" in text for text in texts(check(boat), "warning"))
    with (boat / "load_test" / "b_code_40.csv").open("a", encoding="utf-8") as stream:
        stream.write("# written again\n")
    assert [file.marks for file in check(boat).files] == [{}, {"duplicate": 12}]


def test_file_in_the_current_folder_is_named_by_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    load_test(tmp_path / "code_40.csv", 1.0)
    monkeypatch.chdir(tmp_path)
    findings = check(Path("code_40.csv"))
    places = {problem.place.file for problem in findings.all_problems}
    assert places == {"code_40.csv", "vehicle.yaml"}
    load_test(tmp_path / "again_code_40.csv", 1.5)
    (text,) = texts(check(Path()), "error")
    assert text.startswith(f"{tmp_path}: ")


def test_kind_and_vehicle_are_found_from_within_the_folder(
    boat: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    load_test(boat / "load_test/code_40.csv", 1.0)
    monkeypatch.chdir(boat / "load_test")
    findings = check(Path("code_40.csv"))
    assert (findings.files[0].kind, findings.files[0].kind_from) == ("load_test", "folder")
    assert [vehicle.name for vehicle in findings.vehicles] == ["boat"]


def test_a_path_named_twice_is_read_once(boat: Path) -> None:
    file = load_test(boat / "load_test/code_40.csv", 1.0)
    findings = check(file, boat, boat / "load_test", file, boat / "vehicle.yaml")
    assert len(findings.files) == 1
    assert not [text for text in texts(findings, "error") if "nothing to check" in text]


def test_empty_folder_holds_nothing(boat: Path) -> None:
    (text,) = texts(check(boat / "load_test"), "error")
    assert text.startswith(f"{boat}/load_test: holds nothing to check.")


def test_one_of_anything_is_said_in_the_singular(boat: Path) -> None:
    (boat / "load_test/code_40.csv").write_text("rpm;torque, N m\n900;0.1\n#800;0.2\n")
    (boat / "mooring").mkdir()
    (boat / "mooring/pull.csv").write_text("code;thrust, N\n0;-0\n-40;-6\n")
    text = as_text(check(boat))
    assert "left out of fits: commented out (1 point)" in text
    assert "torque_nm: 0.1 to 0.1 in 1 point\n" in text
    assert "left out of fits: zero reading (1 point)" in text
    assert "1 points" not in text
    assert "-0 to" not in text
    assert "to -0 " not in text


def test_files_among_the_runs_are_judged_as_a_run_judges_them(boat: Path) -> None:
    pool = boat / "pool"
    pool.mkdir()
    (pool / "list.txt").write_text("dive 1: fine\n")
    (pool / "dive.MCAP").write_bytes(b"no log")
    (pool / "dive.yaml").write_text("operator: A. N. Other\n")
    for path in (boat, pool):
        findings = check(path)
        (warning,) = texts(findings, "warning")
        assert warning.startswith(f"{pool}/list.txt: is no log by its name")
        (error,) = texts(findings, "error")
        assert error.startswith(f"{pool}/dive.MCAP: ")
    alone = check(pool / "list.txt")
    assert not alone.failed
    assert len(texts(alone, "warning")) == 1


def test_names_are_judged_as_a_run_judges_them(boat: Path) -> None:
    """A brace in the name of a log was refused, one in a bench file was read."""
    pool = boat / "pool"
    pool.mkdir()
    for name in ("a{1}.mcap", "readme-2.mcap", "b\t.mcap"):
        (pool / name).write_bytes(b"no log")
    load_test(boat / "load_test/code_40.csv", 1.0)
    load_test(boat / "load_test/code_{50}.csv", 0.9)
    for paths in ((boat,), (pool, boat / "load_test")):
        findings = check(*paths)
        assert [Path(run.file).name for run in findings.runs] == ["a{1}.mcap", "readme-2.mcap"]
        assert [Path(file.file).name for file in findings.files] == ["code_40.csv"]
        refused = [one.split(": ")[0] for one in texts(findings, "error") if "name holds" in one]
        assert sorted(refused) == [f"{boat}/load_test/code_{{50}}.csv", f"{pool}/b?.mcap"]


def test_pipe_is_wrong_usage(boat: Path) -> None:
    os.mkfifo(boat / "pipe.csv")
    with pytest.raises(UsageError, match="is neither a file nor a folder"):
        check(boat / "pipe.csv")


def test_folder_that_a_run_refuses_is_told(boat: Path) -> None:
    raw = boat.parent
    (raw / "yacht/pool").mkdir(parents=True)
    (raw / "my boat").mkdir()
    (raw / "my boat/vehicle.yaml").write_text(VEHICLE)
    of_all = texts(check(raw), "error")
    assert [text.split(".")[0] for text in of_all] == [
        f'{raw}/my boat: the folder\'s name "my boat" cannot be the name of a vehicle',
        f"{raw}/yacht: has pool but no vehicle",
    ]
    assert texts(check(raw / "my boat"), "error") == of_all[:1]


@pytest.mark.parametrize(("path", "said"), [("", "names nothing"), ("nowhere", "does not exist")])
def test_a_path_that_leads_nowhere_is_wrong_usage(tmp_path: Path, path: str, said: str) -> None:
    """An empty one is not the current folder, which the variable of a script seldom means."""
    with pytest.raises(UsageError, match=said):
        check_paths([path], raw=tmp_path)


def test_a_pool_run_among_bench_files_is_said_to_be_one(boat: Path, repository: Path) -> None:
    (boat / "mooring").mkdir()
    log = boat / "mooring/dive.mcap"
    log.write_bytes((repository / "raw/mmt300/pool/2024-05-15-zig-zag.mcap").read_bytes())
    read = read_mooring_tables([log], load_vehicle(boat / "vehicle.yaml"), boat.parent)
    for said in (texts(check(boat), "error"), [str(problem) for problem in read.problems]):
        assert len(said) == 1
        assert "log of a pool run" in said[0]
        assert "Move it into the vehicle's pool/." in said[0]
