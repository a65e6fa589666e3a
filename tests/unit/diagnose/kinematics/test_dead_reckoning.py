"""Dead reckoning of motions known in closed form: what is wrong with the DVL comes out."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from reckoned_runs import lively, reckoned_run, straight

from pipeline.diagnose.kinematics.dead_reckoning import (
    ERRORS,
    NEUTRAL,
    mount_of,
    stretches,
    track_of,
)
from pipeline.diagnose.kinematics.dvl_errors import Reckoning, left_without, reckoning
from pipeline.records.run_table import RunTable
from pipeline.vehicle.sensor_schema import Sensors

UNIT = np.array([0.5, 0.25, 0.25, 0.25, 2.5, 2.5, 2.5, 0.05])
DVL: dict[str, Any] = {"rate_hz": 5.0, "noise_mps": 0.004, "source": "a test"}
PLAIN = Sensors.model_validate({"dvl": DVL})


def reckoned(*runs: RunTable, sensors: Sensors = PLAIN) -> Reckoning:
    tracks = [one for one in (track_of(run, sensors) for run in runs) if one is not None]
    found = reckoning(tracks, mount_of(sensors), UNIT, 1e-3)
    assert found is not None
    return found


def best(found: Reckoning) -> np.ndarray:
    """Most probable errors, in their own units."""
    return NEUTRAL + UNIT * np.linalg.solve(found.information, found.score)


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ({}, NEUTRAL),
        ({"delay_s": 0.3}, [0.3, 0, 0, 0, 0, 0, 0, 1]),
        ({"delay_s": -0.1}, [-0.1, 0, 0, 0, 0, 0, 0, 1]),
        ({"arm_m": (0.4, -0.2, 0.1)}, [0, 0.4, -0.2, 0.1, 0, 0, 0, 1]),
        ({"turn_deg": (2.0, -3.0, 5.0)}, [0, 0, 0, 0, 2, -3, 5, 1]),
        ({"scale": 1.1}, [0, 0, 0, 0, 0, 0, 0, 1.1]),
        (
            {"delay_s": 0.2, "arm_m": (0.0, 0.3, 0.0), "scale": 0.9},
            [0.2, 0, 0.3, 0, 0, 0, 0, 0.9],
        ),
    ],
)
def test_errors_of_the_dvl_come_out_as_they_were_put_in(
    wrong: dict[str, Any], expected: list[float]
) -> None:
    found = best(reckoned(reckoned_run(lively(), **wrong), reckoned_run(lively(20.0), **wrong)))
    # an angle of the mount is known no better than that of the attitude
    np.testing.assert_allclose(found / UNIT, np.array(expected) / UNIT, atol=0.06)


def test_a_dvl_that_is_mounted_turned_and_off_centre_is_no_error() -> None:
    sensors = Sensors.model_validate(
        {"dvl": DVL | {"position_m": [-0.3, 0.1, 0.2], "rotation_deg": [0.0, 0.0, 45.0]}}
    )
    run = reckoned_run(
        lively(), turn_deg=(0.0, 0.0, 3.0), place_m=(-0.3, 0.1, 0.2), mount_deg=(0.0, 0.0, 45.0)
    )
    found = best(reckoned(run, sensors=sensors))
    np.testing.assert_allclose(found, [0, 0, 0, 0, 0, 0, 3, 1], atol=0.02)


def test_straight_legs_show_neither_delay_nor_lever_arm() -> None:
    """Nothing changes and nothing turns; what is measured is speed, and the angle of the course."""
    told = np.diag(reckoned(reckoned_run(straight(), noise=(1e-3, 1e-3))).information)
    names = [parameter for _, parameter, _, _ in ERRORS]
    shown = {name for name, value in zip(names, told, strict=True) if value > 1e-3 * told.max()}
    assert shown == {"pitch_deg", "yaw_deg", "scale"}


def test_intervals_hold_what_they_promise() -> None:
    """Squared errors over their variance, on average over noise: one for each of the eight."""
    squares = []
    for seed in range(12):
        run = reckoned_run(
            lively(), delay_s=0.2, scale=1.05, noise=(0.01, 0.03), seed=seed, seconds=90.0
        )
        found = reckoned(run)
        off = best(found) - np.array([0.2, 0, 0, 0, 0, 0, 0, 1.05])
        squares.append(float((off / UNIT) @ found.information @ (off / UNIT)) / 8.0)
    assert 0.4 < np.mean(squares) < 1.3


def test_depth_shows_the_scale_beside_a_position_that_shows_little() -> None:
    run = reckoned_run(lively(), scale=1.1)
    rng = np.random.default_rng(3)
    values = run.values | {
        "depth": run.values["position"][:, 2:],
        "position": run.values["position"] + 50.0 * rng.standard_normal((run.time_s.size, 3)),
    }
    valid = run.valid | {"depth": run.valid["velocity"]}
    run = replace(run, values=values, valid=valid)
    run = replace(run, reading=run.reading | {"depth": run.reading["position"]})
    found = best(reckoned(run, replace(run, name="again")))
    assert found[7] == pytest.approx(1.1, abs=0.02)


def test_depth_alone_is_not_enough() -> None:
    run = reckoned_run(lively())
    values = {name: one for name, one in run.values.items() if name != "position"}
    values["depth"] = run.values["position"][:, 2:]
    valid = dict.fromkeys(values, run.valid["velocity"])
    reading = {"depth": run.reading["position"]}
    assert track_of(replace(run, values=values, valid=valid, reading=reading), PLAIN) is None


def test_without_a_place_or_an_attitude_there_is_nothing_to_hold_against() -> None:
    run = reckoned_run(lively())
    for name in ("position", "attitude", "angular_velocity", "velocity"):
        values = {key: one for key, one in run.values.items() if key != name}
        assert track_of(replace(run, values=values), PLAIN) is None


def test_a_stretch_in_which_the_velocity_is_missing_is_left_out() -> None:
    run = reckoned_run(lively())
    gone = run.valid["velocity"] & ~((run.time_s > 20.0) & (run.time_s < 25.0))
    values = run.values | {"velocity": np.where(gone[:, None], run.values["velocity"], np.nan)}
    track = track_of(replace(run, values=values, valid=run.valid | {"velocity": gone}), PLAIN)
    assert track is not None
    for one in stretches([track], NEUTRAL, mount_of(PLAIN)):
        assert not ((one.middle_s > 19.0) & (one.middle_s < 26.0)).any()
        assert np.abs(one.lacks).max() < 1e-3


def test_a_late_velocity_is_missing_before_it_was_read() -> None:
    run = reckoned_run(lively(), delay_s=0.5)
    known = run.valid["velocity"] & ~((run.time_s > 20.0) & (run.time_s < 20.3))
    values = run.values | {"velocity": np.where(known[:, None], run.values["velocity"], np.nan)}
    track = track_of(replace(run, values=values, valid=run.valid | {"velocity": known}), PLAIN)
    assert track is not None
    late = NEUTRAL + np.array([0.5, 0, 0, 0, 0, 0, 0, 0])
    found = stretches([track], late, mount_of(PLAIN))
    assert max(np.abs(one.lacks).max() for one in found) < 1e-3


def test_too_few_stretches_say_nothing() -> None:
    track = track_of(reckoned_run(lively(), seconds=10.0), PLAIN)
    assert track is not None
    assert reckoning([track], mount_of(PLAIN), UNIT, 1e-3) is None


def test_what_a_block_lacks_to_the_fit_without_it_is_that_of_a_fit_without_it() -> None:
    draw = np.random.default_rng(7)
    columns, values = draw.standard_normal((30, 4)), draw.standard_normal(30)
    prior = np.diag([1.0, 2.0, 0.5, 3.0])
    covariance = np.linalg.inv(columns.T @ columns + prior)
    left = values - columns @ covariance @ columns.T @ values
    own = np.arange(30) < 6
    others = columns[~own]
    without = np.linalg.solve(others.T @ others + prior, others.T @ values[~own])
    np.testing.assert_allclose(
        left_without(columns[own], left[own], covariance),
        values[own] - columns[own] @ without,
        rtol=1e-9,
    )
