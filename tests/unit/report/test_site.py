"""The index leads to every page and counts what the page warns of."""

import dataclasses
import re
from pathlib import Path

import pytest

from pipeline.records.trial import PageReceipt, RunLine
from pipeline.report import html
from pipeline.report.blocks import Table
from pipeline.report.page import write_index
from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_receipt
from pipeline.stages.index_page import design_links, write_index_again


def test_index_leads_to_every_vehicle_with_its_status(
    results: VehicleResults, tmp_path: Path
) -> None:
    other = dataclasses.replace(
        results,
        vehicle=results.vehicle.model_copy(update={"title": "<b>Other</b>"}),
        page=Path("reports/a b/index.html"),
    )
    index = tmp_path / "index.html"
    write_index([vehicle_receipt(results, {}), vehicle_receipt(other, {})], index)
    text = index.read_text(encoding="utf-8")
    assert '<a href="vehicle/index.html">' in text
    assert '<a href="a%20b/index.html">' in text
    assert "<b>Other" not in text
    assert "&lt;b&gt;Other" in text
    assert text.count("1 error, 8 warnings, 1 failed check") == 2
    assert "rebuilt from printed tables" in text


def test_empty_index_says_what_to_do(tmp_path: Path) -> None:
    index = tmp_path / "index.html"
    write_index([], index)
    assert "put a folder with a vehicle.yaml into raw/" in index.read_text(encoding="utf-8")


def test_same_pages_give_the_same_bytes(results: VehicleResults, tmp_path: Path) -> None:
    entries = [vehicle_receipt(results, {})]
    write_index(entries, tmp_path / "a.html")
    write_index(entries, tmp_path / "b.html")
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_status_counts_missing_results(results: VehicleResults) -> None:
    bare = VehicleResults(
        vehicle=results.vehicle.model_copy(update={"allocator": None}), mooring=results.mooring
    )
    # all but the mooring test, and the allocator is not asked for
    assert vehicle_receipt(bare, {}).not_computed == 6


def test_index_lists_days_with_runs_and_designs_and_is_whole_without_scripts(
    results: VehicleResults, tmp_path: Path
) -> None:
    day = PageReceipt(
        kind="day", name="2026-05-04", files={}, title="Trial day 2026-05-04",
        errors=0, warnings=0, line="1 run", page="reports/v/trials/2026-05-04.html",
        runs=(RunLine(name="<i>zig-zag", line="60 s", page="reports/v/runs/zig-zag.html"),),
    )  # fmt: skip
    one = dataclasses.replace(results, page=Path("reports/v/index.html"), trials=(day,))
    entry = vehicle_receipt(one, {}).model_copy(update={"trend_href": "v/index.html#trend"})
    page = tmp_path / "reports/design/pilgrim.html"
    page.parent.mkdir(parents=True)
    page.write_text("<!DOCTYPE html><title>Pilgrim &lt;1&gt;: loads</title>", encoding="utf-8")
    index = tmp_path / "reports/index.html"
    write_index([entry], index, designs=design_links(index.parent))
    text = index.read_text(encoding="utf-8")
    assert '<a href="v/trials/2026-05-04.html">Trial day 2026-05-04: 1 run</a>' in text
    assert '<a href="v/runs/zig-zag.html">&lt;i&gt;zig-zag: 60 s</a>' in text
    assert '<a href="v/index.html#trend">' in text
    assert '<a href="design/pilgrim.html">Pilgrim &lt;1&gt;: loads</a>' in text
    # the field is shown by the script that it needs
    assert 'role="search" hidden' in text
    assert "<script" not in text


def test_index_with_a_filter_loads_its_script_alone(
    results: VehicleResults, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(html, "_library", lambda: b"// library")
    index = tmp_path / "reports/index.html"
    write_index([vehicle_receipt(results, {})], index, assets=index.parent / "assets")
    assert re.findall(r'<script defer src="(.*?)"', index.read_text()) == ["assets/filter.js"]
    assert (index.parent / "assets/filter.js").is_file()


def test_receipt_of_another_version_is_passed_over(tmp_path: Path) -> None:
    receipt = tmp_path / "processed/v/vehicle_page.json"
    receipt.parent.mkdir(parents=True)
    receipt.write_text('{"kind": "vehicle_page", "record": {"trials": []}}', encoding="utf-8")
    write_index_again(tmp_path)
    assert "No vehicle has been processed yet" in (tmp_path / "reports/index.html").read_text()


def test_cells_lead_to_places_of_the_page_alone() -> None:
    with pytest.raises(ValueError, match="places of the page alone"):
        Table("t", ("a",), (("1",),), links={(0, 0): "javascript:alert(1)"})
