"""What is plausible on a vehicle grows with it."""

from dataclasses import replace

import pytest

from pipeline.effects.library import candidates
from tests.unit.effects.effect_cases import CONTEXT


@pytest.mark.parametrize(
    ("effect", "name", "power"),
    [("payload", "mass_kg", 2), ("payload", "x_m", 1), ("lift", "yaw_slope", 3)],
)
def test_ranges_grow_with_the_length_of_the_vehicle(effect: str, name: str, power: int) -> None:
    half = replace(CONTEXT, mass_kg=100.0 / 8.0)
    ranges = [
        next(p for p in candidates(context)[effect].parameters if p.name == name).plausible
        for context in (CONTEXT, half)
    ]
    shares = [small / large for large, small in zip(*ranges, strict=True)]
    assert shares == pytest.approx([0.5**power] * 2, rel=0.05)


def test_factors_are_the_same_on_every_vehicle() -> None:
    heavy = replace(CONTEXT, mass_kg=8000.0)
    own, usual = (candidates(context)["added_mass"].parameters for context in (heavy, CONTEXT))
    assert own == usual
