"""What each omission does to the slope, on simulated runs of the paper's geometry."""

import numpy as np
import pytest

from evaluation.slope_omissions import (
    OmissionShift,
    omission_shifts,
    slope_added_mass,
)
from pipeline.physics.added_mass_shapes import potapov_galyaev

TRUTH_KG = potapov_galyaev().surge_kg


@pytest.fixture(scope="module")
def shifts() -> dict[str, list[OmissionShift]]:
    found: dict[str, list[OmissionShift]] = {}
    for one in omission_shifts():
        found.setdefault(one.term, []).append(one)
    return found


def test_with_nothing_omitted_the_slope_is_right(shifts: dict[str, list[OmissionShift]]) -> None:
    assert shifts["none"][0].added_mass_kg == pytest.approx(TRUTH_KG, abs=0.01)


def test_slope_of_a_known_mass() -> None:
    time_s = np.arange(0.0, 20.0, 0.02)
    force = np.sin(time_s) + 0.5 * np.cos(2.3 * time_s)
    speed = np.concatenate([[0.0], np.cumsum(force * 0.02)])[:-1] / (12.5 + 7.0)
    assert slope_added_mass(force, speed, 0.02) == pytest.approx(7.0, abs=1e-6)


@pytest.mark.parametrize(("term", "sign"), [("drag", 1), ("walls", 1), ("rotation", -1)])
def test_direction_of_each_shift_and_that_it_grows(
    shifts: dict[str, list[OmissionShift]], term: str, sign: int
) -> None:
    """Drag and walls take acceleration away; a turn gives some back through the sway speed."""
    sizes = [sign * one.shift_kg for one in shifts[term]]
    assert sizes[0] > 0.05
    assert all(np.diff(sizes) > 0)


def test_residual_buoyancy_pulls_either_way(shifts: dict[str, list[OmissionShift]]) -> None:
    """Bow up under thrust: a heavy vehicle loses acceleration, a light one gains."""
    heavy, light = shifts["buoyancy"][0], shifts["buoyancy"][-1]
    assert heavy.shift_kg > 0.5
    assert light.shift_kg < -0.5


def test_walls_by_their_factor(shifts: dict[str, list[OmissionShift]]) -> None:
    """Two walls at distance d, c = 1: A grows by 2 (R / d)^3, while the vehicle keeps its place."""
    near = shifts["walls"][1]
    assert near.size == "two walls 0.5 m off"
    assert near.shift_kg == pytest.approx(TRUTH_KG * 2 * (0.15 / 0.5) ** 3, rel=0.05)


def test_the_printed_value_is_inside_what_omissions_can_do(
    shifts: dict[str, list[OmissionShift]],
) -> None:
    """18.92 kg can be bracketed, not taken apart."""
    every = [one.added_mass_kg for group in shifts.values() for one in group]
    assert min(every) < 18.92 < max(every)
