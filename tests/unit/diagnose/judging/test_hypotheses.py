"""Choice among planted departures, with known information."""

import numpy as np
import pytest
from diagnosis_cases import EFFECTS, STRENGTH, index_of, planted, small_coordinates

from pipeline.diagnose.judging.hypotheses import (
    groups_of,
    judge,
    screen,
    with_all_parameters,
)
from pipeline.diagnose.linear.coordinates import Coordinate


@pytest.fixture(scope="module")
def every() -> tuple[Coordinate, ...]:
    return small_coordinates()


def test_the_planted_effect_comes_first_with_its_target(every: tuple[Coordinate, ...]) -> None:
    place = index_of(every, "thruster_degraded:thrust_fraction@rear_left")
    first = screen(planted(every, {place: -0.8}), every, groups_of(every))[0]
    assert first.groups == (("thruster_degraded", "rear_left"),)
    assert first.which == (place,)
    # shrunk by its own prior: S / (S + 1)
    assert first.mean[0] == pytest.approx(-0.8 * STRENGTH / (STRENGTH + 1))


def test_of_an_effect_only_the_axes_at_work_are_taken(every: tuple[Coordinate, ...]) -> None:
    places = [index_of(every, f"quadratic_damping:{axis}") for axis in ("surge", "yaw")]
    first = screen(planted(every, dict.fromkeys(places, 1.0)), every, groups_of(every))[0]
    assert first.effects == ("quadratic_damping",)
    assert set(first.which) == set(places)


def test_a_further_axis_must_pay_more_than_chance_gives(every: tuple[Coordinate, ...]) -> None:
    """Ten units of log evidence are one of 0.22: its square over two, times 400."""
    surge, yaw = (index_of(every, f"quadratic_damping:{axis}") for axis in ("surge", "yaw"))
    for size, taken in ((0.15, {surge}), (0.35, {surge, yaw})):
        first = screen(planted(every, {surge: 1.0, yaw: size}), every, groups_of(every))[0]
        assert set(first.which) == taken


def test_nothing_planted_leaves_no_evidence(every: tuple[Coordinate, ...]) -> None:
    assert screen(planted(every, {}), every, groups_of(every))[0].log_evidence < 0.0


def test_a_thruster_that_gives_more_is_not_degraded(every: tuple[Coordinate, ...]) -> None:
    place = index_of(every, "thruster_degraded:thrust_fraction@rear_left")
    assert judge(planted(every, {place: 0.8}), every, [place])[0] == -np.inf


def test_effects_of_the_case_are_those_tried(every: tuple[Coordinate, ...]) -> None:
    assert {one.effect.id for one in every} == set(EFFECTS)


@pytest.fixture(scope="module")
def heavy() -> tuple[Coordinate, ...]:
    return small_coordinates(("payload",))


def test_a_payload_of_no_mass_has_no_moment(heavy: tuple[Coordinate, ...]) -> None:
    mass, place = index_of(heavy, "payload:mass_kg"), index_of(heavy, "payload:y_m")
    assert mass in heavy[place].leads
    alone, _, _, _ = judge(planted(heavy, {place: 0.5}), heavy, [mass, place])
    with_mass, mean, _, variance = judge(
        planted(heavy, {mass: 0.5, place: 0.5}), heavy, [mass, place]
    )
    # the same moment needs a mass: without one it explains less than half
    assert alone < 0.5 * with_mass
    assert mean == pytest.approx([0.5, 0.5], rel=0.02)
    # a place one plausible range away at the mass that was found
    assert variance[1] == pytest.approx(0.25, rel=0.05)


def test_an_effect_of_few_parameters_is_looked_at_with_all_of_them() -> None:
    """A low supply has a part that grows with the load; seen from afar either seems to suffice."""
    every = small_coordinates(("voltage_sag", "quadratic_damping", "thruster_degraded"))
    groups = groups_of(every)
    drop, load = (index_of(every, f"voltage_sag:{name}") for name in ("drop", "load_drop"))
    ground = planted(every, {drop: 1.0, load: 0.2})
    one = next(f for f in screen(ground, every, groups) if f.effects == ("voltage_sag",))
    assert one.which == (drop,)
    whole = with_all_parameters(ground, every, groups, one)
    assert whole is not None
    assert set(whole.which) == {drop, load}
    # what the second is worth does not pay for it here: 8 units less than the 10 of its price
    assert one.log_evidence - 15.0 < whole.log_evidence < one.log_evidence
    assert with_all_parameters(ground, every, groups, whole) is None


def test_one_axis_or_one_thruster_is_an_effect_by_itself() -> None:
    every = small_coordinates(("payload", "quadratic_damping"))
    groups = groups_of(every)
    surge = index_of(every, "quadratic_damping:surge")
    volume = index_of(every, "payload:volume_m3")
    for place in (surge, volume):
        found = screen(planted(every, {place: 1.0}), every, groups)[0]
        assert found.which == (place,)
        assert with_all_parameters(planted(every, {place: 1.0}), every, groups, found) is None
