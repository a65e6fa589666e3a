"""Windows of runs under their own conditions: the bench simulates each as it was."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.diagnose.case import Case, channels_of, setting_of
from pipeline.diagnose.linear.predictions import simulate_cut, simulate_windows
from pipeline.identify.window_outputs import simulate_windows as one_by_one
from pipeline.records.run_table import AS_STATED, Conditions, KnownBody, KnownOfRun, RunTable
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure

HEAVY = Conditions((KnownBody("lead", 6.0, 0.0, (0.4, 0.0, 0.1)),))


def test_each_window_has_the_conditions_and_the_force_of_its_run(repository: Path) -> None:
    vehicle = bundled(repository, "rov8")
    assert vehicle.sensors is not None
    packed = pack_vehicle(vehicle)
    flown = fly(packed, MANOEUVRES["circle"].plan(packed, 1.0, 30.0))
    log = measure(flown, packed, vehicle.sensors, vector=packed.vector, seed=1)
    plain = table_of_log(log, vehicle.sensors)
    push = np.zeros((plain.time_s.size, 6))
    push[:, 2] = np.linspace(0.0, 8.0, len(push))
    changed: RunTable = replace(plain, known=KnownOfRun((0.0, 14.0), (AS_STATED, HEAVY), push))
    runs = (plain, changed)
    case = Case(vehicle.name, vehicle, packed, runs)
    setting = setting_of(case, runs, channels_of(vehicle, runs), threads=1)
    bench, stack = setting.bench, setting.bench.stack
    own = [w for w in stack.windows if w.run == 1]
    # the window that would have held the change ends there, and the next begins
    assert 14.0 in [pytest.approx(w.begin_s) for w in own]
    assert all(w.conditions == (HEAVY if w.begin_s >= 13.99 else AS_STATED) for w in own)
    starts = stack.starts
    still = np.zeros((len(bench.whole.commands), 6))
    states = simulate_windows(bench, packed.vector, starts, still).state
    expected, _ = one_by_one(stack, packed.vector, starts)
    np.testing.assert_allclose(
        states[:, :13], expected[:, :13], atol=0.03
    )  # two slopes a step, and four
    # and not alike: the same window of the plain run goes another way
    last = {w.run: k for k, w in enumerate(stack.windows)}
    ends = states[bench.whole.last_row, 2]
    assert abs(ends[last[0]] - ends[last[1]]) > 0.1
    pieces, _ = simulate_cut(bench, packed.vector, states[bench.start_of_piece], still)
    np.testing.assert_allclose(pieces[bench.cut.last_row][-1], states[-1], atol=1e-9)
