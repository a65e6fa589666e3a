"""The stage `validation`: a vehicle file in, flights or the reason out, and what is shown."""

import json
import shutil
from pathlib import Path

import pytest
from bundled_models import bundled

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.commands.validate import _text
from pipeline.provenance import Envelope, read_envelope, write_envelope
from pipeline.records.base import Record
from pipeline.records.validation import AllocatorValidation
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.allocation import validation_section
from pipeline.stages import validation
from pipeline.stages.job import Job
from pipeline.validate import plan
from pipeline.vehicle.load import load_vehicle


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "raw/a").mkdir(parents=True)
    (tmp_path / "processed/a").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plan, "KEEPING_S", 4.0)
    monkeypatch.setattr(plan, "STEP_FLIGHT_S", 3.0)
    return tmp_path


def ran(text: str) -> str:
    """Run the stage on a vehicle file; return what it says."""
    Path("raw/a/vehicle.yaml").write_text(text, encoding="utf-8")
    output = Path("processed/a/validation.json")
    return validation.run(Job("validation", "a", "c0", (Path("raw/a/vehicle.yaml"),), output))


def record() -> AllocatorValidation | None:
    """Return what the stage left."""
    path = Path("processed/a/validation.json")
    return read_envelope(path, "validation", AllocatorValidation).record


@pytest.mark.usefixtures("here")
def test_a_bundled_vehicle_is_flown_shown_and_printed(repository: Path) -> None:
    text = (bundled_vehicle("rov8") / "vehicle.yaml").read_text(encoding="utf-8")
    assert ran(text) == ""
    flown = record()
    assert flown is not None
    assert flown.allocator == "general"
    assert len(flown.keeping) == 15
    assert len(flown.steps) == 30
    by = {(one.speed_mps, one.variant): one for one in flown.keeping}
    last = flown.speed_mps[-1]
    assert by[last, "compensated"].speed_error_mps < by[last, "mooring"].speed_error_mps / 5
    assert by[last, "compensated"].shaft_power_w is None
    assert "not" in flown.power_text
    section = validation_section(VehicleResults(bundled(repository, "rov8"), validation=flown))
    assert section.available
    printed = _text("rov8", flown)
    assert printed.count("compensated") >= 16
    assert "\nnan" not in printed


def test_a_vehicle_without_a_model_is_not_flown_and_nobody_is_warned(here: Path) -> None:
    text = (
        "name: a\ntitle: A\nwater: {density_kgpm3: 1000.0, gravity_mps2: 9.81}\n"
        "propellers: {screw: {diameter_m: 0.14}}\n"
        "drives: {motor: {code_min: -127, code_max: 127}}\n"
        "tables: {propeller: screw, drive: motor}\n"
    )
    assert "no model: section" in ran(text)
    why = json.loads((here / "processed/a/validation.json").read_text("utf-8"))["why_not"]
    vehicle = load_vehicle(here / "raw/a")
    results = VehicleResults(vehicle, missing={"validation": why})
    assert "validation" not in missing_reasons(results)
    section = validation_section(results)
    assert not section.available


@pytest.mark.usefixtures("here")
def test_a_turned_thruster_is_named(repository: Path) -> None:
    text = (repository / "raw/mmt300/vehicle.yaml").read_text(encoding="utf-8")
    turned = text.replace(
        "direction: [0.92388, -0.38268, 0.0]", "direction: [-0.92388, 0.38268, 0.0]"
    )
    assert turned != text
    assert "left pushes the other way" in ran(turned)


def test_bench_tables_that_are_missing_are_the_reason(here: Path, repository: Path) -> None:
    shutil.copy(repository / "raw/mmt300/vehicle.yaml", here / "raw/a/vehicle.yaml")
    write_envelope(
        Path("processed/a/static.json"),
        Envelope[Record]("static", "a", {}, "c0", None, "There are no load-test files."),
    )
    inputs = (Path("raw/a/vehicle.yaml"), Path("processed/a/static.json"))
    said = validation.run(Job("validation", "a", "c0", inputs, Path("processed/a/validation.json")))
    assert "load-test files" in said
