"""The model led along a motion: its turns against a rotation library, its pull against a push."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.physics.parameters import MOST_THRUSTERS
from pipeline.simulate.kernel import BODY, RK4, STATE
from pipeline.simulate.kernel_alone import fill_turn
from pipeline.simulate.kernel_follow import follow_window, turned_back
from pipeline.simulate.pack import mass_of, pack_vehicle
from pipeline.simulate.run import initial_state, run
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle


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
    vectors, out = np.random.default_rng(3).standard_normal((40, 3)), np.empty(3)
    for first, second, vector in zip(quaternions(40, 1), quaternions(40, 2), vectors, strict=True):
        turned_back.py_func(attitude(first), vector, out)
        assert_allclose(out, rotation(first).inv().apply(vector), atol=1e-14)
        fill_turn(attitude(first), second, out)
        assert_allclose(out, (rotation(first).inv() * rotation(second)).as_rotvec(), atol=1e-13)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_turn_is_zero_and_a_quaternion_and_its_negative_are_one_attitude(sign: float) -> None:
    one, out = quaternions(1, 4)[0], np.empty(3)
    fill_turn(attitude(one), sign * one, out)
    assert_allclose(out, 0.0, atol=1e-15)


@pytest.mark.parametrize("axis", range(6))
def test_pull_becomes_the_push_that_the_model_lacks(axis: int) -> None:
    packed = pack_vehicle(load_vehicle(bundled_vehicle("rov8")))
    push = np.zeros((1, 6))
    push[0, axis] = 5.0 if axis < 3 else 0.5
    steps, step_s = 500, 0.02
    commands = np.zeros((steps, len(packed.thruster_names)))
    seen = run(packed, commands, dt_s=step_s, external=push)
    known = np.ones(steps + 1, bool)
    mass, pull = mass_of(packed.vector), np.zeros((steps, 6))
    states = np.empty((steps + 1, STATE))
    sound = follow_window(
        packed.vector,
        initial_state(),
        np.zeros((steps, MOST_THRUSTERS)),
        step_s,
        4,
        RK4,
        mass,
        np.array([5.0, 2.5, 0.0, 0.5]),
        np.zeros(3),
        np.ascontiguousarray(seen.nu[:, 3:]),
        known,
        np.ascontiguousarray(seen.nu[:, :3]),
        known,
        np.ascontiguousarray(seen.quaternion),
        known,
        np.zeros((steps + 1, 3)),
        ~known,
        *packed.tables,
        states,
        pull,
    )
    assert sound
    # in roll and pitch weight and buoyancy turn the model back by part of what the pull leaves
    assert_allclose(pull[-50:, axis].mean(), push[0, axis], rtol=0.15 if axis in {3, 4} else 0.05)
    assert_allclose(states[-1, 7:BODY], seen.nu[-1], atol=0.02)


def test_motion_that_leaves_the_finite_numbers_is_told() -> None:
    packed = pack_vehicle(load_vehicle(bundled_vehicle("rov8")))
    begin = initial_state()
    begin[7] = np.inf
    never, steps = np.zeros(9, bool), 8
    zero = np.zeros((9, 3))
    sound = follow_window(
        packed.vector,
        begin,
        np.zeros((steps, MOST_THRUSTERS)),
        0.02,
        4,
        RK4,
        np.eye(6),
        np.ones(4),
        np.zeros(3),
        zero,
        never,
        zero,
        never,
        np.zeros((9, 4)),
        never,
        zero,
        never,
        *packed.tables,
        np.empty((9, STATE)),
        np.zeros((steps, 6)),
    )
    assert not sound
