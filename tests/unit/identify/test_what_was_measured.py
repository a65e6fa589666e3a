"""A quantity was measured where a reading has all of its components."""

import numpy as np
import pytest

from pipeline.identify.channel_noise import channel_noise, was_measured
from pipeline.records.run_table import RunTable
from pipeline.vehicle.sensor_schema import Sensors


def table(quantity: str, values: np.ndarray) -> RunTable:
    rows = len(values)
    return RunTable(
        "run", 0.02 * np.arange(rows), {quantity: values}, {quantity: np.ones(rows, bool)}
    )


@pytest.mark.parametrize(
    ("quantity", "missing", "measured"),
    [
        ("velocity", [1, 2], False),
        ("velocity", [], True),
        ("shaft_speed", [1, 2], True),
        ("shaft_speed", [0, 1, 2], False),
    ],
)
def test_a_velocity_of_one_component_is_none(
    quantity: str, missing: list[int], measured: bool
) -> None:
    values = np.ones((50, 3))
    values[:, missing] = np.nan
    run = table(quantity, values)
    assert was_measured(run, quantity) == measured
    if quantity == "velocity":
        assert bool(channel_noise(Sensors(), [run])) == measured
