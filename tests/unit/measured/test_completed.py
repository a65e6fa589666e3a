"""What a run did not measure is derived from what it did."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.measured.completed import completed
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

PERIOD_S, ROWS = 0.05, 400
TIME_S = PERIOD_S * np.arange(ROWS)
G = 9.81


def table(*, every: int = 1, **values: FloatArray) -> RunTable:
    """Channels that are all valid; the position is read every so many rows."""
    reading = np.zeros(ROWS, bool)
    reading[::every] = True
    return RunTable(
        "run",
        TIME_S,
        dict(values),
        {name: np.ones(ROWS, bool) for name in values},
        reading={"position": reading} if "position" in values else {},
    )


def quaternion(turn: Rotation) -> FloatArray:
    return np.asarray(turn.as_quat()[:, [3, 0, 1, 2]])


def test_rates_are_those_of_a_turn_about_a_fixed_axis() -> None:
    omega = np.array([0.1, -0.2, 0.3])
    found = completed(table(attitude=quaternion(Rotation.from_rotvec(TIME_S[:, None] * omega))))
    inside = found.values["angular_velocity"][20:-20]
    assert inside == pytest.approx(np.tile(omega, (len(inside), 1)), abs=1e-3)


def test_roll_and_pitch_follow_from_gravity_at_rest() -> None:
    turn = Rotation.from_euler("ZYX", [0.0, 0.2, -0.1])
    force = np.tile(turn.inv().apply([0.0, 0.0, -G]), (ROWS, 1))
    found = completed(table(angular_velocity=np.zeros((ROWS, 3)), specific_force=force))
    expected = turn.as_quat()[[3, 0, 1, 2]]
    assert np.abs(found.values["attitude"] @ expected) == pytest.approx(np.ones(ROWS))


def circle(every: int) -> RunTable:
    """Half a metre a second ahead, along a circle of a metre."""
    heading = 0.5 * TIME_S
    place = np.column_stack([np.sin(heading), -np.cos(heading), np.zeros(ROWS)])
    attitude = quaternion(Rotation.from_euler("z", heading[:, None]))
    return table(position=place, attitude=attitude, every=every)


def test_a_vehicle_on_a_circle_moves_ahead() -> None:
    velocity = completed(circle(every=2)).values["velocity"][20:-20]
    assert velocity[:, 0] == pytest.approx(np.full(len(velocity), 0.5), abs=5e-3)
    assert np.abs(velocity[:, 1:]).max() < 5e-3


def test_a_place_that_is_seldom_read_tells_no_velocity() -> None:
    assert "velocity" not in completed(circle(every=40)).values


def test_what_was_measured_stays() -> None:
    own = table(
        attitude=quaternion(Rotation.from_euler("z", 0.1 * TIME_S[:, None])),
        angular_velocity=np.ones((ROWS, 3)),
    )
    assert completed(own) is own
