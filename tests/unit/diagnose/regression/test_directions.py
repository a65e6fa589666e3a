"""What a change of the vehicle, or of its instruments, adds to the wrench of a run."""

from dataclasses import replace

import numpy as np
from diagnosis_cases import small_case

from pipeline.diagnose.regression.directions import directions_of
from pipeline.diagnose.regression.file_step import file_step
from pipeline.diagnose.regression.grid import on_grids

SCALE = 1.2


def test_a_dvl_that_reads_too_fast_seems_to_be_pushed() -> None:
    """Pushed so, the file's vehicle moves as it is read to; its turning is as before."""
    case = small_case(seconds=12.0, effects=("dvl_scale",))
    directions = directions_of(case.vehicle, case.packed, case.candidates)
    k = next(k for k, one in enumerate(directions) if one.effect.id == "dvl_scale")
    step = file_step(case.packed)
    left = np.zeros((2, 6))
    for run in case.runs:
        fast = replace(run, values={**run.values, "velocity": SCALE * run.values["velocity"]})
        grid = on_grids(case.packed, fast, case.vehicle.sensors, directions, (0.2,))[0]
        more = (SCALE - 1.0) / directions[k].unit_size * grid.more[:, k]
        rows = np.arange(2, len(grid.velocity))
        now, before = grid.velocity[rows - 1], grid.velocity[rows - 2]
        for way, one in enumerate((grid, replace(grid, wrench=grid.wrench + more))):
            off = step(now, before, one, rows) - grid.velocity[rows]
            left[way] += np.mean(off, axis=0) ** 2
    assert left[1, 0] < 0.3 * left[0, 0]
    assert not directions[k].effect.unstated
