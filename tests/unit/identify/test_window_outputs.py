"""Attitude errors against a rotation library."""

import numpy as np
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from pipeline.identify.window_outputs import turn_between


def test_turns_are_those_of_a_rotation_library() -> None:
    generator = np.random.default_rng(0)
    first = generator.standard_normal((300, 4))
    second = np.concatenate(
        [generator.standard_normal((100, 4)), -2.0 * first[100:200], first[200:] + 1e-9]
    )
    expected = (
        Rotation.from_quat(first[:, [1, 2, 3, 0]]).inv()
        * Rotation.from_quat(second[:, [1, 2, 3, 0]])
    ).as_rotvec()
    assert_allclose(turn_between(first, second), expected, atol=1e-14)


def test_only_what_is_not_finite_stays_so() -> None:
    first = np.array([[1.0, 0.0, 0.0, 0.0], [np.nan, 0.0, 0.0, 0.0]])
    found = turn_between(first, np.tile([1.0, 0.0, 0.0, 0.0], (2, 1)))
    assert_allclose(found[0], 0.0)
    assert np.isnan(found[1]).all()
