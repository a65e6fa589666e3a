"""Runs of a vehicle and a simulator that the package has never seen, by the command."""

import json
from pathlib import Path
from typing import Any

import pytest
from another_simulator import Scout, write_run
from click.testing import CliRunner

from pipeline.cli import cli
from pipeline.diagnose import case
from pipeline.effects.effect import Effect, EffectContext
from pipeline.effects.library import candidates

#: Each of another kind: a force, drag, inertia, and two of the thrusters.
FEW = ("residual_buoyancy", "quadratic_damping", "added_mass", "voltage_sag", "thruster_degraded")

CURVE = "thrust_max_n: 40.0, thrust_min_n: -31.0, dead_zone_code: 6, exponent: 2.0"
#: Least squares of the formula to that curve at every second code: 0.26 N rms, 0.73 N at most.
FITTED = "thrust_max_n: 40.73, thrust_min_n: -31.57, dead_zone_code: 9.2, exponent: 1.287"


def diagnosed(folder: Path, scout: Scout, seconds: float = 60.0) -> dict[str, Any]:
    text = (Path(__file__).parent / "scout.yaml").read_text(encoding="utf-8")
    assert CURVE in text
    if scout.jumps:
        text = text.replace(CURVE, FITTED)
    (folder / "vehicle.yaml").write_text(text, encoding="utf-8")
    for seed, kind in enumerate(("steps", "sines")):
        write_run(folder / "pool" / f"{kind}.mcap", scout, kind, seconds, seed)
    done = CliRunner().invoke(
        cli, ["diagnose", str(folder), "steps", "sines", "--to", str(folder / "out")]
    )
    assert done.exit_code == 0, done.stderr
    found = json.loads((folder / "out" / "diagnosis.json").read_text(encoding="utf-8"))
    assert isinstance(found, dict)
    return found


def some(context: EffectContext) -> dict[str, Effect]:
    return {name: effect for name, effect in candidates(context).items() if name in FEW}


def test_a_buoyancy_shows_in_short_runs_among_few(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(case, "candidates", some)
    force_n = 5.0
    scout = Scout(volume_m3=0.02107 + force_n / (1000.0 * 9.81))
    found = diagnosed(tmp_path, scout, seconds=16.0)
    assert found["verdict"]["effects"] == ["residual_buoyancy"]
    first = found["ranking"][0]["parameters"]["force_n"]
    assert first["ci95"][0] < force_n < first["ci95"][1]


@pytest.mark.slow
def test_a_vehicle_as_its_file_says_is_called_that(tmp_path: Path) -> None:
    """Also where the dead zone comes before the lag, of which a vehicle file says nothing."""
    found = diagnosed(tmp_path, Scout(dead_zone_first=True))
    assert found["verdict"]["effects"] == ["none"]
    assert found["verdict"]["ambiguous_with"] == []


@pytest.mark.slow
def test_a_formula_that_misses_the_foot_of_its_curve_is_told_so(tmp_path: Path) -> None:
    """Its dead zone is twice the real one, and at small codes there is thrust where it has none."""
    found = diagnosed(tmp_path, Scout(jumps=True))
    assert found["verdict"]["effects"] == ["dead_zone"]


@pytest.mark.slow
def test_a_buoyancy_is_found_and_its_size(tmp_path: Path) -> None:
    force_n = 5.0
    found = diagnosed(tmp_path, Scout(volume_m3=0.02107 + force_n / (1000.0 * 9.81)))
    assert found["verdict"]["effects"] == ["residual_buoyancy"]
    first = found["ranking"][0]["parameters"]["force_n"]
    assert first["ci95"][0] < force_n < first["ci95"][1]


@pytest.mark.slow
def test_a_low_supply_is_all_but_the_same_as_less_thrust(tmp_path: Path) -> None:
    """Beyond a dead zone before the drive both scale thrust, and no voltage is logged.

    Which of the two is named, and whether the other stands beside it, is a matter of chance.
    """
    found = diagnosed(tmp_path, Scout(dead_zone_first=True, supply=0.8))
    verdict = found["verdict"]
    said = {*verdict["effects"], *verdict["ambiguous_with"]}
    assert said <= {"voltage_sag", "thrust_deduction"}
    first, second = found["ranking"][:2]
    assert {first["effect"], second["effect"]} == {"voltage_sag", "thrust_deduction"}
    assert abs(first["log_evidence"] - second["log_evidence"]) < 5.0
    sag = next(one for one in found["ranking"] if one["effect"] == "voltage_sag")
    low, high = sag["parameters"]["drop"]["ci95"]
    assert low < 0.2 < high
