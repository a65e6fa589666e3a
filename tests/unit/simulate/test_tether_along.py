"""The force of a cable along a measured motion, against that of the flight that was measured."""

from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled

from pipeline.errors import CannotComputeError
from pipeline.records.pool_run import RunNotes, TetherNotes
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.run_conditions import run_setup
from pipeline.simulate.sensors import measure
from pipeline.simulate.tether_along import tether_force
from pipeline.simulate.tethered_mover import nominal_mover
from pipeline.vehicle.schema import Vehicle


@pytest.fixture(scope="module")
def carrier(repository: Path) -> Vehicle:
    return bundled(repository, "cargo_carrier")


def test_the_force_is_that_of_the_flight(carrier: Vehicle) -> None:
    """From what the sensors saw; the vehicle of the file has three quarters of the true drag."""
    model, sensors = carrier.model, carrier.sensors
    assert model is not None
    assert sensors is not None
    packed = pack_vehicle(carrier)
    mover = nominal_mover(model)
    assert mover is not None
    flown = fly(packed, MANOEUVRES["zig_zag"].plan(packed, 1.0, 8.0), mover=mover)
    table = table_of_log(measure(flown, packed, sensors, vector=packed.vector, seed=3), sensors)
    less = model.damping.model_copy(
        update={"quadratic": tuple(0.75 * one for one in model.damping.quadratic)}
    )
    believed = carrier.model_copy(update={"model": model.model_copy(update={"damping": less})})
    setup = run_setup(carrier, model, None)
    force = tether_force(pack_vehicle(believed), sensors, table, setup)
    assert force is not None
    true = mover.log().wrench_on_vehicle[: len(force)]
    size = np.sqrt(np.mean(true**2, axis=0))
    off = np.sqrt(np.mean((force[: len(true)] - true) ** 2, axis=0))
    assert size[0] > 5.0
    assert off[:3].max() < 0.8
    assert off[3:].max() < 0.3


def test_no_tether_no_force_and_one_too_short_is_refused(carrier: Vehicle) -> None:
    model, sensors = carrier.model, carrier.sensors
    assert model is not None
    assert sensors is not None
    packed = pack_vehicle(carrier)
    flown = fly(packed, MANOEUVRES["hover"].plan(packed, 1.0, 2.0))
    table = table_of_log(measure(flown, packed, sensors, vector=packed.vector, seed=1), sensors)
    off = run_setup(carrier, model, RunNotes(tether=TetherNotes(attached=False)))
    assert tether_force(packed, sensors, table, off) is None
    short = run_setup(carrier, model, RunNotes(tether=TetherNotes(attached=True, paid_out_m=3.0)))
    with pytest.raises(CannotComputeError, match="does not reach"):
        tether_force(packed, sensors, table, short)
