"""The page of a run: small however long the run, and the same without scripts."""

import json
import re

import pytest
import run_records

from pipeline.report.results import VehicleResults
from pipeline.report.run_page import run_page

CRUMBS = (("All vehicles", "../../index.html"),)


@pytest.fixture(scope="module")
def long_run(results: VehicleResults) -> str:
    """Ten minutes of every channel at 20 Hz: more readings than are drawn."""
    found = run_records.run_results(results.vehicle, seconds=600.0)
    return run_page(found, CRUMBS, "../../assets")


def test_ten_minutes_fit_into_3_mb(long_run: str) -> None:
    assert 0.3e6 < len(long_run.encode()) < 3e6


def test_every_figure_has_a_still_picture_and_its_data(long_run: str) -> None:
    figures = re.findall(r"<figure.*?</figure>", long_run, re.DOTALL)
    # commands, and eight quantities
    assert len(figures) == 9
    for figure in figures:
        assert '<svg class="plot"' in figure
        (data,) = re.findall(r'class="zoom-data">(.*?)</script>', figure)
        assert json.loads(data)["data"]


def test_limits_and_manoeuvres_are_in_both_drawings(long_run: str) -> None:
    (figure,) = re.findall(r'<figure id="fig-commands">.*?</figure>', long_run, re.DOTALL)
    (data,) = re.findall(r'class="zoom-data">(.*?)</script>', figure)
    found = json.loads(data)
    thrusters = len(found["data"])
    kinds = [(one["type"], one["xref"]) for one in found["layout"]["shapes"]]
    assert kinds.count(("line", "paper")) == 2 * thrusters
    assert kinds.count(("rect", "x")) == thrusters
    assert found["layout"]["xaxis"]["range"] == [0.0, pytest.approx(600.0, abs=0.1)]


def test_an_error_leads_to_its_curves(long_run: str) -> None:
    addresses = set(re.findall(r'<td><a href="#([a-z-]+)">', long_run))
    assert {"fig-velocity", "fig-attitude", "fig-shaft-speed"} <= addresses
    for address in addresses:
        assert f'<figure id="{address}">' in long_run


def test_without_scripts_there_are_none(results: VehicleResults) -> None:
    text = run_page(run_records.run_results(results.vehicle), CRUMBS)
    assert "<script defer" not in text
    assert "script-src" not in text
