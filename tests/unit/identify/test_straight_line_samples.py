"""Straight stretches are found where they are, and only there."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.identify.straight_line_samples import straight_stretches
from pipeline.records.run_table import RunTable

TIME_S = np.arange(0.0, 60.0, 0.02)


def run_with(rate: np.ndarray, pitch: np.ndarray | None = None) -> RunTable:
    values = {"command": np.zeros((TIME_S.size, 1)), "angular_velocity": rate}
    if pitch is not None:
        x, y, z, w = Rotation.from_rotvec(np.outer(pitch, [0.0, 1.0, 0.0])).as_quat().T
        values["attitude"] = np.stack([w, x, y, z], axis=1)
    valid = {name: np.ones(TIME_S.size, bool) for name in values}
    return RunTable("made up", TIME_S, values, valid)


@pytest.fixture
def ahead() -> np.ndarray:
    velocity = np.zeros((TIME_S.size, 3))
    velocity[:, 0] = 1.0
    return velocity


def test_a_turn_divides_a_run(ahead: np.ndarray) -> None:
    rate = np.zeros((TIME_S.size, 3))
    rate[(TIME_S > 20) & (TIME_S < 30), 2] = 0.1
    stretches = straight_stretches(run_with(rate), ahead, 0)
    times = [(one.from_s, one.to_s) for one in stretches]
    # the mean over half a second sees the turn a little before and after
    np.testing.assert_allclose(times, [(0.26, 19.9), (30.1, 59.7)], atol=0.25)


def test_noise_of_the_gyro_does_not_divide_a_run(ahead: np.ndarray) -> None:
    rate = 0.02 * np.random.default_rng(0).standard_normal((TIME_S.size, 3))
    assert len(straight_stretches(run_with(rate), ahead, 0)) == 1


@pytest.mark.parametrize(("sideways", "count"), [(0.05, 1), (0.2, 0)])
def test_drift_is_judged_against_the_speed(ahead: np.ndarray, sideways: float, count: int) -> None:
    ahead[:, 1] = sideways
    found = straight_stretches(run_with(np.zeros((TIME_S.size, 3))), ahead, 0)
    assert len(found) == count
    assert all(one.largest_drift == pytest.approx(sideways) for one in found)


def test_a_tilted_vehicle_is_not_straight(ahead: np.ndarray) -> None:
    pitch = np.where(TIME_S < 40, 0.0, 0.3)
    run = run_with(np.zeros((TIME_S.size, 3)), pitch)
    (one,) = straight_stretches(run, ahead, 0)
    assert one.to_s == pytest.approx(40.0, abs=0.05)


def test_gaps_and_short_pieces_are_left_out(ahead: np.ndarray) -> None:
    run = run_with(np.zeros((TIME_S.size, 3)))
    valid = dict(run.valid)
    valid["command"] = (TIME_S < 3.0) | (TIME_S > 10.0)
    ahead[(TIME_S > 30) & (TIME_S < 31)] = np.nan
    found = straight_stretches(replace(run, valid=valid), ahead, 0)
    assert [round(one.from_s) for one in found] == [10, 31]
