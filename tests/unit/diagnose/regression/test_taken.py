"""A change that is not in proportion to its size is taken at the one with which runs are likely."""

from dataclasses import replace

import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.regression.grid import all_at, on_grids
from pipeline.diagnose.regression.held_out import FileModel
from pipeline.diagnose.regression.known import learned
from pipeline.diagnose.regression.taken import with_sizes

LAG_S = 0.9
EFFECTS = ("thruster_lag", "thruster_degraded", "quadratic_damping")


def test_a_long_lag_is_taken_as_one_though_a_short_one_finds_itself() -> None:
    sound = small_case(manoeuvres=("prbs", "surge_steps", "zig_zag"), seconds=24.0, effects=EFFECTS)
    asked = small_case((f"thruster_lag:lag_s={LAG_S}",), seconds=24.0, effects=EFFECTS)
    case = replace(asked, healthy=sound.runs)
    known = learned(case, {"vehicle file": FileModel(case.packed)})
    periods = [one.response.period_s for one in known.grids]
    grids = [
        on_grids(case.packed, run, case.vehicle.sensors, known.directions, periods)
        for run in case.runs
    ]
    more, added = with_sizes(known, grids, ())
    at = {one.direction.name: one.direction.unit_size * one.size for one in added}
    assert at["thruster_lag:lag_s"] == pytest.approx(LAG_S, rel=0.35)
    runs = all_at(grids[0], added)
    assert runs[0].more.shape[1] == len(more.directions) == len(known.directions) + len(added)
    told = more.best.told(runs[:1])[0]
    assert told.information.shape == 2 * (len(more.directions),)
    assert more.best.ordinary.width[-1] < 0.01
