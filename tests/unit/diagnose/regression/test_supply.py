"""What a logged voltage says of the supply."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.regression.directions import directions_of
from pipeline.diagnose.regression.supply import supply_told
from pipeline.effects.library import candidates
from pipeline.records.run_table import RunTable
from pipeline.types import FloatArray

CASE = small_case(("voltage_sag:drop=0.1",), manoeuvres=("prbs",), seconds=20.0)
EVERY = directions_of(CASE.vehicle, CASE.packed, candidates(CASE.packed.context))
DROP = [one.name for one in EVERY].index("voltage_sag:drop")


def told(run: RunTable) -> tuple[FloatArray, FloatArray]:
    return supply_told(CASE.packed, run, CASE.vehicle.sensors, EVERY)


def test_a_drop_is_read_off_the_voltage_and_nothing_else_is() -> None:
    information, score = told(CASE.runs[0])
    drop = score[DROP] / information[DROP, DROP] * EVERY[DROP].unit_size
    assert drop == pytest.approx(0.1, abs=0.01)
    assert information[DROP, DROP] ** -0.5 * EVERY[DROP].unit_size < 0.006
    assert np.count_nonzero(np.diag(information)) == 2


def test_readings_that_are_not_trusted_count_for_nothing() -> None:
    run = CASE.runs[0]
    voltage = run.values["voltage"].copy()
    voltage[::3] = np.nan
    information, score = told(replace(run, values=run.values | {"voltage": voltage}))
    drop = score[DROP] / information[DROP, DROP] * EVERY[DROP].unit_size
    assert drop == pytest.approx(0.1, abs=0.01)
    nothing = replace(run, values=run.values | {"voltage": np.full_like(voltage, np.nan)})
    assert not told(nothing)[0].any()


def test_without_a_voltage_nothing_is_said() -> None:
    run = CASE.runs[0]
    values = {name: own for name, own in run.values.items() if name != "voltage"}
    information, score = told(replace(run, values=values))
    assert not information.any()
    assert not score.any()
