"""The page of a run: small however long the run, and the same without scripts."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import run_records

from pipeline.errors import Place
from pipeline.records.trial import LARGEST_OVERLAY_BYTES
from pipeline.report.results import VehicleResults
from pipeline.report.run_page import commands_figure, run_page
from pipeline.stages.run_page import overlay_label

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
    addresses = set(re.findall(r'<td[^>]*><a href="#([a-z-]+)">', long_run))
    assert {"fig-velocity", "fig-attitude", "fig-shaft-speed"} <= addresses
    for address in addresses:
        assert f'<figure id="{address}">' in long_run


@pytest.mark.usefixtures("undrawn")
def test_commands_are_drawn_without_limits_where_the_vehicle_file_has_no_thrusters(
    results: VehicleResults,
) -> None:
    found = run_records.run_results(results.vehicle)
    bare = results.vehicle.model_copy(update={"thrusters": (), "model": None})
    text = run_page(replace(found, vehicle=bare), CRUMBS, "../../assets")
    (figure,) = re.findall(r'<figure id="fig-commands">.*?</figure>', text, re.DOTALL)
    (data,) = re.findall(r'class="zoom-data">(.*?)</script>', figure)
    drawn = json.loads(data)
    assert len(drawn["data"]) == len(results.vehicle.thrusters)  # named by the log
    assert not [one for one in drawn["layout"]["shapes"] if one["type"] == "line"]


@pytest.mark.usefixtures("undrawn")
def test_the_command_that_went_furthest_keeps_its_sign(results: VehicleResults) -> None:
    found = run_records.run_results(results.vehicle)
    assert found.measured is not None
    table = replace(
        found.measured,
        time_s=np.arange(3.0),
        values={"command": np.array([[10.0, np.nan], [40.0, -101.0], [np.nan, 60.0]])},
        valid={"command": np.full(3, fill_value=True)},
        thrusters=("left", "right"),
    )
    figure = commands_figure(replace(found, measured=table))
    assert figure is not None
    assert figure.lead == "Commanded codes over 2.00 s; right went furthest, to −101."


@pytest.mark.usefixtures("undrawn")
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


@pytest.mark.usefixtures("undrawn")
def test_notes_are_asked_for_under_the_name_of_the_log(results: VehicleResults) -> None:
    found = run_records.run_results(results.vehicle, name="dive_3-32565f6e")
    text = run_page(replace(found, shown_path="raw/boat/pool/dive 3.mcap"), CRUMBS)
    assert "No notes: write dive 3.yaml beside the log" in text
    assert "32565f6e.yaml" not in text


def test_the_log_beside_the_page_is_called_what_it_holds(results: VehicleResults) -> None:
    stored = run_records.run_results(results.vehicle).stored
    assert stored is not None
    assert "measured and simulated" in overlay_label(stored)
    large = stored.model_copy(update={"size_bytes": LARGEST_OVERLAY_BYTES + 1})
    assert "simulated channels alone" in overlay_label(large)


@pytest.mark.usefixtures("undrawn")
def test_one_figure_folded_away_is_no_figures(results: VehicleResults) -> None:
    found = run_records.run_results(results.vehicle)
    assert found.trial is not None
    few = tuple(one for one in found.trial.channels if one.quantity in {"velocity", "position"})
    trial = found.trial.model_copy(update={"channels": few})
    text = run_page(replace(found, trial=trial), CRUMBS)
    assert "<summary>1 more figure</summary>" in text


@pytest.mark.usefixtures("undrawn")
def test_without_scripts_there_are_none(results: VehicleResults) -> None:
    text = run_page(run_records.run_results(results.vehicle), CRUMBS)
    assert "<script defer" not in text
    assert "script-src" not in text


def test_the_noise_of_a_run_is_called_what_it_holds(long_run: str) -> None:
    assert '<th scope="col">Noise with offset</th>' in long_run
    assert "Sensor noise" not in long_run
    assert "noise and offset of the sensor together" in long_run


def test_a_low_picture_beside_a_high_one_stands_under_its_own_sentence(long_run: str) -> None:
    # figures of a level gallery share their rows: depth, with one panel, would stand where the
    # three of attitude end
    assert '<div class="gallery">' in long_run
    assert "gallery level" not in long_run
    assert ".gallery.level > figure { display: grid; grid-template-rows: subgrid" in long_run
