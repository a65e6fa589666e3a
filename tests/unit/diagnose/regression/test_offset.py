"""What sound runs are off by alike is taken off, and nothing else."""

import numpy as np
import pytest

from pipeline.diagnose.regression.offset import offset_of, without_offset
from pipeline.diagnose.regression.told import Told

INFORMATION = np.array([[400.0, 60.0, 0.0], [60.0, 100.0, 20.0], [0.0, 20.0, 50.0]])
BIAS, TRUSTED = np.array([0.0, 1.5, 0.0]), np.ones(1)


def says(change: np.ndarray, seed: int) -> Told:
    """A run of one channel that has a change, with the noise that its information claims."""
    noise = np.random.default_rng(seed).multivariate_normal(np.zeros(3), INFORMATION)
    score = INFORMATION @ change + noise
    return Told(INFORMATION[None], score[None], np.zeros(3))


def test_what_sound_runs_share_is_no_change() -> None:
    sound = [says(BIAS, seed) for seed in range(4)]
    offset = offset_of(sound, TRUSTED)
    assert (offset.variance[0] > 0.0).tolist() == [False, True, False]
    assert offset.mean[0, 1] == pytest.approx(1.5, abs=0.2)
    changed = offset.removed(says(BIAS + np.array([0.8, 0.0, 0.0]), 9), 1)
    found = np.linalg.solve(changed.information, changed.score)
    assert found[0] == pytest.approx(0.8, abs=0.25)
    assert found[1] == pytest.approx(0.0, abs=0.4)
    for one in without_offset(sound, TRUSTED):
        assert abs(one.score[1] / one.information[1, 1]) < 0.5


def test_of_runs_that_share_nothing_nothing_is_taken_off() -> None:
    sound = [says(np.zeros(3), seed) for seed in range(4)]
    offset = offset_of(sound, TRUSTED)
    assert not offset.variance.any()
    run = says(np.array([0.3, 0.0, 0.0]), 9)
    assert np.array_equal(offset.removed(run, 2).by_channel, run.by_channel)
    assert np.array_equal(offset.removed(run, 2).score, run.score)


def test_many_runs_are_told_no_better_than_the_offset_is_known() -> None:
    offset = offset_of([says(BIAS, seed) for seed in range(4)], TRUSTED)
    together = sum(offset.removed(says(BIAS, seed), 50).information for seed in range(50))
    assert 1.0 / np.linalg.inv(together)[1, 1] < 1.01 / offset.covariance[0, 1, 1]


def test_an_offset_beyond_what_was_tried_first_is_taken_off_as_a_whole() -> None:
    # a direction that hardly tells anything may stand for an error of another form
    far, vague = np.array([0.0, 60.0, 0.0]), 1e-3 * INFORMATION
    generator = np.random.default_rng(2)
    sound = [
        Told(
            vague[None],
            (vague @ far + generator.multivariate_normal(np.zeros(3), vague))[None],
            np.zeros(3),
        )
        for _ in range(4)
    ]
    offset = offset_of(sound, TRUSTED)
    assert offset.mean[0, 1] == pytest.approx(60.0, abs=3.0 / (4.0 * vague[1, 1]) ** 0.5)
    # of flights of the file such an error is none of the direction: it would grow with the motion
    allowed = offset_of(sound, TRUSTED, np.full(3, 0.3))
    assert np.abs(allowed.mean).max() < 3.0
    assert allowed.variance.max() <= 0.3**2
