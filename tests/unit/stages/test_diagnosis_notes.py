"""What of the vehicle took no part in a diagnosis is said."""

from pathlib import Path

import pytest

from pipeline.diagnose.engine import Diagnosis
from pipeline.stages import diagnosis
from pipeline.stages.diagnosis import DiagnosisRequest, diagnose_to_files


@pytest.mark.parametrize(("vehicle", "told"), [("cargo_carrier", True), ("rov8", False)])
def test_a_tether_that_is_not_simulated_is_named(
    vehicle: str, told: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    found = Diagnosis(diagnosis_records.diagnosis(channels=("w",), windows=1), ())
    monkeypatch.setattr(diagnosis, "_tables", lambda *_: ())
    monkeypatch.setattr(diagnosis, "find_logs", lambda *_: ())
    monkeypatch.setattr(diagnosis, "diagnose_fully", lambda *_: found)
    monkeypatch.setattr(diagnosis, "write_page", lambda *_: tmp_path / "page.html")
    files = diagnose_to_files(DiagnosisRequest(vehicle, ("run",), to=tmp_path))
    added = files.record.notes[len(found.record.notes) :]
    assert ["tether" in note for note in added] == [True] * told
