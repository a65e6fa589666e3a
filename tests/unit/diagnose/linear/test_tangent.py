"""Derivatives chained through pieces against plain differences of whole windows."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import channels_of, setting_of
from pipeline.diagnose.linear.linear_model import (
    LinearModel,
    Point,
    Setting,
    motion_at,
    residual_of,
    vector_of,
)
from pipeline.diagnose.linear.tangent import linear_model
from pipeline.simulate.pack import mass_of
from pipeline.types import FloatArray

Model = tuple[LinearModel, FloatArray]
Change = Callable[[float], Point]


def residual_at(setting: Setting, point: Point) -> FloatArray:
    """Weighted whitened residual at a point, simulated anew."""
    vector = vector_of(setting, point.departures)
    return residual_of(setting, point, vector, motion_at(setting, point, vector))


@pytest.fixture(scope="module")
def model() -> Model:
    case = small_case(
        ("thruster_degraded:thrust_fraction=0.6@front_left",), manoeuvres=("prbs",), seconds=12.5
    )
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    point = setting.origin()
    return linear_model(setting, point), residual_at(setting, point)


def central(model: LinearModel, change: Change, by: float) -> FloatArray:
    """Difference of the predictions over both sides of the point."""
    setting = model.setting
    up, down = (residual_at(setting, change(s * by)) for s in (1.0, -1.0))
    return np.asarray((down - up) / (2 * by))


def close(found: FloatArray, expected: FloatArray) -> None:
    """Alike to half a per cent; a few rows may lie where a code crosses a corner of the table."""
    off = np.abs(found - expected) / np.abs(expected).max()
    assert off.max() < 3e-2
    assert np.quantile(off, 0.98) < 5e-3


@pytest.mark.parametrize("index", [0, 2, 3, 5, 6, 8, 11])
def test_by_the_start(model: Model, index: int) -> None:
    linear, _ = model

    def change(by: float) -> Point:
        starts = linear.point.starts.copy()
        starts[:, index] += by
        return replace(linear.point, starts=starts)

    close(linear.local[:, index], central(linear, change, 1e-4))


@pytest.mark.parametrize("piece_axis", [0, 5 * 6 + 2, 11 * 6 + 5])
def test_by_an_outside_force_of_half_a_second(model: Model, piece_axis: int) -> None:
    linear, _ = model

    def change(by: float) -> Point:
        forces = linear.point.forces.copy()
        forces[:, piece_axis] += by
        return replace(linear.point, forces=forces)

    close(linear.local[:, 12 + piece_axis], central(linear, change, 0.1))


def test_by_every_departure_and_the_characteristic(model: Model) -> None:
    linear, _ = model
    for index in range(len(linear.setting.coordinates)):

        def change(by: float, index: int = index) -> Point:
            departures = linear.point.departures.copy()
            departures[index] += by
            return replace(linear.point, departures=departures)

        close(linear.departures[:, index], central(linear, change, 1e-3))
    first = linear.setting.shared.size + linear.setting.extra.shape[1]

    def shared(by: float) -> Point:
        values = linear.point.shared.copy()
        values[first] += by
        return replace(linear.point, shared=values)

    close(linear.extra[:, linear.setting.extra.shape[1]], central(linear, shared, 0.01))


def test_by_added_mass_at_the_acceleration_that_the_pull_gives() -> None:
    """A heavier vehicle is pulled harder: only what its own forces do is less."""
    case = small_case(manoeuvres=("prbs",), seconds=12.5, effects=("added_mass",))
    setting = setting_of(case, case.runs, channels_of(case.vehicle, case.runs), threads=1)
    linear = linear_model(setting, setting.origin())
    index = next(k for k, one in enumerate(setting.coordinates) if one.parameter.name == "heave")

    def mass(departures: FloatArray) -> FloatArray:
        return mass_of(vector_of(setting, departures))

    def seen(by: float) -> FloatArray:
        departures = linear.point.departures.copy()
        departures[index] += by
        ratio = np.linalg.solve(mass(linear.point.departures), mass(departures))
        pulls = [pull @ ratio for pull in setting.bench.pulls]
        at = replace(setting, bench=replace(setting.bench, pulls=pulls))
        return residual_at(at, replace(linear.point, departures=departures))

    close(linear.departures[:, index], np.asarray((seen(-1e-3) - seen(1e-3)) / 2e-3))


def test_the_pull_leads_the_nominal_model_along_the_measured_motion(model: Model) -> None:
    linear, residual = model
    alone = residual_at(linear.setting, replace(linear.point, pull=0.0))
    # the fault turns the free model away by hundreds of standard deviations
    assert np.sqrt(np.mean(residual**2)) < 0.05 * np.sqrt(np.mean(alone**2))


def test_at_its_own_point_a_model_sees_its_own_readings_the_voltage_among_them() -> None:
    case = small_case(
        ("voltage_sag:load_drop=0.1",), manoeuvres=("prbs",), seconds=12.5, effects=("voltage_sag",)
    )
    channels = channels_of(case.vehicle, case.runs)
    setting = setting_of(case, case.runs, channels, threads=1)
    linear = linear_model(setting, setting.origin())
    quantities = [rows.channel.quantity for rows in setting.bench.stack.rows]
    voltage = setting.bench.stack.owner == quantities.index("voltage")
    # no start and no force moves it, and yet it speaks
    assert not linear.local[voltage].any()
    assert linear.informative_rows.all()
    assert linear.lost == 0.0
    assert np.mean(linear.readings[voltage] ** 2) > 2.0
