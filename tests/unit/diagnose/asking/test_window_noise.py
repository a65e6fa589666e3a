"""Readings of a window in which they contradict each other count for less, and only there."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pipeline.diagnose.asking.window_noise import widened_by_window
from pipeline.diagnose.linear.linear_model import LinearModel
from pipeline.types import FloatArray

WINDOWS, EACH = 3, 60


@dataclass(frozen=True)
class Setting:
    """As far as weights go: one channel of one column."""

    row_scale: FloatArray
    bench: Any = field(
        default_factory=lambda: SimpleNamespace(
            window_count=WINDOWS,
            stack=SimpleNamespace(
                rows=[SimpleNamespace(channel=SimpleNamespace(quantity="depth"))],
                owner=np.zeros(WINDOWS * EACH, int),
            ),
        )
    )
    shared: Any = field(
        default_factory=lambda: SimpleNamespace(window=np.repeat(np.arange(WINDOWS), EACH))
    )


@dataclass(frozen=True)
class Model:
    """One column of everything."""

    setting: Setting
    local: FloatArray
    shared: FloatArray
    extra: FloatArray
    departures: FloatArray
    rest: FloatArray
    readings: FloatArray
    residual: FloatArray


@pytest.fixture
def model() -> LinearModel:
    rows = WINDOWS * EACH
    one = np.ones((rows, 1))
    found = Model(Setting(np.ones(rows)), one, one, one, one, one, np.ones(rows), np.zeros(rows))
    return cast("LinearModel", found)


def weights(model: LinearModel, residual: FloatArray, factor: float = 1.0) -> FloatArray:
    found = widened_by_window(model, residual, {"depth": factor})
    np.testing.assert_array_equal(found.readings, found.setting.row_scale)
    return np.asarray(found.setting.row_scale.reshape(WINDOWS, EACH))


def test_white_readings_keep_their_weight(model: LinearModel) -> None:
    residual = np.random.default_rng(2).standard_normal(WINDOWS * EACH).clip(-3.0, 3.0)
    np.testing.assert_array_equal(weights(model, residual), 1.0)


def test_a_window_that_contradicts_itself_has_its_own_noise(model: LinearModel) -> None:
    residual = np.random.default_rng(2).standard_normal(WINDOWS * EACH).clip(-3.0, 3.0)
    residual[EACH : 2 * EACH] *= 20.0
    found = weights(model, residual)
    assert found[1].max() == pytest.approx(1.0 / 20.0, rel=0.3)
    np.testing.assert_array_equal(found[[0, 2]], 1.0)


def test_an_outlier_counts_for_less_by_itself(model: LinearModel) -> None:
    residual = np.zeros(WINDOWS * EACH)
    residual[0] = 8.0
    found = weights(model, residual)
    assert found[0, 0] < 1.0
    np.testing.assert_array_equal(found.ravel()[1:], 1.0)


def test_noise_of_the_channel_is_taken_off_first(model: LinearModel) -> None:
    residual = 2.0 * np.random.default_rng(2).standard_normal(WINDOWS * EACH).clip(-3.0, 3.0)
    np.testing.assert_allclose(weights(model, residual, factor=2.0), 0.5)
