"""Strip sums: no interval too many, moments about any point, the slender limit of Lamb."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import CannotComputeError
from pipeline.physics.added_mass_shapes import ellipsoid_added_mass, moved_added_mass
from pipeline.physics.strip_theory import (
    equivalent_spheroid,
    slender_hull_added_mass,
)


@pytest.mark.parametrize("stations", [2, 3, 20, 21, 22])
def test_cylinder_carries_exactly_its_water_whatever_the_number_of_stations(stations: int) -> None:
    """Summing 21 strips of length L / 20 would give 5 % too much."""
    x = np.linspace(-1.0, 1.0, stations)
    a = slender_hull_added_mass(x, np.full(stations, 0.1), 1000.0)
    mass = 1000 * math.pi * 0.1**2 * 2
    assert a[1, 1] == pytest.approx(mass, rel=1e-13)
    assert a[2, 2] == pytest.approx(mass, rel=1e-13)
    assert a[5, 5] == pytest.approx(mass * 2**2 / 12, rel=1e-13)
    assert a[4, 4] == pytest.approx(mass * 2**2 / 12, rel=1e-13)
    assert a[1, 5] == pytest.approx(0.0, abs=1e-12)


def test_cone_is_integrated_exactly_from_two_stations() -> None:
    """R = 0.3 x on 0 ... 1: mass pi rho 0.09 / 3, first moment / 4, second moment / 5."""
    a = slender_hull_added_mass([0.0, 1.0], [0.0, 0.3], 1000.0)
    k = 1000 * math.pi * 0.09
    assert a[1, 1] == pytest.approx(k / 3, rel=1e-13)
    assert a[1, 5] == pytest.approx(k / 4, rel=1e-13)
    assert a[2, 4] == pytest.approx(-k / 4, rel=1e-13)
    assert a[5, 5] == pytest.approx(k / 5, rel=1e-13)


@pytest.mark.parametrize(("ratio", "tolerance"), [(20.0, 0.014), (100.0, 9e-4), (400.0, 9e-5)])
def test_slender_spheroid_tends_to_lamb(ratio: float, tolerance: float) -> None:
    x = ratio * np.cos(np.linspace(math.pi, 0.0, 801))
    radius = np.sqrt(np.maximum(0.0, 1 - (x / ratio) ** 2))
    strips = slender_hull_added_mass(x, radius, 1.0)
    exact = ellipsoid_added_mass((ratio, 1.0, 1.0), 1.0)
    assert strips[1, 1] == pytest.approx(exact[1, 1], rel=tolerance)
    assert strips[5, 5] == pytest.approx(exact[5, 5], rel=3 * tolerance)


def test_spheroid_of_six_diameters_needs_its_end_factors() -> None:
    x = 3.0 * np.cos(np.linspace(math.pi, 0.0, 801))
    radius = 0.5 * np.sqrt(np.maximum(0.0, 1 - (x / 3.0) ** 2))
    strips = slender_hull_added_mass(x, radius, 1000.0)
    ends = equivalent_spheroid(6.0, 4 / 3 * math.pi * 3 * 0.25, 1000.0)
    exact = ellipsoid_added_mass((3.0, 0.5, 0.5), 1000.0)
    assert ends.radius_m == pytest.approx(0.5)
    assert ends.surge_kg == pytest.approx(exact[0, 0], rel=1e-12)
    assert strips[1, 1] * ends.sway_factor == pytest.approx(exact[1, 1], rel=2e-4)
    assert strips[5, 5] * ends.yaw_factor == pytest.approx(exact[5, 5], rel=2e-4)
    assert strips[1, 1] / exact[1, 1] == pytest.approx(1.090, abs=1e-3)
    assert strips[5, 5] / exact[5, 5] == pytest.approx(1.276, abs=1e-3)


@given(
    radii=st.lists(st.floats(0.01, 0.5), min_size=3, max_size=8),
    reference=st.floats(-5.0, 5.0),
)
def test_another_reference_point_is_the_same_body(radii: list[float], reference: float) -> None:
    """Strips about a point equal strips about the origin, moved by the general rule."""
    x = np.linspace(-2.0, 1.0, len(radii))
    about_origin = slender_hull_added_mass(x, radii, 1000.0)
    about_point = slender_hull_added_mass(x - reference, radii, 1000.0)
    moved = moved_added_mass(about_origin, np.array([-reference, 0.0, 0.0]))
    assert about_point == pytest.approx(moved, rel=1e-9, abs=1e-7)


def test_order_of_stations_does_not_matter() -> None:
    x, radius = np.array([-1.0, 0.2, 1.0]), np.array([0.1, 0.3, 0.0])
    forward = slender_hull_added_mass(x, radius, 1000.0)
    backward = slender_hull_added_mass(x[::-1], radius[::-1], 1000.0)
    assert backward == pytest.approx(forward, rel=1e-12)


@pytest.mark.parametrize(
    "call",
    [
        lambda: equivalent_spheroid(1.0, 10.0, 1000.0),
    ],
)
def test_bad_sections_are_refused(call: object) -> None:
    with pytest.raises(CannotComputeError):
        call()  # type: ignore[operator]
