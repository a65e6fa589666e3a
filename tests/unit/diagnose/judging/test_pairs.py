"""Pairs among planted departures, with known information."""

import numpy as np
import pytest
from diagnosis_cases import STRENGTH, index_of, planted, small_coordinates

from pipeline.diagnose.judging.hypotheses import groups_of, screen
from pipeline.diagnose.judging.pairs import pairs, pairs_under
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.elimination import Marginal


@pytest.fixture(scope="module")
def every() -> tuple[Coordinate, ...]:
    return small_coordinates()


def test_a_pair_is_found_and_must_pay_for_itself(every: tuple[Coordinate, ...]) -> None:
    heavy, weak = (
        index_of(every, "residual_buoyancy:force_n"),
        index_of(every, "thruster_degraded:thrust_fraction@front_left"),
    )
    groups = groups_of(every)
    both = planted(every, {heavy: 0.7, weak: -0.9})
    found = pairs(both, every, groups, screen(both, every, groups), 3)
    assert found[0].effects == ("residual_buoyancy", "thruster_degraded")
    one = planted(every, {heavy: 0.7})
    single = screen(one, every, groups)
    twos = pairs(one, every, groups, single, 3)
    assert twos[0].log_evidence < single[0].log_evidence


def test_a_pair_is_judged_on_another_ground_as_where_it_is_found(
    every: tuple[Coordinate, ...],
) -> None:
    heavy, weak = (
        index_of(every, "residual_buoyancy:force_n"),
        index_of(every, "thruster_degraded:thrust_fraction@front_left"),
    )
    groups = groups_of(every)
    both, other = (planted(every, {heavy: size, weak: -0.9}) for size in (0.7, 0.2))
    there = pairs(other, every, groups, screen(other, every, groups), 3)
    again = pairs_under(other, every, groups, pairs(both, every, groups, there, 3) + there)
    assert again[0].which == there[0].which
    assert again[0].log_evidence == pytest.approx(there[0].log_evidence)
    assert len({one.which for one in again}) == len(again)


def test_two_effects_of_one_signature_are_no_pair(every: tuple[Coordinate, ...]) -> None:
    first, second = index_of(every, "dvl_scale:scale"), index_of(every, "residual_buoyancy:force_n")
    information = STRENGTH * np.eye(len(every))
    information[first, second] = information[second, first] = 0.99 * STRENGTH
    x = np.zeros(len(every))
    x[first] = 1.0
    ground = Marginal(information, information @ x, STRENGTH, 0.0)
    groups = groups_of(every)
    names = {one.effects for one in pairs(ground, every, groups, screen(ground, every, groups), 4)}
    assert ("dvl_scale", "residual_buoyancy") not in names
