"""The chain of a number: all files back to the raw ones, and what does not fit is said."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.commands.why import as_text
from pipeline.errors import InputError
from pipeline.plan import VehicleFolder
from pipeline.provenance import (
    code_digest,
    content_digest,
    file_digest,
    schema_of,
    tables_text,
    write_atomically,
)
from pipeline.stage_table import module_of
from pipeline.workflow.cell import Cell
from pipeline.workflow.why import lineage, to_json, why

BOAT = VehicleFolder("boat", "raw/boat")
CHAIN = {
    "load_test": ("raw/boat/load_test/drive.xlsx",),
    "drive": ("processed/boat/load_test.json",),
    "static": ("processed/boat/drive.json",),
    "mooring": ("raw/boat/mooring/bollard.csv",),
    "inverse": ("processed/boat/static.json", "processed/boat/mooring.json"),
}
POINT = {"source": {"file": "boat/load_test/drive.xlsx", "sheet": "Code 20", "row": 3}}


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A folder with the chain of Tables 3 and 4, made of plain files."""
    for name in ("vehicle.yaml", "load_test/drive.xlsx", "mooring/bollard.csv"):
        path = tmp_path / "raw/boat" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name, encoding="utf-8")
    for stage, before in CHAIN.items():
        names = ("raw/boat/vehicle.yaml", *before)
        record: dict[str, object] = {}
        if stage == "load_test":
            record = {"points": [{**POINT, "marks": []}, {**POINT, "marks": ["warm-up"]}]}
        body = {
            "schema": schema_of(stage),
            "version": "0.1.0",
            "inputs": {name: file_digest(tmp_path / name) for name in names},
            "code": code_digest(module_of(stage)),
            "record": record,
            "record_sha256": content_digest(record),
            "why_not": None,
        }
        write_atomically(tmp_path / f"processed/boat/{stage}.json", json.dumps(body))
    inverse = "processed/boat/inverse.json"
    text = tables_text(
        {"table3": {"positive": [1.0]}, "table4": {"speed_mps": [0.5], "KN1": [3.0]}},
        inputs={inverse: file_digest(tmp_path / inverse)},
        code=code_digest(module_of("tables")),
    )
    write_atomically(tmp_path / "processed/boat/tables.json", text)
    return tmp_path


def stages(out: Path, table: str) -> list[str]:
    found = []
    waiting = [lineage(BOAT, out, table, "inverse")]
    while waiting:
        link = waiting.pop()
        found.append(link.stage)
        waiting.extend(link.inputs)
    return found


def test_chain_goes_back_to_what_the_table_is_made_of(out: Path) -> None:
    assert stages(out, "table4") == ["tables", "inverse", "static", "drive", "load_test"]
    assert stages(out, "table3") == ["tables", "inverse", "mooring"]
    assert lineage(BOAT, out, "table4", "inverse").fits


def test_text_names_sheets_and_points(out: Path) -> None:
    text = as_text(why("boat", ("table4", "KN1", "0.5"), out / "raw", out))
    assert text.startswith("table4.KN1[0] at 0.5 m/s = 3.0 code/N\n")
    assert 'sheet "Code 20": 2 points, 1 of them left out when read' in text
    assert text.count("raw/boat/vehicle.yaml") == 1
    assert text.endswith("Every file of the chain fits those before it.")
    assert "\n".join(text.split("\n")).isascii()


def test_changed_new_and_lost_raw_files_are_said(out: Path) -> None:
    (out / "raw/boat/load_test/drive.xlsx").write_text("another", encoding="utf-8")
    (out / "raw/boat/load_test/second.xlsx").touch()
    answer = why("boat", ("table4.KN1[0]",), out / "raw", out)
    text = as_text(answer)
    assert "STALE: raw/boat/load_test/drive.xlsx has changed since" in text
    assert "raw/boat/load_test/second.xlsx is new" in text
    assert text.endswith("To renew it: rig2sea run")
    said = json.loads(to_json(answer))
    assert said["schema"] == "rig2sea/why/1"
    assert said["up_to_date"] is False
    (out / "raw/boat/load_test/drive.xlsx").unlink()
    text = as_text(why("boat", ("table4.KN1[0]",), out / "raw", out))
    assert "drive.xlsx is gone" in text
    # Table 3 does not hang on it
    assert "CHANGED" not in as_text(why("boat", ("table3.positive[0]",), out / "raw", out))


def test_other_code_and_edited_files_are_noticed(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.workflow.why.code_digest", lambda _name: "other")
    link = lineage(BOAT, out, "table3", "inverse")
    assert link.stale == ("the program has changed since",)
    path = out / "processed/boat/mooring.json"
    path.write_text(path.read_text().replace('"record": {}', '"record": {"points": []}'))
    with pytest.raises(InputError, match="was changed after it was written"):
        lineage(BOAT, out, "table3", "inverse")


def test_tables_that_were_never_made_are_to_be_made_and_not_deleted(tmp_path: Path) -> None:
    folder = tmp_path / "raw/boat"
    folder.mkdir(parents=True)
    (folder / "vehicle.yaml").touch()
    with pytest.raises(InputError) as caught:
        why("boat", ("table4.KN1[0]",), tmp_path / "raw", tmp_path)
    assert "not made yet" in str(caught.value)
    assert "rig2sea run boat" in str(caught.value)
    assert "Delete" not in str(caught.value)


def test_a_plain_ratio_ends_without_a_unit_and_table_4_says_what_it_is(out: Path) -> None:
    answer = why("boat", ("table4.KN1[0]",), out / "raw", out)
    assert "  not fitted to measurements: it inverts the static family T(N, V)" in as_text(answer)
    fit = {"points": 50, "outliers": [], "residual_std": 0.000557, "unit": "1"}
    ratio = replace(answer, cell=Cell("table1", "table1.KT[0]", 0.139, fit=fit))
    assert "residual 0.000557\n" in as_text(ratio)
    assert as_text(ratio).startswith("table1.KT[0] = 0.139\n")
