"""The settled thrust over arrays is the kernel's, and the ranges follow from it."""

import numpy as np
import pytest
from flight_cases import Bench

from pipeline.physics.parameters import read, write
from pipeline.simulate.run import initial_state, run
from pipeline.validate.field import Field
from pipeline.validate.plan import axis_range
from pipeline.validate.steady_tables import (
    Grid,
    calm_vehicle,
    configuration,
    inflow_speed,
    settled_thrust,
    thrust_limits,
)


def test_settled_thrust_is_the_kernels_without_lag(mmt300: Bench) -> None:
    packed = calm_vehicle(mmt300.packed)
    vector = packed.vector.copy()
    write(vector, "lag", np.zeros_like(read(vector, "lag")))
    generator = np.random.default_rng(3)
    for _ in range(40):
        codes = generator.uniform(-127, 127, (1, 5))
        nu = generator.uniform([-1, -1, -1, -1, -1, -1], [2.6, 1, 1, 1, 1, 1])
        state = initial_state(position_ned_m=(0, 0, 10), nu=nu.tolist())
        kernel = run(packed, codes, dt_s=0.02, vector=vector, start=state).thrust_n[0]
        ours = settled_thrust(packed, codes, inflow_speed(packed, nu[None, :]))[0]
        assert ours == pytest.approx(kernel, abs=1e-9)


def test_a_grid_goes_on_along_its_last_slope_in_rows_only() -> None:
    grid = Grid(np.array([[0.0, 1.0], [2.0, 4.0]]), 0.5, 1.0)
    row, column = np.array([0.25, 1.0, 0.0, -1.0]), np.array([0.5, 1.0, 9.0, 1.0])
    assert grid.at(row, column) == pytest.approx([1.75, 7.0, 1.0, 1.0])


def test_limits_take_the_smaller_sign(mmt300: Bench) -> None:
    packed = calm_vehicle(mmt300.packed)
    rest, fast = thrust_limits(packed, 0.0), thrust_limits(packed, 2.0)
    largest = packed.thrust_tables[0, 0, 0, -1]
    assert rest == pytest.approx(np.full(5, largest))
    along = packed.thrust_tables[0, 0, :, -1]
    expected = np.interp(2.0 * 0.92388, 0.1 * np.arange(len(along)), along)
    assert fast == pytest.approx([*[expected] * 4, largest], abs=1e-4)


def test_shares_of_the_paper_give_each_axis_alone(field: Field) -> None:
    axes = (0, 2, 4, 5)
    wrench = configuration(field.packed) @ field.crew.thrust_of_wrench[:, axes]
    assert wrench[list(axes)] == pytest.approx(np.eye(4), abs=1e-5)


def test_range_is_that_of_the_tables(field: Field) -> None:
    limit = thrust_limits(field.packed, 1.0)[0]
    got = axis_range(field.packed, field.crew.thrust_of_wrench, 1.0)
    delta = np.radians(22.5)
    assert got[0] == pytest.approx(4 * limit * np.cos(delta))
    assert got[5] == pytest.approx(2 * limit * np.sin(delta) * 0.9)
    assert got[1] == got[3] == 0.0
