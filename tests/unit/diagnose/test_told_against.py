"""The verdict names what it is told against, the runs asked, and the sentence."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.diagnose import engine
from pipeline.diagnose.case import Case
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import pack_vehicle
from pipeline.vehicle.load import load_vehicle


@pytest.mark.parametrize("since", [None, "first, second"])
def test_a_verdict_names_its_runs_and_what_it_is_told_against(
    monkeypatch: pytest.MonkeyPatch, since: str | None
) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    vehicle = load_vehicle(bundled_vehicle("rov8"))
    runs = tuple(RunTable(name, np.zeros(0), {}, {}) for name in ("a", "b"))
    case = Case("rov8", vehicle, pack_vehicle(vehicle), runs)
    plain = diagnosis_records.diagnosis(channels=("w",), windows=1)
    verdict = engine._told(plain, case, since, 0.0).verdict
    assert verdict.since == since
    assert verdict.runs == ("a", "b")
    assert verdict.text == plain.verdict.sentence


@pytest.mark.parametrize(
    ("alone", "named"),
    [
        ({"a": "none", "b": "thruster_degraded"}, ("b",)),
        ({"a": "thruster_degraded", "b": "thruster_degraded"}, ("a", "b")),
        ({"a": "unknown", "b": "thruster_degraded"}, ()),
        ({"a": "dead_zone", "b": "thruster_degraded"}, ()),
        ({"a": "none", "b": "none"}, ()),
    ],
)
def test_what_is_unknown_of_all_is_told_of_the_runs_that_one_change_explains(
    monkeypatch: pytest.MonkeyPatch, alone: dict[str, str], named: tuple[str, ...]
) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    vehicle = load_vehicle(bundled_vehicle("rov8"))
    runs = tuple(RunTable(name, np.zeros(0), {}, {}) for name in alone)
    case = Case("rov8", vehicle, pack_vehicle(vehicle), runs)
    plain = diagnosis_records.diagnosis(channels=("w",), windows=1)

    def told(effect: str, names: tuple[str, ...]) -> engine.Diagnosis:
        verdict = plain.verdict.model_copy(update={"effects": (effect,)})
        return engine.Diagnosis(plain.model_copy(update={"verdict": verdict, "runs": names}), ())

    def diagnosed(case: Case, *_: object) -> tuple[engine.Diagnosis, None]:
        (run,) = case.runs
        return told(alone[run.name], (run.name,)), None

    monkeypatch.setattr(engine, "_diagnosed", diagnosed)
    together = told("unknown", ("a", "b"))
    found = engine._run_by_run(case, together, 1, 0, 0.0)
    if not named:
        assert found is together
        return
    assert found.record.verdict.effects == ("thruster_degraded",)
    assert found.record.verdict.runs == named
    assert found.record.runs == ("a", "b")
    assert f"Only in {', '.join(named)}." in found.record.verdict.text
