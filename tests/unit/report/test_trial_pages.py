"""Pages of runs and days: peaks are kept, tables are compared, what moved is marked."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.records.identification import (
    ChannelQuality,
    IdentifiedParameter,
    VehicleIdentification,
)
from pipeline.records.trial import DayTables, PageReceipt, TrialDay, table_changes
from pipeline.report.blocks import Details, Figure, Text
from pipeline.report.panels import thinned
from pipeline.report.results import DayResults, VehicleResults
from pipeline.report.sections.trials import Days, has_trend, trend_blocks, trials_section
from pipeline.report.trial_page import day_page, day_warnings

CRUMBS = (("All vehicles", "../../index.html"),)


@given(st.integers(0, 19_999), st.integers(0, 19_999), st.integers(2, 300))
def test_decimation_keeps_every_peak(up: int, down: int, buckets: int) -> None:
    time_s = np.linspace(0.0, 399.98, 20_000)
    values = np.sin(time_s)
    values[up], values[down] = 7.0, -7.0
    shown_s, shown = thinned(time_s, values, buckets)
    assert shown.min() == -7.0
    assert up == down or shown.max() == 7.0
    assert np.all(np.diff(shown_s) > 0)
    assert shown.size <= 3 * buckets


def test_decimation_leaves_gaps_open() -> None:
    time_s = np.linspace(0.0, 199.98, 10_000)
    values = np.ones(10_000)
    values[4_000:6_000] = np.nan
    shown_s, shown = thinned(time_s, values, 100)
    assert np.isnan(shown[(shown_s > 81.0) & (shown_s < 119.0)]).all()
    short_s, short = thinned(time_s[3_900:6_101:100], values[3_900:6_101:100], 100)
    assert np.isnan(short).sum() == 1
    assert short_s.size == 4


def tables(day: str, shift: float, digest: str) -> DayTables:
    code = (None, *(10.0 * n + shift * n for n in range(4)), None)
    return DayTables(
        vehicle="v", day=day, speed_mps=(0.0, 1.0), thrust_n=(-1.0, 0.0, 1.0, 2.0, 3.0, 4.0),
        code=(code, code), tables_sha256=digest,
    )  # fmt: skip


def test_change_of_tables_is_counted_in_codes() -> None:
    first, second = table_changes(tables("a", 0.0, "x"), tables("b", 0.5, "y"))
    assert (first.largest_codes, first.at_thrust_n) == (1.5, 3.0)
    assert first.mean_codes == pytest.approx(0.75)
    assert first.thrusts == 4
    assert second.speed_mps == 1.0


def test_tables_on_another_grid_are_compared_between_their_thrusts() -> None:
    before = DayTables(
        vehicle="v", day="a", speed_mps=(0.0,), thrust_n=(0.0, 4.0), code=((0.0, 40.0),)
    )
    (change,) = table_changes(before, tables("b", 0.0, "y"))
    assert change.largest_codes == pytest.approx(0.0, abs=1e-9)


def parameter(value: float, half: float = 1.0, prior: float = 10.0) -> IdentifiedParameter:
    interval = (value - half, value + half)
    return IdentifiedParameter(
        name="added_mass_surge", unit="kg", meaning="added mass <i>", value=value, std=half / 2,
        ci95=interval, ci95_thrust_known=interval, prior_value=prior, prior_std=1.0,
        posterior_over_prior=0.5, inflation=1.0, identified=True, reason="",
    )  # fmt: skip


def fit(value: float, *, converged: bool = True) -> VehicleIdentification:
    return VehicleIdentification(
        vehicle="v", runs=("r",), holdout=(), windows=9, holdout_windows=2, window_s=8.0,
        readings=99, iterations=3, converged=converged, thrust_uncertainty=0.0,
        parameters=(parameter(value),), cannot_identify=(), next_manoeuvres=(),
        noise=(), quality=(), notes=(),
    )  # fmt: skip


def day(results: VehicleResults, value: float, before: float | None = None) -> DayResults:
    def trial(name: str, number: float) -> TrialDay:
        return TrialDay(vehicle="v", day=name, runs=("r",), identification=fit(number))

    return DayResults(
        vehicle=results.vehicle,
        day="2026-05-04",
        trial=trial("2026-05-04", value),
        earlier={} if before is None else {"2026-05-03": trial("2026-05-03", before)},
        runs=(
            PageReceipt(
                kind="run", name="r", files={"reports/v/runs/r.html": ""}, title="r", errors=0,
                warnings=0, line="60 s; <b>zig zag",
            ),
        ),
        links={"r": "../runs/r.html"},
        tables=tables("2026-05-04", 0.5, "y"),
        tables_before=tables("2026-05-03", 0.0, "x"),
    )  # fmt: skip


def test_day_that_agrees_has_no_warning(results: VehicleResults) -> None:
    assert day_warnings(day(results, 10.5, 10.2)) == ()


def test_parameter_that_moved_is_named_first(results: VehicleResults) -> None:
    moved, off = day_warnings(day(results, 15.0, 10.2))
    assert moved.startswith("added mass surge: outside the intervals of 2026-05-03.")
    assert off == "By this day's fit the vehicle file is off in: added mass surge."


def test_day_page_shows_trend_tables_and_runs_escaped(results: VehicleResults) -> None:
    text = day_page(day(results, 15.0, 10.2), CRUMBS)
    assert text == day_page(day(results, 15.0, 10.2), CRUMBS)
    assert 'id="fig-trend"' in text
    assert "added_mass_surge moved out of the intervals" in text
    assert "codes changed by up to 1.5" in text
    assert '<a href="../runs/r.html">r: 60 s; &lt;b&gt;zig zag</a>' in text
    assert "added mass &lt;i&gt;" in text


def lead_of(days: Days) -> str:
    figure = trend_blocks(days)[0]
    assert isinstance(figure, Figure)
    return figure.lead


@pytest.mark.usefixtures("undrawn")
def test_a_parameter_that_the_last_day_does_not_tell_has_not_moved_since_the_day_before() -> None:
    name = "added_mass_surge"
    days = {
        "2026-05-01": {name: parameter(10.0)},
        "2026-05-02": {name: parameter(15.0)},
        "2026-05-03": {"mass": parameter(3.0)},
    }
    assert "No parameter's interval" in lead_of(days)
    days["2026-05-03"][name] = parameter(10.0)
    assert f"{name} moved out of the intervals" in lead_of(days)


def without_fit(name: str) -> TrialDay:
    return TrialDay(vehicle="v", day=name, runs=("r",), why_not="no run has commands.")


def test_page_without_a_trend_says_how_many_days_have_parameters(results: VehicleResults) -> None:
    needed = "A trend needs two trial days with a fit; there is "
    assert f"{needed}one so far." in day_page(day(results, 10.0), CRUMBS)
    one_before = replace(day(results, 10.0, 10.2), trial=without_fit("2026-05-04"))
    assert f"{needed}one so far." in day_page(one_before, CRUMBS)
    none = replace(one_before, earlier={"2026-05-03": without_fit("2026-05-03")})
    assert f"{needed}none so far." in day_page(none, CRUMBS)


def test_what_the_corrected_file_predicts_has_a_column_of_its_own(results: VehicleResults) -> None:
    one = ChannelQuality(
        channel="velocity", unit="m/s", horizon_s=8.0, readings=90, sensor_noise=0.01,
        rmse_identified=0.111, rmse_corrected_file=0.222, rmse_vehicle_file=0.333,
        rmse_last_value=0.444, rmse_black_box=None,
    )  # fmt: skip
    judged = fit(10.0).model_copy(update={"quality": (one,)})
    shown = day(results, 10.0)
    shown = replace(shown, trial=shown.trial.model_copy(update={"identification": judged}))
    table = day_page(shown, CRUMBS).partition('id="quality"')[2].partition("</table>")[0]
    heads = re.findall(r"<th scope=\"col\"[^>]*>([^<]*)", table)
    cells = re.findall(r"<td[^>]*>([^<]*)", table)
    assert dict(zip(heads[1:], cells, strict=True))["Corrected file"] == "0.222"


def test_fit_that_no_window_judges_is_no_missing_fit(results: VehicleResults) -> None:
    there = day_page(day(results, 10.0), CRUMBS)
    assert "not used for the fit: nothing was left to judge the fit by." in there
    missing = replace(day(results, 10.0), trial=without_fit("2026-05-04"))
    assert "not used for the fit: there is no fit to judge." in day_page(missing, CRUMBS)


def test_fit_that_determines_nothing_says_so_without_an_empty_list(results: VehicleResults) -> None:
    vague = (parameter(10.0).model_copy(update={"identified": False}),)
    found = fit(10.0).model_copy(update={"parameters": vague})
    one = day(results, 10.0)
    text = day_page(
        replace(one, trial=one.trial.model_copy(update={"identification": found})), CRUMBS
    )
    assert "These runs determine none of the parameters." in text
    assert not re.search(r"<ul[^>]*>\s*</ul>", text)


def unsettled(name: str, value: float) -> TrialDay:
    return TrialDay(vehicle="v", day=name, runs=("r",), identification=fit(value, converged=False))


def test_a_fit_that_did_not_settle_is_compared_with_nothing(results: VehicleResults) -> None:
    found = replace(day(results, 15.0, 10.2), trial=unsettled("2026-05-04", 15.0))
    assert day_warnings(found) == ("The fit did not come to an end: do not use its values.",)
    text = day_page(found, CRUMBS)
    (section,) = re.findall(r'<summary id="identified">.*?</details>', text, re.DOTALL)
    assert "The fit did not come to an end: do not use its values." in section
    assert '<tr class="warning">' not in section
    assert "2026-05-03" not in section
    assert "moved out" not in text
    assert 'id="fig-trend"' not in text
    assert "so no trend is shown: 2026-05-04." in text
    assert "there is one so far." in text


def test_a_day_is_compared_with_the_last_one_that_settled(results: VehicleResults) -> None:
    found = day(results, 15.0, 15.2)
    earlier = {
        "2026-05-02": found.earlier["2026-05-03"],
        "2026-05-03": unsettled("2026-05-03", 10.2),
    }
    found = replace(found, earlier=earlier)
    assert not [text for text in day_warnings(found) if "outside the intervals" in text]
    text = day_page(found, CRUMBS)
    assert "interval lies wholly outside that of the trial day before." in text
    assert "so no trend is shown: 2026-05-03." in text


def linked(name: str, value: float, *, settled: bool = True) -> PageReceipt:
    return PageReceipt(
        kind="day",
        name=name,
        files={},
        title=f"Trial day {name}",
        errors=0,
        warnings=0,
        line="1 run",
        page=f"reports/vehicle/trials/{name}.html",
        parameters=(parameter(value),),
        settled=settled,
    )


def test_the_vehicles_page_leaves_an_unsettled_day_out_of_its_trend(
    results: VehicleResults,
) -> None:
    days = (linked("2026-05-02", 10.0), linked("2026-05-03", 15.0, settled=False))
    two = replace(results, trials=days)
    assert not has_trend(two)
    texts = [one.text for one in trials_section(two).blocks if isinstance(one, Text)]
    assert texts == [
        "Of these trial days the fit did not come to an end, so no trend is shown: 2026-05-03."
    ]
    three = replace(results, trials=(*days, linked("2026-05-04", 10.2)))
    assert has_trend(three)
    (figure,) = [one for one in trials_section(three).blocks if isinstance(one, Figure)]
    assert figure.lead == (
        "No parameter's interval lies wholly outside that of the trial day before."
    )
    assert "2026-05-03" not in figure.svg


def test_one_day_folded_away_is_no_days(results: VehicleResults) -> None:
    day = linked("2026-05-01", 1.0).model_copy(update={"parameters": ()})
    days = tuple(day.model_copy(update={"name": f"2026-05-0{n}"}) for n in range(1, 7))
    blocks = trials_section(replace(results, trials=days)).blocks
    (folded,) = [one for one in blocks if isinstance(one, Details)]
    assert folded.summary == "1 earlier trial day"
