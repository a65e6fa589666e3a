"""Sizes in floors: what healthy runs themselves seem to have of an effect is one."""

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.effects.library import parse_effect
from pipeline.errors import CannotComputeError
from pipeline.measured.floors import channel_floors, healthy_scatter, signature
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.simulate.run import run
from pipeline.vehicle.load import load_vehicle

PERIOD_S = 0.02


@pytest.fixture(scope="module")
def rov() -> PackedVehicle:
    return pack_vehicle(load_vehicle(bundled_vehicle("rov8")))


def flown(rov: PackedVehicle, seed: int, push_n: float = 0.0) -> RunTable:
    """30 s of held codes on the level thrusters, pushed down by a force that nobody logged."""
    generator = np.random.default_rng(seed)
    levels = generator.uniform(-0.4, 0.4, (15, len(rov.thruster_names)))
    levels[:, 4:] = levels[:, 4:5]
    codes = np.repeat(levels, 100, axis=0) * rov.code_limits[:, 1]
    outside = np.zeros((1, 6))
    outside[0, 2] = push_n
    made = run(rov, codes, dt_s=PERIOD_S, external=outside)
    values = {
        "command": codes,
        "angular_velocity": made.nu[:-1, 3:] + 1e-3 * generator.standard_normal((1500, 3)),
        "velocity": made.nu[:-1, :3] + 1e-3 * generator.standard_normal((1500, 3)),
        "attitude": made.quaternion[:-1],
    }
    return RunTable("run", made.time_s[:-1], values, dict.fromkeys(values, np.ones(1500, bool)))


def test_the_floor_is_what_runs_differ_by(rov: PackedVehicle) -> None:
    """Runs pushed by -4, -2, 2 and 4 N look lighter and heavier by as much, each to the others."""
    spread = healthy_scatter(rov, [flown(rov, k, push) for k, push in enumerate((-4, -2, 2, 4))])
    calm = healthy_scatter(rov, [flown(rov, k) for k in range(4)])
    one = [parse_effect("residual_buoyancy:force_n=10")]
    asked = flown(rov, 9)
    size, among_calm = (
        np.sqrt(np.mean(signature(runs, asked, one)[:, 2] ** 2)) / channel_floors(runs, one)[2]
        for runs in (spread, calm)
    )
    # left out, each run is off by 4/3 of its push: sqrt(mean((4/3 push)^2)) = 4.2 N is a floor
    assert size == pytest.approx(10.0 / 4.2, rel=0.4)
    assert among_calm > 3.0 * size


def test_a_signature_grows_with_the_effect(rov: PackedVehicle) -> None:
    runs = [flown(rov, k) for k in range(3)]
    scatter = healthy_scatter(rov, runs)
    one, two = (
        signature(scatter, runs[0], [parse_effect(f"residual_buoyancy:force_n={force}")])
        for force in (4.0, 8.0)
    )
    np.testing.assert_allclose(two[:, 2], 2.0 * one[:, 2], atol=0.2 * np.abs(one[:, 2]).max())
    floors = channel_floors(scatter, [parse_effect("residual_buoyancy:force_n=4")])
    assert (floors[np.isfinite(floors)] > 0.0).all()


def test_one_run_shows_no_scatter(rov: PackedVehicle) -> None:
    with pytest.raises(CannotComputeError, match="takes two at least"):
        healthy_scatter(rov, [flown(rov, 0)])
