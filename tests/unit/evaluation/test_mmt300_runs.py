"""The pool runs of mmt300: what is committed is what the generator flies, with the stated truth."""

import re
from pathlib import Path

import numpy as np
import pytest

from evaluation.bundled.mmt300_runs import (
    DEGRADED,
    RUNS,
    TRUTH,
    table2_characteristic,
    true_vehicle,
)
from evaluation.bundled.mmt300_truth import TABLE2, table2_thrust, working_point
from evaluation.bundled.run_logs import write_bundled_runs
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.physics.parameters import read
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle


@pytest.fixture(scope="module")
def folder(repository: Path) -> Path:
    return repository / "raw" / "mmt300"


@pytest.fixture(scope="module")
def vehicle(folder: Path) -> Vehicle:
    return load_vehicle(folder)


def test_the_committed_runs_are_what_the_generator_flies(folder: Path, tmp_path: Path) -> None:
    """The shortest is flown again; all that are committed are runs of the generator."""
    shortest = min(RUNS, key=lambda run: run.duration_s)
    (path,) = write_bundled_runs(folder, tmp_path, [shortest])
    same = path.read_bytes() == (folder / "pool" / path.name).read_bytes()
    assert same, "run python -m evaluation.bundled.run_logs --to raw/mmt300"
    committed = {path.name for path in (folder / "pool").glob("*.mcap")}
    assert committed == {f"{run.name}.mcap" for run in RUNS}


def test_the_runs_stay_small(folder: Path) -> None:
    sizes = [path.stat().st_size for path in (folder / "pool").glob("*.mcap")]
    assert max(sizes) < 300_000
    assert sum(sizes) < 1_300_000


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_every_run_is_read_without_a_warning(run: object, folder: Path, vehicle: Vehicle) -> None:
    name, duration_s = run.name, run.duration_s  # type: ignore[attr-defined]
    read_run = read_pool_run(folder / "pool" / f"{name}.mcap", vehicle, folder.parent)
    assert [p.what for p in read_run.problems if p.severity != "note"] == []
    assert read_run.duration_s == pytest.approx(duration_s, abs=0.05)
    table = resample(read_run, 10.0)
    assert table.thrusters == ("upper", "lower", "left", "right", "bow")
    assert set(table.values) == {
        *("command", "shaft_speed", "angular_velocity", "specific_force", "attitude"),
        *("velocity", "depth", "position", "voltage"),
    }
    assert not any(topic.topic.startswith("/sim") for topic in read_run.topics)


def test_the_notes_are_those_of_a_run(folder: Path, vehicle: Vehicle) -> None:
    run = read_pool_run(folder / "pool" / "2024-05-14-surge-steps.mcap", vehicle, folder.parent)
    assert run.notes is not None
    assert run.notes.healthy
    assert run.notes.file == "mmt300/pool/2024-05-14-surge-steps.yaml"


def test_the_truth_is_the_one_that_the_readme_states(folder: Path, vehicle: Vehicle) -> None:
    """Each number of the table in README.md, against the parameter vector that was flown."""
    packed = true_vehicle(vehicle)
    specs = tuple(parse_effect(text, packed.thruster_names) for text in TRUTH)
    true = apply_effects(packed.vector, specs, packed.context)

    def of(name: str, *axes: int) -> tuple[float, float]:
        both = [np.asarray(read(vector, name)) for vector in (packed.vector, true)]
        diagonal = [np.diag(one) if one.ndim == 2 else one for one in both]
        for axis in axes:
            assert diagonal[1][axis] == pytest.approx(diagonal[1][axes[0]])
        return float(diagonal[0][axes[0]]), float(diagonal[1][axes[0]])

    lift = [
        float(read(vector, "buoyancy") - read(vector, "weight")) for vector in (packed.vector, true)
    ]
    expected = {
        "added mass, surge": of("added_mass", 0),
        "added mass, sway and heave": of("added_mass", 1, 2),
        "added inertia, pitch and yaw": of("added_mass", 4, 5),
        "quadratic damping, surge": of("quadratic_damping", 0),
        "quadratic damping, sway and heave": of("quadratic_damping", 1, 2),
        "quadratic damping, pitch and yaw": of("quadratic_damping", 4, 5),
        "buoyancy less weight": (lift[0], lift[1]),
    }
    text = (folder / "README.md").read_text(encoding="utf-8")
    for name, values in expected.items():
        row = re.search(rf"^\| {name} \| ([0-9.]+) [^|]*\| ([0-9.]+) ", text, re.MULTILINE)
        assert row is not None, name
        np.testing.assert_allclose([float(row[1]), float(row[2])], values, atol=0.06, rtol=2e-3)
    for spec in (*TRUTH, "thruster_degraded"):
        assert spec in text
    assert DEGRADED.endswith("=0.7@upper")


@pytest.mark.parametrize("speed_mps", sorted(TABLE2))
def test_the_thrusters_push_as_table_2_says(speed_mps: float) -> None:
    static = table2_characteristic()
    row = static.speed_mps.index(speed_mps)
    for code in (1, 14, 20, 60, 127):
        thrust_n = table2_thrust(code, speed_mps)
        assert static.thrust_n[row][code - 1] == pytest.approx(thrust_n, abs=1e-9)
        if thrust_n > 0:
            rpm = working_point(code, speed_mps)[0]
            assert static.shaft_speed_rpm[row][code - 1] == pytest.approx(rpm, rel=1e-9)
