"""What a run becomes on an even grid."""

from dataclasses import replace

import numpy as np
from diagnosis_cases import small_case

from pipeline.diagnose.regression.grid import on_grids


def test_heave_by_the_depth_does_not_begin_before_the_vehicle_sinks() -> None:
    """A smoothed heave would foretell itself, and what the thrusters do would not be seen in it."""
    case = small_case(seconds=12.0)
    run = case.runs[0]
    begins_s, speed_mps = 6.0, 0.3
    time = run.time_s - run.time_s[0]
    level = np.zeros_like(run.values["attitude"])
    level[:, 0] = 1.0
    values = {
        name: one for name, one in run.values.items() if name in {"command", "angular_velocity"}
    } | {
        "depth": speed_mps * np.maximum(time - begins_s, 0.0)[:, None],
        "attitude": level,
    }
    kept = {name: one for name, one in run.valid.items() if name in values}
    sinking = replace(run, values=values, valid=kept)
    (grid,) = on_grids(case.packed, sinking, None, (), (0.5,))
    assert grid.channels[0] == "w"
    heave = grid.velocity[:, 0]
    half = 0.25 + run.period_s
    assert np.abs(heave[grid.time_s < begins_s - half]).max() < 1e-12
    after = heave[grid.time_s > begins_s + half][:-1]  # the depth ends with its last reading
    assert np.abs(after - speed_mps).max() < 1e-9
