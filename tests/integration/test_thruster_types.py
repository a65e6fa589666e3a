"""A vehicle with two types of thruster: bench files, tables and firmware of each."""

import json
from pathlib import Path

import pytest
from synthetic_bench import make_moored, write_mooring

from pipeline.check.files import check_paths
from pipeline.stage_process import run_steps
from pipeline.workflow.engine_jobs import FOLDER, engine_jobs, hand_over
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.outcome import outcome_of
from pipeline.workflow.run import RunRequest, due_of, vehicles_to_run

BOW = (
    "  - {name: bow, propeller: small, drive: servo, position_m: [0.8, 0, 0], "
    "direction: [0, 0, -1]}"
)
CHANGES = {
    "propellers: {screw: {diameter_m: 0.14}}": "propellers: {screw: {diameter_m: 0.14}, "
    "small: {diameter_m: 0.07}}",
    "drives: {drive: {code_min: -127, code_max: 127}}": "drives: {drive: {code_min: -127, "
    "code_max: 127}, servo: {code_min: -127, code_max: 127}}",
    "allocator:\n": f"{BOW}\nallocator:\n",
    "right: right,\n": "right: right, bow: bow, bow_arm_m: 0.8,\n",
    "tables: {propeller: screw, drive: drive}": "tables: {propeller: screw, drive: drive, "
    "types: {tunnel: {propeller: small, drive: servo, speed_mps: [0.0]}}}",
}


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The boat with a bow thruster of another type, which gives 0.4 of the stern ones' thrust."""
    folder = tmp_path / "raw/boat"
    make_moored(folder)
    text = (folder / "vehicle.yaml").read_text(encoding="utf-8")
    for old, new in CHANGES.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "vehicle.yaml").write_text(text, encoding="utf-8")
    file = folder / "mooring/tunnel/bow.csv"
    file.parent.mkdir()
    write_mooring(file)
    head, *rows = file.read_text().splitlines()
    weaker = [f"{code},{0.4 * float(thrust):.3f}" for code, thrust in (r.split(",") for r in rows)]
    file.write_text("\n".join([head, *weaker]) + "\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def largest(vehicle: str) -> float:
    body = json.loads(Path(f"processed/{vehicle}/inverse.json").read_text())
    return float(body["record"]["firmware"]["positive"]["thrust_max_n"][0])


def test_each_type_has_tables_and_firmware(root: Path) -> None:
    request = RunRequest(only=("firmware",))
    vehicles, _ = vehicles_to_run(request)
    assert [one.name for one in vehicles] == ["boat", "boat-tunnel"]
    (job,) = engine_jobs(due_of(vehicles, request, KnownFiles()), Path(), 1, None)
    hand_over((job,), root)
    assert run_steps(json.loads(Path(FOLDER, f"{job.name}.json").read_text())) == 0
    assert [one.stages for one in due_of(vehicles, request, KnownFiles())] == [(), ()]
    assert largest("boat-tunnel") == pytest.approx(0.4 * largest("boat"), rel=1e-3)
    assert json.loads(Path("processed/boat/tables.json").read_text())["types"] == ["tunnel"]
    firmware = root / "processed/boat/firmware"
    assert (firmware / "boat-tunnel_thruster.c").is_file()
    allocator = (firmware / "boat_allocator.c").read_text()
    assert "static const int kind[5] = {\n    0, 0, 0, 0, 1,\n};" in allocator
    assert "boat_tunnel_code_from_thrust_q" in allocator
    made = json.loads(Path("processed/boat-tunnel/mooring.json").read_text())
    assert "raw/boat/mooring/tunnel/bow.csv" in made["inputs"]
    for vehicle in vehicles:
        assert not [one for one in outcome_of(vehicle, root).problems if one.severity == "error"]


def test_check_reads_each_file_with_its_type(root: Path) -> None:
    folder = root / "raw/boat"
    found = check_paths([folder], raw=root / "raw")
    assert {Path(one.file).parent.name: one.kind for one in found.files} == {
        "mooring": "mooring",
        "tunnel": "mooring",
    }
    assert not found.problems
    (folder / "mooring/tunnel").rename(folder / "mooring/stray")
    (problem,) = check_paths([folder], raw=root / "raw").problems
    assert "name it in tables.types" in problem.remedy
