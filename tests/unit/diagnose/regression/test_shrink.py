"""How far the error shrinks, with its interval."""

import numpy as np
import pytest

from pipeline.diagnose.regression.shrink import _closed, _intervals

PERIOD_S = 0.5


def errors(size: float, rows: int = 240) -> np.ndarray:
    return size * np.random.default_rng(3).standard_normal((rows, 2))


def test_half_of_what_is_beyond_a_healthy_run_is_gone() -> None:
    assert _closed(3.0, 2.0) == pytest.approx(0.5)
    assert _closed(1.05, 1.0) is None
    whole, each = _intervals([errors(3.0)], [errors(2.0)], np.ones(2), PERIOD_S)
    assert whole is not None
    assert whole[0] < 0.5 < whole[1] + 0.05
    assert len(each) == 2


def test_halves_too_short_for_blocks_have_no_interval() -> None:
    short = errors(3.0, rows=7)
    assert _intervals([short], [short], np.ones(2), PERIOD_S) == (None, [None, None])
