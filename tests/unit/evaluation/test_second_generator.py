"""The second generator: its vehicles are those of their files, and a campaign is resumed."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evaluation import cases
from evaluation.cases import SecondCase, make_case
from evaluation.craft import COURIER, CRAFTS, INSPECTOR, Craft, vehicle_file
from evaluation.faults import drawn
from evaluation.flight import COMMAND_S, STEP_S
from evaluation.runs import codes_for, fly, write_log
from evaluation.second_generator import rates_of, run_campaign, write_page
from pipeline.campaign.campaign import CampaignRequest
from pipeline.errors import InputError
from pipeline.inputs.runs_to_identify import read_run
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.simulate.run import run


def on_disk(craft: Craft, folder: Path) -> SimulatedVehicle:
    (folder / "pool").mkdir(parents=True)
    (folder / "vehicle.yaml").write_text(vehicle_file(craft), encoding="utf-8")
    return load_simulated(str(folder), folder.parent, folder.parent)


@pytest.mark.parametrize("craft", CRAFTS, ids=lambda craft: str(craft.name))
def test_a_vehicle_is_that_of_its_file(craft: Craft, tmp_path: Path) -> None:
    """The package's own simulation of the file moves as the craft does; their laws differ a little.

    Thrust rises against the motion here and not there, and a torque that is held is no lag.
    """
    one = on_disk(craft, tmp_path / craft.name)
    codes = codes_for(craft, "steps", 20.0, np.random.default_rng(3))
    flown = fly(craft, codes, np.zeros((round(20.0 / STEP_S), 6)))
    held = np.repeat(codes, round(COMMAND_S / STEP_S), axis=0)
    same = run(one.packed, held, dt_s=STEP_S)
    moved = np.abs(flown[:, 7:13]).max(axis=0)
    off = np.abs(same.nu - flown[:, 7:13]).max(axis=0)
    assert (off < 0.12 * moved + 0.02).all(), (off, moved)


def test_a_log_is_read_as_it_was_measured(tmp_path: Path) -> None:
    craft = replace(INSPECTOR, supply=(1.0, 0.9), voltage_logged=True)
    one = on_disk(craft, tmp_path / "inspector")
    generator = np.random.default_rng(4)
    codes = codes_for(craft, "waves", 12.0, generator)
    flown = fly(craft, codes, np.zeros((round(12.0 / STEP_S), 6)))
    path = tmp_path / "inspector" / "pool" / "run.mcap"
    write_log(path, craft, codes, flown, generator)
    _, table = read_run(path, one, tmp_path)
    assert set(table.values) == {
        "command", "angular_velocity", "specific_force", "attitude", "velocity", "depth", "voltage"
    }  # fmt: skip
    rows = round(1.0 / STEP_S) * np.arange(2, 10)
    found = table.values["velocity"][rows]
    seen = flown[rows, 7:10] + np.cross(flown[rows, 10:13], craft.dvl_place)
    np.testing.assert_allclose(found, seen, atol=0.05)
    force = np.nanmean(table.values["specific_force"], axis=0)
    assert force[2] == pytest.approx(-9.81, abs=0.15)
    volt = table.values["voltage"][rows, 0]
    np.testing.assert_allclose(volt, 24.0 * (1.0 - 0.1 * rows * STEP_S / 12.0), atol=0.3)


def test_thrusters_work_at_a_tenth_of_their_range() -> None:
    generator = np.random.default_rng(5)
    codes = codes_for(COURIER, "steps", 60.0, generator)
    assert np.abs(codes).max() <= 0.13 * COURIER.code_max
    straight = codes_for(COURIER, "straight", 60.0, generator)
    assert np.abs(straight[:, 0]).min() > 0.0
    assert not straight[:, 1:].any()


def test_a_fault_of_no_size_changes_nothing() -> None:
    generator = np.random.default_rng(6)
    codes = codes_for(INSPECTOR, "waves", 10.0, generator)
    calm = np.zeros((round(10.0 / STEP_S), 6))
    as_it_is = fly(INSPECTOR, codes, calm)
    found = set()
    for _ in range(80):
        maker = drawn(INSPECTOR, generator)
        fault = maker(INSPECTOR, 0.0)
        np.testing.assert_allclose(fly(fault.craft, codes, calm), as_it_is, atol=1e-9)
        found.add(maker(INSPECTOR, 1.0).effect)
    assert len(found) >= 10


def says(effect: str) -> Any:  # noqa: ANN401 - a diagnosis that always says the same
    def diagnose(case: SecondCase) -> Mapping[str, Any]:
        assert (case.folder / "vehicle.yaml").is_file()
        assert len(case.runs) == 4
        return {"verdict": {"effects": [effect], "probability": 1.0, "ambiguous_with": []}}

    return diagnose


def test_a_campaign_is_scored_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cases, "RUN_S", 20.0)
    request = CampaignRequest(to=tmp_path, only=(0, 6), seed=5, processes=1)
    result = run_campaign(request, says("none"))
    assert [line["score"]["kind"] for line in result.lines] == ["single", "none"]
    assert not list((tmp_path / "cases").iterdir())
    again = run_campaign(replace(request, resume=True), says("payload"))
    assert again == result
    with pytest.raises(InputError, match="there is a campaign in this folder already"):
        run_campaign(request, says("none"))
    page = tmp_path / "page.md"
    write_page(result, "the command", page)
    text = page.read_text(encoding="utf-8")
    assert "| none | false alarm | 0 of 1" in text
    table = (tmp_path / "page_second.csv").read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[0] for row in table] == ["case", "0", "6"]
    assert (tmp_path / "images" / "second-confusion.svg").is_file()


def test_cases_are_drawn_from_seed_and_number_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cases, "RUN_S", 15.0)
    one, two = (make_case(6, 5, tmp_path / name) for name in ("a", "b"))
    for name in one.runs:
        first, second = (case.folder / "pool" / f"{name}.mcap" for case in (one, two))
        assert first.read_bytes() == second.read_bytes()
    assert not rates_of([])[0].cases
