"""What took no part in a diagnosis, or could not be made of it, is said."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.actions import diagnosis
from pipeline.actions.diagnosis import DiagnosisRequest, diagnose_to_files
from pipeline.diagnose.engine import Diagnosis
from pipeline.effects.library import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.records.run_table import KnownOfRun, RunTable
from pipeline.stages.index_page import Question


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> Diagnosis:
    """A diagnosis that is asked of no log."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    answer = Diagnosis(diagnosis_records.diagnosis(channels=("w",), windows=1), ())
    monkeypatch.setattr(diagnosis, "read_runs", lambda *_: [])
    monkeypatch.setattr(diagnosis, "find_logs", lambda *_: ())
    monkeypatch.setattr(diagnosis, "diagnose_fully", lambda *_: answer)
    monkeypatch.setattr(diagnosis, "write_page", lambda *_: Path("page.html"))
    return answer


def test_what_is_known_of_a_run_and_was_not_simulated_is_named_once(
    tmp_path: Path, found: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = KnownOfRun(notes=("the tether is left out",))
    table = RunTable("run", np.zeros(0), {}, {}, known=known)
    monkeypatch.setattr(diagnosis, "read_runs", lambda *_: [(None, table)])
    files = diagnose_to_files(DiagnosisRequest("rov8", ("run",), to=tmp_path))
    assert files.record.notes[len(found.record.notes) :] == known.notes


def test_a_run_of_which_no_overlay_can_be_made_is_named(
    tmp_path: Path, found: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    def too_long(*_: object) -> None:
        raise CannotComputeError("the log is 4000 s long")

    spec = EffectSpec("residual_buoyancy", {"force_n": 5.0})
    monkeypatch.setattr(diagnosis, "diagnose_fully", lambda *_: replace(found, specs=(spec,)))
    monkeypatch.setattr(diagnosis, "find_logs", lambda *_: (Path("long.mcap"),))
    monkeypatch.setattr(diagnosis, "_question", lambda *_: Question(("long.mcap",)))
    monkeypatch.setattr(diagnosis, "simulate_to_file", too_long)
    files = diagnose_to_files(DiagnosisRequest("rov8", ("long",), to=tmp_path))
    assert files.overlays == ()
    assert files.without_overlay == ("long.mcap: the log is 4000 s long",)


def test_sound_runs_are_taken_for_healthy_where_none_are_named(
    tmp_path: Path, found: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    pool = tmp_path / "pool"
    sound = {pool / "a.mcap": "healthy: true in its notes", pool / "b.mcap": "by its day"}
    monkeypatch.setattr(diagnosis, "sound_runs", lambda _: (sound, ()))
    monkeypatch.setattr(diagnosis, "find_logs", lambda texts, _: [Path(text) for text in texts])
    told = "these are known to be sound and were taken: a (healthy: true in its notes), b"

    def notes(*runs: str, healthy: tuple[str, ...] = ()) -> str:
        request = DiagnosisRequest("rov8", runs, healthy=healthy, to=tmp_path / "to")
        return " ".join(diagnose_to_files(request).record.notes[len(found.record.notes) :])

    assert told in notes("c.mcap")
    assert not notes("c.mcap", healthy=("d.mcap",))
    assert not notes(str(pool / "a.mcap"))
