"""A vehicle with two types of thruster: bench files, tables and firmware of each."""

import importlib
import json
from pathlib import Path

import pytest
from synthetic_bench import make_moored, write_mooring

from pipeline.check.files import check_paths
from pipeline.plan import RAW_KINDS
from pipeline.stages.job import Job
from pipeline.workflow.outcome import outcome_of
from pipeline.workflow.targets import Targets

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


STAGES = (*RAW_KINDS, "propeller", "drive", "static", "inverse", "tables")


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


def run(targets: Targets, vehicle: str, stage: str, *more: str) -> str:
    """Run a stage in this process, over all that was made before."""
    raw = targets.raw_files(vehicle, stage) if stage in RAW_KINDS else []
    made = [str(path) for path in Path(f"processed/{vehicle}").glob("*.json")]
    inputs = [targets.vehicle_file(vehicle), *map(str, raw), *made, *more]
    output = Path(f"processed/{vehicle}/{stage}.json")
    job = Job(stage, vehicle, "code", tuple(map(Path, inputs)), output)
    return str(importlib.import_module(f"pipeline.stages.{stage}").run(job))


def largest(vehicle: str) -> float:
    body = json.loads(Path(f"processed/{vehicle}/inverse.json").read_text())
    return float(body["record"]["firmware"]["positive"]["thrust_max_n"][0])


def test_each_type_has_tables_and_firmware(root: Path) -> None:
    targets = Targets.from_config({})
    assert list(targets.vehicles) == ["boat", "boat-tunnel"]
    assert "processed/boat-tunnel/tables.json" in targets.all_files()
    for vehicle in targets.vehicles:
        for stage in STAGES:
            run(targets, vehicle, stage)
    assert largest("boat-tunnel") == pytest.approx(0.4 * largest("boat"), rel=1e-3)
    assert json.loads(Path("processed/boat/tables.json").read_text())["types"] == ["tunnel"]
    of_types = targets.results_of_types("boat", "inverse", "tables")
    assert run(targets, "boat", "firmware", *of_types) == ""
    firmware = root / "processed/boat/firmware"
    assert (firmware / "boat-tunnel_thruster.c").is_file()
    allocator = (firmware / "boat_allocator.c").read_text()
    assert "static const int kind[5] = {\n    0, 0, 0, 0, 1,\n};" in allocator
    assert "boat_tunnel_code_from_thrust_q" in allocator
    made = json.loads(Path("processed/boat-tunnel/mooring.json").read_text())
    assert "raw/boat/mooring/tunnel/bow.csv" in made["inputs"]
    for vehicle in targets.vehicles.values():
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
