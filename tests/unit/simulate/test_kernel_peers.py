"""The compiled kernel, textbook NumPy and plain C give the same runs: three programs, one model."""

import numpy as np
import pytest

from benchmarks import cases
from benchmarks.peer_c_library import PeerC, build, compiler
from benchmarks.peer_numpy import Simulated, simulate_numpy
from pipeline.physics.parameters import write
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Method, Trajectory, run

STEPS, DT_S = 150, 0.02
EXTERNAL = np.array([1.0, -2.0, 0.5, 0.1, 0.2, -0.3])
#: Each with something switched on that the others have not.
VEHICLES = {
    "nominal": {},
    "effects": {"effects": True, "walls": False},
    "walls": {"effects": True},
    "shafts": {"shafts": True},
    "effects_and_shafts": {"effects": True, "shafts": True},
    "one_thruster": {"thrusters": 1, "effects": True},
    "twelve_thrusters": {"thrusters": 12, "effects": True},
}


@pytest.fixture(scope="module")
def peer_c(tmp_path_factory: pytest.TempPathFactory) -> PeerC:
    if compiler() is None:
        pytest.skip("gcc is not installed: the kernel is not compared with C")
    return build(tmp_path_factory.mktemp("peer"))


def columns(result: Trajectory | Simulated) -> np.ndarray:
    """State, acceleration and thrust of every sample, side by side."""
    if isinstance(result, Simulated):
        return np.hstack([result.states, result.accelerations, result.thrusts])
    parts = (result.position_ned_m, result.quaternion, result.nu, result.actuator)
    return np.hstack([*parts, result.nu_dot, result.thrust_n])


def largest_difference(a: Trajectory, b: Simulated) -> float:
    """Over the columns: largest difference, relative to the column's largest value."""
    expected = columns(a)
    size = np.abs(expected).max(axis=0)
    return float((np.abs(columns(b) - expected).max(axis=0) / np.maximum(size, 1e-9)).max())


def kernel_run(packed: PackedVehicle, commands: np.ndarray, method: Method) -> Trajectory:
    outside = EXTERNAL[None, :]
    return run(packed, commands, dt_s=DT_S, start=cases.START, external=outside, method=method)


@pytest.fixture(params=VEHICLES)
def packed(request: pytest.FixtureRequest) -> PackedVehicle:
    return cases.vehicle(**VEHICLES[request.param])


@pytest.mark.parametrize("method", ["rk4", "semi_implicit"])
def test_textbook_numpy_agrees(packed: PackedVehicle, method: Method) -> None:
    commands = cases.multisine(STEPS, len(packed.thruster_names))
    textbook = simulate_numpy(
        packed, commands, dt_s=DT_S, start=cases.START, external=EXTERNAL, method=method
    )
    assert largest_difference(kernel_run(packed, commands, method), textbook) <= 1e-9


@pytest.mark.parametrize("method", ["rk4", "semi_implicit"])
def test_plain_c_agrees(packed: PackedVehicle, peer_c: PeerC, method: Method) -> None:
    commands = cases.multisine(STEPS, len(packed.thruster_names))
    plain = peer_c.simulate(
        packed, commands, dt_s=DT_S, start=cases.START, external=EXTERNAL, method=method
    )
    assert largest_difference(kernel_run(packed, commands, method), plain) <= 1e-9


def test_the_comparison_would_notice_a_wrong_sign() -> None:
    """A change of one part in ten thousand in one lift slope shows."""
    packed = cases.vehicle(effects=True)
    commands = cases.multisine(STEPS)
    changed = packed.vector.copy()
    write(changed, "yaw_lift_slope", 15.0015)
    other = simulate_numpy(
        packed,
        commands,
        dt_s=DT_S,
        start=cases.START,
        vector=changed,
        external=EXTERNAL,
        method="rk4",
    )
    assert largest_difference(kernel_run(packed, commands, "rk4"), other) > 1e-7


def test_every_effect_of_the_case_moves_the_run() -> None:
    """The case that is called `effects` does not compare zeros: each slot it sets matters."""
    packed, neutral = cases.vehicle(effects=True), cases.nominal_vector(5)
    commands = cases.multisine(STEPS)
    full = kernel_run(packed, commands, "semi_implicit").nu
    for slots in cases.SWITCHES:
        vector = packed.vector.copy()
        cases.reset(vector, neutral, slots)
        without = run(
            packed,
            commands,
            dt_s=DT_S,
            vector=vector,
            start=cases.START,
            external=EXTERNAL[None, :],
            method="semi_implicit",
        ).nu
        assert np.abs(without - full).max() > 1e-5, slots
