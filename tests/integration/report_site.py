"""Every kind of page of a report from small records; a module of the tests."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from pipeline.actions.design import DesignRequest, compute_design
from pipeline.bundled.design import design_example
from pipeline.records.base import Advice, Glance
from pipeline.records.trial import RunLine
from pipeline.report.design_page import design_page
from pipeline.report.diagnosis_page import diagnosis_page
from pipeline.report.html import placed, write_page
from pipeline.report.page import write_index
from pipeline.report.results import DayResults, VehicleResults
from pipeline.report.run_page import run_page
from pipeline.report.trial_page import day_page
from pipeline.report.vehicle_page import vehicle_page, vehicle_receipt

#: Kind of page -> where the workflow would put it.
PLACES = {
    "index": "index.html",
    "vehicle": "synthetic/index.html",
    "run": "synthetic/runs/zig-zag.html",
    "trial": "synthetic/trials/2026-05-04.html",
    "diagnosis": "synthetic/diagnoses/a/index.html",
    "design": "design/pilgrim-balance.html",
}
KINDS = tuple(PLACES)
#: As long as a first screen gets.
GLANCE = Glance(
    light="red",
    matter="The upper thruster gives 69 % of its thrust (63 to 76 %), only in zig-zag; sure to "
    "0.89, or perhaps: thrust astern differs from the stated one.",
    short="the upper thruster gives 69 % of its thrust (63 to 76 %)",
    do=(
        Advice(text="Look at its propeller and shaft: weed, a chipped blade, a loose hub."),
        Advice(
            text="If it stays as it is, take it into the vehicle file.",
            command="rig2sea apply synthetic 2026-05-04",
        ),
    ),
    fly_next="Zig-zag again once that is done: it shows whether the fault is gone.",
    last_advice="Of 2026-05-03: to fly heave steps. Not followed; now: the upper thruster gives "
    "69 % of its thrust (63 to 76 %).",
)


def write_site(reports: Path) -> None:
    """Write a page of every kind into a folder of reports."""
    found = {kind: reports / place for kind, place in PLACES.items()}
    assets = reports / "assets"
    up = (("All vehicles", "../../index.html"), ("synthetic", "../index.html"))
    results, day = _results()
    scripts = {kind: placed(assets, page) for kind, page in found.items()}
    write_page(vehicle_page(results, assets=scripts["vehicle"]), found["vehicle"])
    run = _module("run_records").run_results(results.vehicle)
    write_page(run_page(run, up, scripts["run"], GLANCE), found["run"])
    write_page(day_page(replace(day, glance=GLANCE), up, scripts["trial"]), found["trial"])
    diagnosis = _module("diagnosis_records").diagnosis(channels=("w", "psi", "z"), windows=6)
    text = diagnosis_page(diagnosis, assets=placed(assets, found["diagnosis"]))
    write_page(text, found["diagnosis"])
    up_one = (("Index", "../index.html"),)
    text = design_page(_design(reports.parent), up_one, scripts["design"])
    write_page(text, found["design"])
    write_index(
        [vehicle_receipt(results, {})],
        found["index"],
        {
            "synthetic": (
                ("residual buoyancy (96 %); pool-1", "synthetic/diagnoses/a/index.html"),
            ),
            "raft": (("tether (80 %); r-1", "raft/diagnoses/b/index.html"),),
        },
        designs=(("Pilgrim: steady motion", "design/pilgrim-balance.html"),),
        assets=assets,
    )


def _results() -> tuple[VehicleResults, DayResults]:
    """Return the synthetic vehicle with two trial days, and the later of them."""
    results = _module("synthetic_records").full_results()
    trials = _module("test_trial_pages")
    day = trials.day(results, 15.0, 10.2)
    runs = {"2026-05-03": "heave-steps", "2026-05-04": "zig-zag"}
    links = tuple(
        trials.linked(name, value).model_copy(
            update={
                "line": "1 run; no warnings",
                "page": f"reports/synthetic/trials/{name}.html",
                "runs": (
                    RunLine(
                        name=run,
                        line="60 s; depth to the bottom and back",
                        page=f"reports/synthetic/runs/{run}.html",
                        glance=GLANCE,
                    ),
                ),
                "glance": GLANCE,
            }
        )
        for (name, run), value in zip(runs.items(), (10.2, 15.0), strict=True)
    )
    page = Path("reports/synthetic/index.html")
    return type(results)(**{**results.__dict__, "page": page, "trials": links}), day


def _design(folder: Path) -> Any:  # noqa: ANN401 - one of three records
    path = folder / "pilgrim.yaml"
    path.write_bytes(design_example("balance", "pilgrim").read_bytes())
    return compute_design(DesignRequest("balance", path))


def _module(name: str) -> ModuleType:
    """Load a module of records that stands beside the unit tests of the pages."""
    folder = Path(__file__).parents[1] / "unit/report"
    known = f"{name}_for_browser"
    if known in sys.modules:
        return sys.modules[known]
    spec = importlib.util.spec_from_file_location(known, folder / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[known] = module
    spec.loader.exec_module(module)
    return module
