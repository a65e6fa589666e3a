"""Sums over windows of rows."""

import numpy as np
import pytest

from pipeline.physics.window_sums import means_over, sums_over


def test_windows_have_the_sums_and_means_of_their_rows() -> None:
    values = np.random.default_rng(1).standard_normal((20, 3, 2))
    first, end = np.array([0, 4, 19]), np.array([20, 5, 20])
    expected = [values[a:b].sum(axis=0) for a, b in zip(first, end, strict=True)]
    assert sums_over(values, first, end) == pytest.approx(np.array(expected))
    means = [values[a:b].mean(axis=0) for a, b in zip(first, end, strict=True)]
    assert means_over(values, first, end) == pytest.approx(np.array(means))
