"""Logs with the effect: what an earlier diagnosis left goes, what is asked of now stays."""

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import pytest

from pipeline.actions import diagnosis
from pipeline.actions.diagnosis import DiagnosisRequest, _write_overlays
from pipeline.actions.simulation_request import SimulationRequest
from pipeline.effects.specification import EffectSpec
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated


@dataclass(frozen=True)
class _Simulated:
    path: Path


@pytest.fixture
def one(monkeypatch: pytest.MonkeyPatch) -> SimulatedVehicle:
    def simulate(request: SimulationRequest) -> _Simulated:
        request.to.write_text("simulated")
        return _Simulated(request.to)

    monkeypatch.setattr(diagnosis, "simulate_to_file", simulate)
    return load_simulated("rov8", Path("raw"), Path())


def written(
    request: DiagnosisRequest, folder: Path, one: SimulatedVehicle, *effects: str
) -> list[str]:
    specs = cast("tuple[EffectSpec, ...]", effects)
    paths, without = _write_overlays(request, folder, one, specs, lambda _: None)
    assert without == ()
    return [path.name for path in paths]


def test_only_what_an_earlier_diagnosis_left_is_taken_away(
    one: SimulatedVehicle, tmp_path: Path
) -> None:
    asked, judge, healthy, old = (
        tmp_path / f"{name}_with_effect.mcap" for name in ("asked", "judge", "healthy", "old")
    )
    for log in (asked, judge, healthy, old):
        log.write_text("recorded")
    request = DiagnosisRequest("rov8", (str(asked),), (str(judge),), (str(healthy),))
    assert written(request, tmp_path, one) == []
    assert sorted(tmp_path.iterdir()) == sorted([asked, judge, healthy])


@pytest.mark.parametrize("to", [False, True])
def test_no_run_is_written_over(one: SimulatedVehicle, tmp_path: Path, *, to: bool) -> None:
    """A run may have the name that the log with the effect of another would have."""
    first, second = tmp_path / "dive.mcap", tmp_path / "dive_with_effect.mcap"
    for log in (first, second):
        log.write_text("recorded")
    request = DiagnosisRequest(
        "rov8", (str(first), str(second)), to=tmp_path if to else None, out=tmp_path
    )
    names = written(request, tmp_path, one, "current")
    assert names == ["dive-2_with_effect.mcap", "dive_with_effect_with_effect.mcap"]
    assert first.read_text() == second.read_text() == "recorded"


def test_every_log_has_a_name_of_its_own(one: SimulatedVehicle, tmp_path: Path) -> None:
    logs = [tmp_path / name for name in ("mon/a.mcap", "tue/A.mcap", "a-2.mcap")]
    for log in logs:
        log.parent.mkdir(exist_ok=True)
        log.write_text("recorded")
    request = DiagnosisRequest("rov8", tuple(map(str, logs)))
    names = written(request, tmp_path, one, "current")
    assert len({name.lower() for name in names}) == 3
