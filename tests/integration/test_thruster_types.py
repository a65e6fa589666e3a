"""A vehicle with two types of thruster: bench files, tables, firmware and page of each."""

import json
from pathlib import Path

import pytest
from synthetic_bench import Bench, write_mooring

from pipeline.check.files import check_paths

BOW = "  - {name: bow, propeller: small, drive: servo, position_m: [0.8, 0, 0], direction: [0, 0, -1]}"
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
def two_types(fresh_moored: Bench) -> Bench:
    """The boat with a bow thruster of another type, which gives 0.4 of the stern ones' thrust."""
    folder = fresh_moored.root / "raw/boat"
    text = (folder / "vehicle.yaml").read_text(encoding="utf-8")
    for old, new in CHANGES.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "vehicle.yaml").write_text(text, encoding="utf-8")
    (folder / "mooring/tunnel").mkdir()
    write_mooring(folder / "mooring/tunnel/bow.csv")
    lines = (folder / "mooring/tunnel/bow.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    weaker = [lines[0], *(f"{code},{0.4 * float(thrust):.3f}" for code, thrust in rows)]
    (folder / "mooring/tunnel/bow.csv").write_text("\n".join(weaker) + "\n")
    return fresh_moored


def largest(root: Path, vehicle: str) -> float:
    body = json.loads((root / f"processed/{vehicle}/inverse.json").read_text())
    return float(body["record"]["firmware"]["positive"]["thrust_max_n"][0])


def test_each_type_has_tables_firmware_and_a_page(two_types: Bench) -> None:
    done = two_types.run()
    assert done.returncode == 0, done.stdout + done.stderr
    root = two_types.root
    assert largest(root, "boat-tunnel") == pytest.approx(0.4 * largest(root, "boat"), rel=1e-3)
    firmware = root / "processed/boat/firmware"
    assert (firmware / "boat-tunnel_thruster.c").is_file()
    allocator = (firmware / "boat_allocator.c").read_text()
    assert "static const int kind[5] = {\n    0, 0, 0, 0, 1,\n};" in allocator
    assert "boat_tunnel_code_from_thrust_q" in allocator
    tables = json.loads((root / "processed/boat/tables.json").read_text())
    assert tables["types"] == ["tunnel"]
    page = (root / "reports/boat/index.html").read_text(encoding="utf-8")
    assert "tables of thruster type tunnel (bow) are on a page of their own" in page
    assert (root / "reports/boat-tunnel/index.html").is_file()
    assert "not read" not in done.stdout
    assert "Nothing to do" in two_types.run().stdout


def test_check_reads_each_file_with_its_type(two_types: Bench) -> None:
    folder = two_types.root / "raw/boat"
    found = check_paths([folder])
    told = {one.path.parent.name: one for one in found.files}
    assert set(told) == {"mooring", "tunnel"}
    assert {one.kind for one in found.files} == {"mooring"}
    (folder / "mooring/stray").mkdir()
    (folder / "mooring/tunnel/bow.csv").rename(folder / "mooring/stray/bow.csv")
    (problem,) = check_paths([folder]).problems
    assert "name it in tables.types" in problem.remedy
