"""What a logged voltage says of the supply."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case
from pipeline.diagnose.coordinates import Coordinate
from pipeline.diagnose.regression.claimed import Claimed
from pipeline.diagnose.regression.directions import directions_of
from pipeline.diagnose.regression.supply import course_of_drop, supply_told
from pipeline.effects.library import candidates
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray


@dataclass(frozen=True)
class Told:
    run: RunTable
    case: Case
    every: tuple[Coordinate, ...]
    supply: Callable[[RunTable], tuple[FloatArray, FloatArray]]

    def drop(self, run: RunTable) -> tuple[float, float]:
        """Return the drop that a run tells, and its information."""
        information, score = self.supply(run)
        at = [one.name for one in self.every].index("voltage_sag:drop")
        unit = self.every[at].unit_size
        return score[at] / information[at, at] * unit, information[at, at] ** -0.5 * unit


@pytest.fixture(scope="module")
def told() -> Told:
    case = small_case(("voltage_sag:drop=0.1",), manoeuvres=("prbs",), seconds=20.0)
    every = directions_of(case.vehicle, case.packed, candidates(case.packed.context))
    sensors = case.vehicle.sensors
    return Told(
        case.runs[0], case, every, lambda run: supply_told(case.packed, run, sensors, every)
    )


def test_a_drop_is_read_off_the_voltage_and_nothing_else_is(told: Told) -> None:
    drop, std = told.drop(told.run)
    assert drop == pytest.approx(0.1, abs=0.01)
    assert std < 0.006
    assert np.count_nonzero(np.diag(told.supply(told.run)[0])) == 2


def test_readings_that_are_not_trusted_count_for_nothing(told: Told) -> None:
    run = told.run
    voltage = run.values["voltage"].copy()
    voltage[::3] = np.nan
    drop, _ = told.drop(replace(run, values=run.values | {"voltage": voltage}))
    assert drop == pytest.approx(0.1, abs=0.01)
    nothing = replace(run, values=run.values | {"voltage": np.full_like(voltage, np.nan)})
    assert not told.supply(nothing)[0].any()


def test_without_a_voltage_nothing_is_said(told: Told) -> None:
    run = told.run
    values = {name: own for name, own in run.values.items() if name != "voltage"}
    information, score = told.supply(replace(run, values=values))
    assert not information.any()
    assert not score.any()


def test_the_thrust_that_a_battery_costs_grows_as_it_runs_down(told: Told) -> None:
    case, run = told.case, told.run
    assert case.vehicle.sensors is not None
    assert case.vehicle.sensors.voltage is not None
    nominal_v = case.vehicle.sensors.voltage.nominal_v
    share = (run.time_s - run.time_s[0]) / (run.time_s[-1] - run.time_s[0])

    def at(lacks: FloatArray) -> RunTable:
        return replace(run, values=run.values | {"voltage": nominal_v * (1.0 - lacks)[:, None]})

    falls, level = at(0.2 * share), at(np.full(share.size, 0.1))
    course = course_of_drop(falls, case.vehicle.sensors)
    assert course == pytest.approx(2.0 * share, abs=0.05)
    drop = next(one for one in told.every if one.name == "voltage_sag:drop")
    sags, constant = (
        Claimed(case.packed, one, case.vehicle.sensors).departure(drop, 0.1).wrench
        for one in (falls, level)
    )
    assert np.abs(constant).max() > 1.0
    assert sags == pytest.approx(constant * course[:, None], abs=0.01 * np.abs(constant).max())
    # a supply that is as it should be tells no course
    assert course_of_drop(at(0.001 * share), case.vehicle.sensors) == pytest.approx(1.0)
