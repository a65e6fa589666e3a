"""The file's motion over a period of the grid."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.regression.directions import directions_of
from pipeline.diagnose.regression.file_step import file_step
from pipeline.diagnose.regression.grid import GridRun, on_grids
from pipeline.simulate.pack import PackedVehicle

Flown = tuple[PackedVehicle, list[GridRun]]


@pytest.fixture(scope="module")
def flown() -> Flown:
    case = small_case(seconds=12.0, effects=("residual_buoyancy",))
    every = directions_of(case.vehicle, case.packed, case.candidates)
    return case.packed, [
        on_grids(case.packed, run, case.vehicle.sensors, every, (0.2,))[0] for run in case.runs
    ]


def test_it_follows_the_vehicle_of_the_file(flown: Flown) -> None:
    packed, grids = flown
    step = file_step(packed)
    for run in grids:
        rows = np.arange(2, len(run.velocity))
        now, before = run.velocity[rows - 1], run.velocity[rows - 2]
        off = step(now, before, run, rows) - run.velocity[rows]
        assert np.sqrt(np.mean(off**2)) < np.sqrt(np.mean((now - run.velocity[rows]) ** 2))


def test_runs_of_one_name_are_not_taken_for_each_other(flown: Flown) -> None:
    """What was not measured of a run is followed along that run."""
    packed, grids = flown
    own = [2, 3, 4, 5]
    first, second = (
        replace(run, name="straight", channels=("w", "p", "q", "r"), velocity=run.velocity[:, own])
        for run in grids
    )
    rows = np.arange(2, len(second.velocity))
    now, before = second.velocity[rows - 1], second.velocity[rows - 2]
    alone = file_step(packed)(now, before, second, rows)
    both = file_step(packed)
    both(first.velocity[1:2], first.velocity[:1], first, np.array([2]))
    assert both(now, before, second, rows) == pytest.approx(alone)
