"""The vehicle of the file flies what was asked."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.regression import flights
from pipeline.diagnose.regression.directions import directions_of
from pipeline.diagnose.regression.flights import flown, usual_force
from pipeline.records.run_table import RunTable
from pipeline.vehicle.sensor_schema import Sensors


@pytest.fixture(scope="module")
def case() -> Case:
    return small_case(seconds=20.0)


def without(run: RunTable, *quantities: str) -> RunTable:
    values = {name: one for name, one in run.values.items() if name not in quantities}
    return replace(run, values=values)


def test_flights_are_measured_as_the_runs_were(case: Case) -> None:
    runs = tuple(without(run, "velocity", "position") for run in case.runs)
    found = flown(case.packed, case.vehicle.sensors or Sensors(), runs)
    assert {frozenset(one.values) for one in found} == {frozenset(runs[0].values)}
    for k, one in enumerate(found):
        asked = runs[k % len(runs)].values["command"]
        rows = min(len(asked), len(one.values["command"]))
        assert one.values["command"][:rows] == pytest.approx(asked[:rows])


def test_the_same_runs_are_flown_alike_and_other_vehicles_otherwise(case: Case) -> None:
    sensors = case.vehicle.sensors or Sensors()
    first, again = (flown(case.packed, sensors, case.runs) for _ in range(2))
    assert np.array_equal(first[0].values["velocity"], again[0].values["velocity"])
    directions = directions_of(case.vehicle, case.packed, case.candidates)
    heavy = np.where([one.name == "residual_buoyancy:force_n" for one in directions], 1.0, 0.0)
    drawn = flown(case.packed, sensors, case.runs, [(directions, heavy)] * flights.FLIGHTS)
    depth = [np.mean([one.values["depth"][-1, 0] for one in every]) for every in (first, drawn)]
    assert depth[1] < depth[0] - 0.1


def test_a_sensor_that_is_not_stated_reads_as_the_runs_do(case: Case) -> None:
    found = flown(case.packed, Sensors(), case.runs)
    assert {"velocity", "attitude", "angular_velocity"} <= set(found[0].values)
    noise = np.diff(found[0].values["angular_velocity"], axis=0).std()
    assert noise > 0.0


def test_the_usual_force_is_a_share_of_the_largest_thrust(case: Case) -> None:
    force = usual_force(case.packed)
    largest = float(case.packed.thrust_tables[:, :, 0].max())
    assert force[:3] == pytest.approx(0.005 * largest * np.ones(3))
    assert (force[3:] > 0.0).all()


def test_the_outside_force_has_unit_variance_and_forgets() -> None:
    found = flights._outside(200_000, 0.1, np.random.default_rng(1))[:, 0]
    assert found.var() == pytest.approx(1.0, rel=0.1)
    later = np.mean(found[:-20] * found[20:])  # 2 s on
    assert later == pytest.approx(0.5 * np.exp(-2.0 / 0.8) + 0.5 * np.exp(-2.0 / 10.0), abs=0.08)


@pytest.mark.slow
def test_one_sound_run_that_shows_it_too_makes_it_no_change() -> None:
    """What the vehicle does when it is well the file is off by."""
    faults = ("quadratic_damping:surge=2.0",)
    asked, sound = (small_case(faults, seed=seed, seconds=30.0) for seed in (1, 1))
    alone = diagnose(asked)
    beside = diagnose(replace(asked, healthy=sound.runs[:1]))
    assert alone.verdict.effects == ("quadratic_damping",)
    none = {row.effect: row.probability for row in beside.ranking}["none"]
    assert none > 0.5


@pytest.mark.slow
def test_a_sound_run_with_other_channels_takes_nothing_from_the_answer() -> None:
    asked = small_case(("thruster_degraded:thrust_fraction=0.6@front_left",))
    other = without(asked.runs[0], "velocity", "position")
    blind = without(asked.runs[1], "attitude", "specific_force")
    for healthy in ((other,), (blind,)):
        found = diagnose(replace(asked, healthy=healthy))
        assert found.verdict.effects == ("thruster_degraded",)
