"""What a run refuses, each with one clear message, and what it leaves alone."""

from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.cases import run_many
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import initial_state, run

Make = Callable[..., PackedVehicle]


def test_a_command_that_is_not_a_number_is_named(make_packed: Make) -> None:
    commands = np.zeros((100, 5))
    commands[37, 2] = np.nan
    with pytest.raises(CannotComputeError, match=r"command of left at 12\.740 s is not a number"):
        run(make_packed(), commands, dt_s=0.02, start_time_s=12.0)


@pytest.mark.parametrize("shape", [(10, 4), (10,), (0, 5)])
def test_commands_of_a_wrong_shape_are_refused(make_packed: Make, shape: tuple[int, ...]) -> None:
    with pytest.raises(CannotComputeError, match=r"\(steps, 5\) are expected.*upper, lower"):
        run(make_packed(), np.zeros(shape), dt_s=0.02)


def test_a_step_too_large_never_ends_in_a_silent_nan(make_packed: Make) -> None:
    packed = make_packed(quadratic_damping=np.array([20.0, 150.0, 160.0, 1.0, 60.0, 50.0]) * 1e3)
    start = initial_state(nu=(3.0, 1.0, 1.0, 1.0, 1.0, 1.0))
    with pytest.raises(CannotComputeError, match=r"a step of 0\.5 s is too large"):
        run(packed, np.zeros((2000, 5)), dt_s=0.5, start=start)


def test_codes_beyond_the_range_are_held_at_it(make_packed: Make) -> None:
    packed = make_packed()
    far, full = np.full((50, 5), 900.0), np.full((50, 5), 127.0)
    assert run(packed, far, dt_s=0.02).nu.tobytes() == run(packed, full, dt_s=0.02).nu.tobytes()


def test_inputs_are_left_alone(make_packed: Make) -> None:
    packed, start = make_packed(), initial_state(nu=(1.0, 0, 0, 0, 0, 0.1))
    commands = np.full((50, 5), 30.0)
    kept = packed.vector.copy(), start.copy(), commands.copy()
    run(packed, commands, dt_s=0.02, start=start)
    for now, before in zip((packed.vector, start, commands), kept, strict=True):
        assert now.tobytes() == before.tobytes()


def test_an_outside_force_acts_as_newton_says(make_packed: Make) -> None:
    """No water: 60 N ahead on 60 kg, for 2 s of the 4."""
    packed = make_packed(
        added_mass=np.zeros((6, 6)),
        linear_damping=np.zeros((6, 6)),
        quadratic_damping=np.zeros(6),
        centre_of_mass=np.zeros(3),
        inertia=np.eye(3),
        weight=0.0,
        buoyancy=0.0,
    )
    external = np.zeros((200, 6))
    external[:100, 0] = 60.0
    end = run(packed, np.zeros((200, 5)), dt_s=0.02, external=external)
    assert end.nu[-1] == pytest.approx([2.0, 0, 0, 0, 0, 0], abs=1e-12)
    assert end.position_ned_m[-1, 0] == pytest.approx(2.0 + 4.0)


def test_threads_give_what_one_after_the_other_gives(make_packed: Make) -> None:
    packed = make_packed()
    vectors = []
    for share in (0.9, 1.0, 1.1):
        vector = packed.vector.copy()
        read(vector, "thrust_gain")[:] = share
        vectors.append(vector)
    commands = np.full((300, 5), 60.0)
    both = run_many(packed, commands, vectors, dt_s=0.02, threads=2)
    for vector, parallel in zip(vectors, both, strict=True):
        alone = run(packed, commands, dt_s=0.02, vector=vector)
        assert parallel.nu.tobytes() == alone.nu.tobytes()
