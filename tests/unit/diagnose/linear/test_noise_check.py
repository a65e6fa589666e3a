"""A channel counts for less where its readings tell less than as many of the stated noise."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipeline.diagnose.linear.linear_model import LinearModel
from pipeline.diagnose.linear.noise_check import noise_found


def model_of(values: np.ndarray) -> LinearModel:
    """A stack of one channel over windows of 100 readings, each of one number."""
    window = np.arange(values.size) // 100
    rows = SimpleNamespace(
        channel=SimpleNamespace(quantity="depth"), measured=np.zeros((values.size, 1))
    )
    stack = SimpleNamespace(rows=(rows,), owner=np.zeros(values.size, int))
    setting = SimpleNamespace(
        bench=SimpleNamespace(stack=stack), shared=SimpleNamespace(window=window)
    )
    return cast("LinearModel", SimpleNamespace(setting=setting))


def noise(lag1: float, variance: float) -> np.ndarray:
    generator = np.random.default_rng(3)
    values = np.zeros(4000)
    for k in range(1, values.size):
        values[k] = lag1 * values[k - 1] + generator.normal(0.0, np.sqrt(1.0 - lag1**2))
    return np.asarray(values * np.sqrt(variance))


@pytest.mark.parametrize(
    ("lag1", "variance", "widen"),
    [
        (0.0, 1.0, 1.0),
        (0.0, 2.0, np.sqrt(2.0)),
        (0.5, 1.0, np.sqrt(3.0)),
        # far less than stated: that they go together takes nothing from it
        (0.5, 0.06, 1.0),
    ],
)
def test_a_channel_is_widened_by_what_its_readings_tell_less(
    lag1: float, variance: float, widen: float
) -> None:
    values = noise(lag1, variance)
    found = noise_found(model_of(values), values)["depth"]
    assert found.widen == pytest.approx(widen, rel=0.12)
