"""Truth and package fly the same commands: two programs that share no code have to agree.

Where the vehicle file states a lag alone both have the same physics, and agree to a per cent or so:
what is left is how the package's tables of the bollard curve are spaced, which shows in roll where
codes chatter about the dead zone. Where the truth turns the rotor they differ for a few hundredths
of a second after each step of the code.
"""

import numpy as np
import pytest

from pipeline.blind.draws import draw
from pipeline.blind.subject import BlindSubject, possible_effects, variant_for
from pipeline.blind.truth.craft import craft_of
from pipeline.blind.truth.faults import FAULTS, with_fault
from pipeline.blind.truth.flight import fly_craft, still
from pipeline.blind.truth.manoeuvres import belief_of, scene_of, wishes_of
from pipeline.effects.library import apply_effects, candidates, effects
from pipeline.effects.specification import EffectSpec
from pipeline.simulate.context import BenchModel, effect_context
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.run import initial_state, run

SECONDS = 15.0
#: Speeds and rates below which an error counts against these. [m/s, rad/s]
LEAST = np.array([0.05, 0.05, 0.05, 0.03, 0.03, 0.03])


def apart(subject: BlindSubject, effect: str | None, kind: str) -> np.ndarray:
    """Return the rms difference of the six velocities over their own size."""
    if effect is not None:
        subject = variant_for(subject, effect)
    craft = craft_of(subject.vehicle, subject.static)
    bench = None if subject.static is None else BenchModel(subject.static)
    packed = pack_vehicle(subject.vehicle, bench)
    rng = np.random.default_rng(5)
    scene = scene_of(craft)
    wishes, heading = wishes_of(kind, scene, SECONDS, rng)
    belief, vector, sick = belief_of(craft), packed.vector, craft
    if effect is not None:
        drawn = draw(effect, craft, scene, rng)
        values = drawn.at(min(0.6, drawn.most))
        sick = with_fault(craft, effect, values, drawn.thruster)
        spec = EffectSpec(effect, values, drawn.thruster)
        vector = apply_effects(vector, [spec], packed.context)
    place = (0.0, 0.0, scene.depth_m)
    flight = fly_craft(sick, belief, wishes=wishes, start=still(np.array(place), heading))
    theirs = run(
        packed,
        np.repeat(flight.commands, 5, axis=0),
        dt_s=0.02,
        vector=vector,
        start=initial_state(position_ned_m=place, attitude_rad=(0.0, 0.0, heading)),
    )
    size = np.maximum(flight.ground.std(axis=0), LEAST)
    return np.sqrt(((flight.ground - theirs.nu) ** 2).mean(axis=0)) / size


def test_the_truth_knows_every_effect_that_its_vehicles_can_have(
    rov8: BlindSubject, carrier: BlindSubject, mmt300: BlindSubject
) -> None:
    assert set(FAULTS) <= set(effects())
    for subject in (rov8, carrier, mmt300):
        assert set(candidates(effect_context(subject.vehicle))) <= set(FAULTS), subject.name


@pytest.mark.parametrize("kind", ["multisine", "tasks"])
def test_the_stated_vehicle_flies_alike(rov8: BlindSubject, kind: str) -> None:
    assert (apart(rov8, None, kind) < [0.01, 0.01, 0.01, 0.08, 0.02, 0.01]).all()


@pytest.mark.parametrize("effect", sorted(FAULTS))
def test_each_effect_does_the_same(rov8: BlindSubject, effect: str) -> None:
    assert effect in possible_effects(rov8)
    # near a wall the truth has the suction of the wall, which the library leaves out
    limit = 0.05 if effect == "wall_effect" else 0.01
    assert apart(rov8, effect, "multisine").max() < limit


@pytest.mark.parametrize("effect", [None, "coriolis_omitted", "advance_speed_loss", "payload"])
def test_a_heavy_vehicle_with_modules_flies_alike(
    carrier: BlindSubject, effect: str | None
) -> None:
    assert apart(carrier, effect, "zigzag").max() < 0.005


@pytest.mark.parametrize("effect", [None, "thruster_lag", "coriolis_omitted", "dead_zone", "lift"])
def test_rotors_that_turn_in_time_follow_the_stated_lag(
    mmt300: BlindSubject, effect: str | None
) -> None:
    assert (apart(mmt300, effect, "tasks") < [0.02, 0.01, 0.02, 0.01, 0.08, 0.01]).all()


def test_an_effect_changes_the_flight(rov8: BlindSubject) -> None:
    craft = craft_of(rov8.vehicle)
    weak = with_fault(craft, "thruster_degraded", {"thrust_fraction": 0.5}, "front_left")
    codes = np.full((50, 8), 150.0)
    first, second = (fly_craft(one, belief_of(craft), commands=codes) for one in (craft, weak))
    assert abs(first.ground[-1, 5] - second.ground[-1, 5]) > 0.1
