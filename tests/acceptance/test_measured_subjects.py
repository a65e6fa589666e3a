"""The public measured vehicles as the measured blind check has them."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.campaign.measured_subjects import MeasuredSubject, load_subject
from pipeline.diagnose.events.force_step import force_step, outside_force
from pipeline.effects.library import parse_effect
from pipeline.measured.inject import commanded_without_effect, injected


@pytest.fixture(scope="module")
def tank(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> MeasuredSubject:
    if not (shared_data / "brov2_tank_mocap").is_dir():
        pytest.skip("no tank runs")
    return load_subject(shared_data / "brov2_tank_mocap", tmp_path_factory.mktemp("cache"))


def test_an_effect_stands_in_a_tank_run(tank: MeasuredSubject) -> None:
    run = min(tank.runs, key=lambda one: one.time_s.size)
    for text in ("residual_buoyancy:force_n=8", "thruster_lag:lag_s=0.3", "added_mass:surge=2.5"):
        put = injected(tank.packed, run, [parse_effect(text)], tank.vehicle.sensors)
        assert put.share > 0.75, text
        low, high = tank.packed.code_limits.T
        codes = put.run.values["command"]
        assert (codes >= low - 1e-6).all()
        assert (codes <= high + 1e-6).all()


def test_the_sway_thruster_of_the_pool_stood_still(shared_data: Path, tmp_path: Path) -> None:
    if not (shared_data / "exjobbrov_pool").is_dir():
        pytest.skip("no pool runs")
    pool = load_subject(shared_data / "exjobbrov_pool", tmp_path)
    assert len(pool.runs) == 27
    told = commanded_without_effect(pool.packed, pool.runs[8], "sway")
    assert np.abs(told.values["command"][:, 5]).max() == 160.0
    # nothing was let go in any run, and no file of a vehicle is so wrong that it looks like it
    for run in pool.runs:
        assert force_step(outside_force(pool.packed, run, pool.vehicle.sensors)) is None, run.name


def test_nothing_was_let_go_in_the_tank(tank: MeasuredSubject) -> None:
    for run in tank.runs:
        assert force_step(outside_force(tank.packed, run, tank.vehicle.sensors)) is None, run.name
