"""Measured tank runs of a BlueROV2, converted by the documented script and read back."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from pipeline.identify.manoeuvre_detection import find_manoeuvres
from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.records.run_arrays import PoolRun
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

HERE = Path(__file__).parent
#: In this run pitch was asked for less than half as much as in any other, yet the vehicle
#: pitched at 0.3 rad/s: something else moved it, not the command (correlation 0.24).
HARDLY_PITCHED = "rosbag2_2025_05_27-11_40_38_0_6dof_measured.npz"
PITCH = 4


@pytest.fixture(name="script", scope="module")
def script_fixture(repository: Path) -> ModuleType:
    path = repository / "docs" / "examples" / "brov2_tank_to_mcap.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(name="vehicle", scope="module")
def vehicle_fixture() -> Vehicle:
    return load_vehicle(HERE / "brov2_tank")


@pytest.fixture(name="runs", scope="module")
def runs_fixture(
    shared_data: Path,
    script: ModuleType,
    vehicle: Vehicle,
    tmp_path_factory: pytest.TempPathFactory,
) -> dict[Path, PoolRun]:
    sources = sorted((shared_data / "brov2_tank_mocap").glob("*.npz"))
    if not sources:
        pytest.skip("no tank runs")
    folder = tmp_path_factory.mktemp("raw")
    script.main([str(sources[0].parent), "--to", str(folder / "brov2_tank")])
    logs = sorted((folder / "brov2_tank" / "pool").glob("*.mcap"))
    return {
        source: read_pool_run(log, vehicle, folder)
        for source, log in zip(sources, logs, strict=True)
    }


def test_the_arrays_come_back_to_the_last_bit(runs: dict[Path, PoolRun]) -> None:
    for source, run in runs.items():
        with np.load(source) as arrays:
            velocity, positions = arrays["velocities_body"], arrays["positions"]
            stamps_ns = arrays["timestamps_ns"].astype(np.int64)
        np.testing.assert_array_equal(run.channels["velocity"].values, velocity[:, :3])
        np.testing.assert_array_equal(run.channels["angular_velocity"].values, velocity[:, 3:])
        np.testing.assert_array_equal(run.channels["position"].values, positions[:, :3])
        assert np.abs(run.channels["velocity"].time_ns - stamps_ns).max() <= 1000
        assert run.channels["thruster_command"].values.shape == (len(velocity) - 1, 8)
        assert not [p.what for p in run.problems if p.severity == "error"]


def test_heading_and_position_belong_together_after_the_turn(runs: dict[Path, PoolRun]) -> None:
    """Body velocity, turned by the attitude, is the rate of the position."""
    for source, run in runs.items():
        table = resample(run, 20.0)
        q = table.values["attitude"]
        w, vector = q[:, :1], q[:, 1:]
        v = table.values["velocity"]
        cross = np.cross(vector, v)
        turned = v + 2.0 * (w * cross + np.cross(vector, cross))
        moved = np.gradient(table.values["position"], table.time_s, axis=0)
        good = np.isfinite(turned).all(axis=1) & np.isfinite(moved).all(axis=1)
        flat = slice(0, 2)
        rest = np.mean((turned - moved)[good, flat] ** 2) / np.mean(moved[good, flat] ** 2)
        assert rest < 0.15, source.name


def test_the_commands_push_the_way_the_vehicle_goes(
    runs: dict[Path, PoolRun], vehicle: Vehicle, script: ModuleType
) -> None:
    """Force and moment of the codes by the vehicle file lead the velocity of the same axis."""
    direction = np.array([one.direction for one in vehicle.thrusters])
    arm = np.cross([one.position_m for one in vehicle.thrusters], direction)
    matrix = np.hstack([direction, arm])
    compared = set()
    for source, run in runs.items():
        wrench = run.channels["thruster_command"].values @ matrix
        nu = np.hstack([run.channels[name].values for name in ("velocity", "angular_velocity")])
        with np.load(source) as arrays:
            asked = arrays["rc_scaled_controls"][:, script.AXES].std(axis=0)
        for axis in np.flatnonzero(asked > 0.02):
            if source.name == HARDLY_PITCHED and axis == PITCH:
                assert asked[PITCH] < 0.04  # or there is no reason to leave it out
                continue
            compared.add(int(axis))
            best = max(
                np.corrcoef(wrench[: len(wrench) - lag, axis], nu[lag : len(wrench), axis])[0, 1]
                for lag in range(7)
            )
            assert best > 0.5, (source.name, axis)
    assert compared == set(range(6))


def test_no_swap_is_suspected_and_something_is_recognised(
    runs: dict[Path, PoolRun], vehicle: Vehicle
) -> None:
    code_max = np.array([vehicle.drives[one.drive].code_max for one in vehicle.thrusters], float)
    for run in runs.values():
        assert not [p.what for p in run.problems if "swapped" in p.what]
        found = find_manoeuvres(resample(run, 20.0), code_max)
        assert sum(one.to_s - one.from_s for one in found) > 0.9 * run.duration_s
