"""Which effects are one answer, with known information."""

import numpy as np
import pytest
from diagnosis_cases import index_of, small_coordinates

from pipeline.diagnose.judging.confusability import alike
from pipeline.diagnose.judging.hypotheses import Finding, groups_of
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.linear.elimination import Marginal

STRENGTH = 400.0


@pytest.fixture(scope="module")
def every() -> tuple[Coordinate, ...]:
    return small_coordinates()


def ground(every: tuple[Coordinate, ...], cosine: float) -> Marginal:
    """Information in which buoyancy and the DVL's scale have signatures at a known angle."""
    first, second = index_of(every, "dvl_scale:scale"), index_of(every, "residual_buoyancy:force_n")
    information = STRENGTH * np.eye(len(every))
    information[first, second] = information[second, first] = cosine * STRENGTH
    return Marginal(information, np.zeros(len(every)), 0.0, 0.0)


def finding(every: tuple[Coordinate, ...], *names: str) -> Finding:
    which = tuple(index_of(every, name) for name in names)
    groups = tuple((every[k].effect.id, every[k].target) for k in which)
    return Finding(
        groups, which, 10.0, np.ones(len(which)), np.eye(len(which)), np.ones(len(which))
    )


@pytest.mark.parametrize("degrees", [8.0, 12.0])
def test_signatures_within_ten_degrees_are_one_answer(
    every: tuple[Coordinate, ...], degrees: float
) -> None:
    heavy = finding(every, "residual_buoyancy:force_n")
    known = ground(every, float(np.cos(np.radians(degrees))))
    told = alike(known, heavy, every, groups_of(every))
    assert told == (("dvl_scale",) if degrees < 10.0 else ())


def test_what_one_of_two_effects_cannot_be_told_from_is_named(
    every: tuple[Coordinate, ...],
) -> None:
    both = finding(
        every, "residual_buoyancy:force_n", "thruster_degraded:thrust_fraction@front_left"
    )
    known = ground(every, float(np.cos(np.radians(5.0))))
    # together the two are 45 degrees away from it
    assert alike(known, both, every, groups_of(every)) == ("dvl_scale",)
