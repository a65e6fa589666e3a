"""The page of a run: small however long the run, and the same without scripts."""

import json
import re
from dataclasses import replace

import pytest
import run_records

from pipeline.errors import Place
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


def test_commands_are_drawn_without_limits_where_the_vehicle_file_has_no_thrusters(
    results: VehicleResults,
) -> None:
    found = run_records.run_results(results.vehicle)
    bare = results.vehicle.model_copy(update={"thrusters": (), "model": None})
    text = run_page(replace(found, vehicle=bare), CRUMBS)
    (figure,) = re.findall(r'<figure id="fig-commands">.*?</figure>', text, re.DOTALL)
    (data,) = re.findall(r'class="zoom-data">(.*?)</script>', figure)
    drawn = json.loads(data)
    assert len(drawn["data"]) == len(results.vehicle.thrusters)  # named by the log
    assert not [one for one in drawn["layout"]["shapes"] if one["type"] == "line"]


def test_every_place_of_a_problem_is_listed(results: VehicleResults) -> None:
    found = run_records.run_results(results.vehicle)
    assert found.stored is not None
    (one,) = found.stored.problems
    many = tuple(replace(one, place=Place("dive.mcap", row=row)) for row in range(1, 7))
    stored = found.stored.model_copy(update={"problems": many})
    text = run_page(replace(found, stored=stored), CRUMBS)
    assert "and 2 more, listed below" in text
    assert "All 6 places: a gap of 3 s" in text
    for problem in many:
        assert f"<li>{problem.place}</li>" in text


def test_without_scripts_there_are_none(results: VehicleResults) -> None:
    text = run_page(run_records.run_results(results.vehicle), CRUMBS)
    assert "<script defer" not in text
    assert "script-src" not in text
