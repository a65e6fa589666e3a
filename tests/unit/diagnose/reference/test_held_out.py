"""What is left out in turn."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from pipeline.diagnose.reference.held_out import MOST_PARTS, parts_of


def windows(runs: int) -> Any:  # noqa: ANN401 - stand-ins for windows
    """Four windows of 6 s in each run."""
    return [SimpleNamespace(run=run, begin_s=6.0 * k) for run in range(runs) for k in range(4)]


def test_each_of_three_runs_is_left_out_once() -> None:
    parts = parts_of(windows(3), [24.0] * 3)
    assert [part.runs for part in parts] == [(1, 2), (0, 2), (0, 1)]
    assert (np.sum([part.left_out for part in parts], axis=0) == 1).all()


def test_of_two_runs_each_half_is_left_out_once() -> None:
    parts = parts_of(windows(2), [24.0, 24.0])
    assert [part.halves for part in parts] == [True, True]
    assert parts[0].left_out.tolist() == [False, False, True, True] * 2
    assert (parts[0].left_out != parts[1].left_out).all()


def test_many_runs_are_left_out_several_at_a_time() -> None:
    parts = parts_of(windows(20), [24.0] * 20)
    assert len(parts) == MOST_PARTS
    for part in parts:
        out = {k // 4 for k in np.flatnonzero(part.left_out)}
        assert out == set(range(20)) - set(part.runs)
