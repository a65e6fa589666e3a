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
