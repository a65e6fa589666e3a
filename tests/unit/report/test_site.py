"""The index leads to every page and counts what the page warns of."""

import dataclasses
from pathlib import Path

from pipeline.report.results import VehicleResults
from pipeline.report.site import index_entry, status_of, write_index


def test_index_leads_to_every_vehicle_with_its_status(
    results: VehicleResults, tmp_path: Path
) -> None:
    other = dataclasses.replace(
        results, vehicle=results.vehicle.model_copy(update={"title": "<b>Other</b>"})
    )
    index = tmp_path / "index.html"
    write_index(
        [index_entry(results, "synthetic/index.html"), index_entry(other, "a b/index.html")], index
    )
    text = index.read_text(encoding="utf-8")
    assert '<a href="synthetic/index.html">' in text
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
    entries = [index_entry(results, "synthetic/index.html")]
    write_index(entries, tmp_path / "a.html")
    write_index(entries, tmp_path / "b.html")
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_status_counts_missing_results_and_takes_the_worst_tone(results: VehicleResults) -> None:
    assert status_of(results).tone == "error"
    bare = VehicleResults(
        vehicle=results.vehicle.model_copy(update={"allocator": None}), mooring=results.mooring
    )
    # all but the mooring test, and the allocator is not asked for
    assert status_of(bare).not_computed == 6
    assert status_of(bare).tone == "warning"
