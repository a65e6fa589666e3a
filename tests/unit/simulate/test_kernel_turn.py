"""Turns from one attitude to another, against a rotation library."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from pipeline.simulate.kernel import STATE
from pipeline.simulate.kernel_alone import fill_turn
from pipeline.types import FloatArray


def quaternions(count: int, seed: int) -> FloatArray:
    found = np.random.default_rng(seed).standard_normal((count, 4))
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def rotation(quaternion: FloatArray) -> Rotation:
    return Rotation.from_quat(quaternion[[1, 2, 3, 0]])


def attitude(quaternion: FloatArray) -> FloatArray:
    state = np.zeros(STATE)
    state[3:7] = quaternion
    return state


def test_turns_are_those_of_a_rotation_library() -> None:
    out = np.empty(3)
    for first, second in zip(quaternions(40, 1), quaternions(40, 2), strict=True):
        fill_turn(attitude(first), second, out)
        assert_allclose(out, (rotation(first).inv() * rotation(second)).as_rotvec(), atol=1e-13)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_turn_is_zero_and_a_quaternion_and_its_negative_are_one_attitude(sign: float) -> None:
    one, out = quaternions(1, 4)[0], np.empty(3)
    fill_turn(attitude(one), sign * one, out)
    assert_allclose(out, 0.0, atol=1e-15)
