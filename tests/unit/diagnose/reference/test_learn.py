"""What sound runs show of the vehicle and of each run, against the dense joint normal equations."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipeline.diagnose.linear.elimination import Marginal
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.diagnose.reference import learn
from pipeline.types import FloatArray

RUNS, SIZE = 3, 4


def setting() -> Setting:
    """No coordinates, so that no departure has bounds."""
    return cast("Setting", SimpleNamespace(coordinates=()))


def runs_of(seed: int) -> list[Marginal]:
    """Normal equations of three runs, each with 30 readings."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(RUNS):
        columns, readings = rng.standard_normal((30, SIZE)), rng.standard_normal(30)
        found.append(
            Marginal(columns.T @ columns, columns.T @ readings, float(readings @ readings), 0.0)
        )
    return found


def dense(stats: list[Marginal], vehicle: FloatArray, runs: FloatArray) -> FloatArray:
    """Covariance and mean of vehicle and runs together, the vehicle first."""
    size = SIZE * (RUNS + 1)
    matrix, right = np.zeros((size, size)), np.zeros(size)
    matrix[:SIZE, :SIZE] = np.diag(1.0 / vehicle)
    for number, one in enumerate(stats, 1):
        own = slice(SIZE * number, SIZE * (number + 1))
        matrix[own, own] += one.information
        right[own] = one.score
        # run = vehicle + what it differs by
        matrix[own, own] += np.diag(1.0 / runs)
        matrix[:SIZE, :SIZE] += np.diag(1.0 / runs)
        matrix[own, :SIZE] -= np.diag(1.0 / runs)
        matrix[:SIZE, own] -= np.diag(1.0 / runs)
    return np.asarray(np.linalg.solve(matrix, right).reshape(RUNS + 1, SIZE))


def test_vehicle_and_runs_are_those_of_the_joint_normal_equations() -> None:
    vehicle, runs = np.array([1.0, 0.5, 2.0, 0.1]), np.array([0.3, 0.2, 0.5, 0.05])
    stats = runs_of(5)
    mean, of_runs, squares = learn._expected(setting(), stats, learn._Widths(vehicle, runs))
    wanted = dense(stats, vehicle, runs)
    np.testing.assert_allclose(mean, wanted[0], atol=1e-10)
    np.testing.assert_allclose(of_runs, wanted[1:], atol=1e-10)
    assert (squares[1] > (of_runs - mean) ** 2).all()


def test_what_stays_the_same_is_the_vehicles() -> None:
    stats = runs_of(6)
    widths = learn._Widths(np.ones(SIZE), np.zeros(SIZE))
    mean, of_runs, _ = learn._expected(setting(), stats, widths)
    np.testing.assert_allclose(of_runs, np.tile(mean, (RUNS, 1)))


def test_a_width_grows_with_what_the_runs_show_and_a_few_say_little() -> None:
    before = np.array([1.0, 1.0])
    few, many = np.full((2, 2), 9.0), np.full((50, 2), 9.0)
    assert learn._ratio(few, before) == pytest.approx((1.0 + 36.0) / 5.0)
    assert learn._ratio(many, before) > learn._ratio(few, before)
    assert learn._ratio(many, before) < 9.0
