"""What in a thruster lags: its forms against closed solutions, and that it is no answer."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from effect_cases import CONTEXT, sample_vector

from pipeline.effects.library import EffectSpec, apply_effects, candidates, effects, unstated
from pipeline.physics.parameters import read, write
from pipeline.simulate.applied_wrench import actuator_states, thruster_wrench
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.types import FloatArray

STEP_S = 0.01
LAG_S = 0.15
DEAD, LARGEST = 28.0, 400.0
LEFT = np.exp(-STEP_S * np.arange(101) / LAG_S)


@pytest.fixture(scope="module")
def rov(repository: Path) -> PackedVehicle:
    """rov8 with a lag of 0.15 s: 400 codes, 28 of them dead, thrust with their power 1.33."""
    packed = pack_vehicle(bundled(repository, "rov8"))
    write(packed.vector, "lag", LAG_S)
    assert read(packed.vector, "drive_dead")[0] == DEAD
    assert read(packed.vector, "code_max")[0] == LARGEST
    return packed


def shares(rov: PackedVehicle, first: float, then: float, values: dict[str, float]) -> FloatArray:
    """Signed share of the codes beyond the dead zone after a step from one code to another."""
    vector = apply_effects(rov.vector, [EffectSpec("lag_form", values)], rov.context)
    count = len(rov.thruster_names)
    command = np.full((600, count), first)
    command[500:] = then
    codes = actuator_states(rov, command, STEP_S, vector=vector)[500:, 0]
    return np.sign(codes) * np.maximum(np.abs(codes) - DEAD, 0.0) / (LARGEST - DEAD)


@pytest.mark.parametrize("power", [0.665, 1.0, 1.33, 2.0])
def test_a_power_of_the_code_beyond_the_dead_zone_lags(rov: PackedVehicle, power: float) -> None:
    """First order by hand: q = q_1 + (q_0 - q_1) exp(-t / tau), through zero as well.

    Shaft speed (half the exponent of the characteristic), code, thrust (all of it), and more.
    """
    found = shares(rov, 300.0, -200.0, {"dead_share": 1.0, "power": power})
    s0, s1 = (300 - DEAD) / 372, -(200 - DEAD) / 372
    q0, q1 = (np.sign(s) * abs(s) ** power for s in (s0, s1))
    q = q1 + (q0 - q1) * LEFT
    assert np.sign(found) * np.abs(found) ** power == pytest.approx(q, abs=1e-12)


def test_a_drive_that_holds_a_torque(rov: PackedVehicle) -> None:
    """J dn/dt = Q - k n|n| in a hundred small steps for each of ours, ahead and through zero."""
    late_s = 0.3
    rov_late = replace(rov, vector=rov.vector.copy())
    write(rov_late.vector, "lag", late_s / np.sqrt(2.0))
    # at a twentieth of the range and less, too
    for first, then in (
        (300.0, 350.0), (60.0, 64.0), (60.0, -300.0), (44.0, 30.0), (44.0, -44.0)
    ):  # fmt: skip
        values = {"dead_share": 1.0, "power": 0.5, "fall": 0.5}
        found = shares(rov_late, first, then, values)
        q, n = ((np.abs([then, first]) - DEAD) / (LARGEST - DEAD)).tolist()
        q, n = np.copysign(q, then), np.copysign(np.sqrt(n), first)
        speeds = [n]
        for _ in range(100 * (len(found) - 1)):
            n += 0.01 * STEP_S * (q - n * abs(n)) / late_s
            speeds.append(n)
        expected = np.array(speeds[::100])
        size = 0.01 * abs(q - expected[0] * abs(expected[0]))
        assert found == pytest.approx(expected * np.abs(expected), abs=size)


def test_a_dead_zone_behind_the_lag_delays_what_changes_its_sign(rov: PackedVehicle) -> None:
    before = shares(rov, 300.0, -200.0, {"dead_share": 1.0})
    behind = shares(rov, 300.0, -200.0, {})
    code = -200 + 500 * LEFT
    by_hand = np.sign(code) * np.maximum(np.abs(code) - DEAD, 0.0) / (LARGEST - DEAD)
    assert behind == pytest.approx(by_hand, abs=1e-12)
    # the way is longer: what was the one side of zero goes sooner, the other comes later
    assert float(np.min(behind - before)) < -0.02
    assert float(np.max(behind - before)) > 0.05


def test_half_of_the_dead_zone_lies_between(rov: PackedVehicle) -> None:
    none, half, whole = (shares(rov, 300, -200, {"dead_share": s}) for s in (0.0, 0.5, 1.0))
    assert (np.minimum(none, whole) <= half + 1e-9).all()
    assert (np.maximum(none, whole) >= half - 1e-9).all()


def test_at_rest_all_forms_are_the_same(rov: PackedVehicle) -> None:
    """Where codes hold, so does the characteristic: also inside the dead zone."""
    count = len(rov.thruster_names)
    for code in (-400.0, -150.0, -20.0, 0.0, 10.0, 28.0, 60.0, 400.0):
        thrust = []
        for values in ({}, {"dead_share": 1.0}, {"dead_share": 0.4, "power": 1.7, "fall": 0.5}):
            vector = apply_effects(rov.vector, [EffectSpec("lag_form", values)], rov.context)
            states = actuator_states(rov, np.full((500, count), code), STEP_S, vector=vector)
            thrust.append(thruster_wrench(rov, states[-1:], np.zeros((1, 6)))[1][0])
        # at the edge of the dead zone the table is a line from the code before to the one after
        assert thrust[1] == pytest.approx(thrust[0], abs=2e-3)
        assert thrust[2] == pytest.approx(thrust[0], abs=2e-3)


@pytest.mark.parametrize(
    ("slot", "bound"),
    [("lag_dead_share", 0.0), ("lag_dead_share", 1.0), ("lag_power", 1.0), ("lag_fall", 0.0)],
)
def test_the_thrust_has_no_kink_at_the_bounds(rov: PackedVehicle, slot: str, bound: float) -> None:
    """A fit that crosses a bound, or the form that is computed otherwise, goes on as it came."""

    def thrust(share: float) -> FloatArray:
        vector = rov.vector.copy()
        write(vector, slot, share)
        wave = 120.0 * np.sin(0.1 * np.arange(300))[:, None] * np.ones(len(rov.thruster_names))
        codes = actuator_states(rov, wave, STEP_S, vector=vector)
        return thruster_wrench(rov, codes, np.zeros((len(codes), 6)), vector=vector)[1][:, 0]

    outside, at, inside = thrust(bound + 1e-3), thrust(bound), thrust(bound - 1e-3)
    slope = float(np.linalg.norm(outside - inside))
    assert slope > 1e-3
    # a kink or a bound would leave all of it; what is left are the corners of the table
    assert float(np.linalg.norm(outside - 2.0 * at + inside)) < 0.5 * slope


def test_it_is_no_answer_but_may_differ_on_any_vehicle() -> None:
    assert "lag_form" not in effects()
    assert "lag_form" not in candidates(CONTEXT)
    assert "lag_form" in unstated(CONTEXT)
    vector = sample_vector()
    changed = apply_effects(vector, [EffectSpec("lag_form", {"power": 1.8})], CONTEXT)
    assert read(changed, "lag_power") == 1.8 * read(vector, "lag_power")
