"""The model follows the measured motion: alike from wherever it begins, and side by side."""

from itertools import pairwise

import numpy as np
import pytest
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case, channels_of, windows_of
from pipeline.diagnose.linear.follow import follow
from pipeline.diagnose.linear.workers import Workers
from pipeline.types import FloatArray


@pytest.fixture(scope="module")
def case() -> Case:
    return small_case(
        ("quadratic_damping:surge=2.0",), manoeuvres=("prbs", "zig_zag"), seconds=25.0
    )


def _followed(
    case: Case, nearby: list[FloatArray] | None = None, threads: int = 1
) -> tuple[FloatArray, list[FloatArray]]:
    channels = channels_of(case.vehicle, case.runs)
    windows = windows_of(case.packed, case.runs, channels)
    started, pulls = follow(
        case.packed, case.runs, windows, channels, nearby=nearby, workers=Workers(threads)
    )
    return np.array([one.start for one in started]), pulls


def test_the_pull_is_the_drag_that_the_model_lacks(case: Case) -> None:
    # twice the drag, and no other fault: it is missed against the motion
    windows = windows_of(case.packed, case.runs, channels_of(case.vehicle, case.runs))
    _, pulls = _followed(case)
    surge = np.concatenate([one.start[7:8] for one in windows])
    mean = np.array([one[:, 0].mean() for one in pulls])
    fast = np.abs(surge) > 0.5 * np.abs(surge).max()
    assert fast.sum() >= 2
    assert (mean[fast] * surge[fast] < 0.0).all()


def test_runs_side_by_side_are_followed_as_one_by_one(case: Case) -> None:
    (starts, pulls), (others, more) = _followed(case), _followed(case, threads=2)
    np.testing.assert_array_equal(starts, others)
    for one, other in zip(pulls, more, strict=True):
        np.testing.assert_array_equal(one, other)


def test_passes_from_known_pulls_settle(case: Case) -> None:
    pulls = [_followed(case)[1]]
    for _ in range(3):
        pulls.append(_followed(case, nearby=pulls[-1])[1])
    ways = [np.concatenate(after) - np.concatenate(before) for before, after in pairwise(pulls)]
    first, second, third = (np.sqrt(np.mean(way**2, axis=0)) for way in ways)
    assert (second < first).all()
    assert (third < second).all()
    assert (first < 0.6 * np.sqrt(np.mean(np.concatenate(pulls[0]) ** 2, axis=0))).all()


def test_passes_over_the_same_runs_do_not_pile_up_the_noise(case: Case) -> None:
    _, pulls = _followed(case)
    first = np.sqrt(np.mean(np.concatenate(pulls) ** 2, axis=0))
    for _ in range(6):
        _, pulls = _followed(case, nearby=pulls)
    last = np.sqrt(np.mean(np.concatenate(pulls) ** 2, axis=0))
    assert (last < 1.1 * first).all()
