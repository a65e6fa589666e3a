"""Added masses of shapes against Lamb's table, quadrature, limits and the paper's numbers."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import gamma

from pipeline.errors import CannotComputeError
from pipeline.physics.added_mass_sections import SectionAddedMass, rectangle_section
from pipeline.physics.added_mass_shapes import (
    disc_added_mass,
    ellipsoid_added_mass,
    moved_added_mass,
    potapov_galyaev,
)

#: Lamb 1918, ARC R&M 623: length over breadth, k_1, k_2, k'. Ratios as printed, two decimals.
LAMB_TABLE = (
    (1.0, 0.5, 0.5, 0.0),
    (1.5, 0.305, 0.621, 0.094),
    (2.0, 0.209, 0.702, 0.240),
    (2.51, 0.156, 0.763, 0.367),
    (2.99, 0.122, 0.803, 0.465),
    (3.99, 0.082, 0.860, 0.608),
    (4.99, 0.059, 0.895, 0.701),
    (6.01, 0.045, 0.918, 0.764),
    (6.97, 0.036, 0.933, 0.805),
    (8.01, 0.029, 0.945, 0.840),
    (9.02, 0.024, 0.954, 0.865),
    (9.97, 0.021, 0.960, 0.883),
)

sides = st.floats(0.05, 20.0)


def ellipse_section(w: float, h: float) -> SectionAddedMass:
    """Half-width and half-height, in a fluid of density 1: Newman 1977, table 4.3."""
    return SectionAddedMass(math.pi * h**2, math.pi * w**2, math.pi / 8 * (w**2 - h**2) ** 2)


def coefficients(a: float, b: float, c: float) -> np.ndarray:
    """Return the diagonal over displaced mass and the displaced inertia."""
    mass = 4 / 3 * math.pi * a * b * c
    squares = np.array([b**2 + c**2, c**2 + a**2, a**2 + b**2]) / 5
    return np.diag(ellipsoid_added_mass((a, b, c), 1.0)) / mass / np.append(np.ones(3), squares)


@pytest.mark.parametrize(("ratio", "k_1", "k_2", "k_turn"), LAMB_TABLE)
def test_prolate_spheroid_follows_lambs_table(
    ratio: float, k_1: float, k_2: float, k_turn: float
) -> None:
    """The table was computed for ratios near the printed ones: 0.0025 is its own scatter."""
    got = coefficients(ratio, 1.0, 1.0)
    assert got[[0, 1, 2, 4, 5]] == pytest.approx([k_1, k_2, k_2, k_turn, k_turn], abs=2.5e-3)
    assert got[3] == 0.0


@pytest.mark.parametrize("ratio", [1.2, 2.0, 6.0, 30.0])
def test_prolate_spheroid_follows_the_closed_form(ratio: float) -> None:
    """Lamb section 114: alpha_0 and beta_0 of a spheroid by logarithms."""
    e = math.sqrt(1 - ratio**-2)
    log = 0.5 * math.log((1 + e) / (1 - e))
    alpha = 2 * (1 - e**2) / e**3 * (log - e)
    beta = 1 / e**2 - (1 - e**2) / e**3 * log
    turn = e**4 * (beta - alpha) / ((2 - e**2) * (2 * e**2 - (2 - e**2) * (beta - alpha)))
    assert coefficients(ratio, 1.0, 1.0)[[0, 1, 5]] == pytest.approx(
        [alpha / (2 - alpha), beta / (2 - beta), turn], rel=1e-10
    )


@pytest.mark.parametrize("axes", [(3.0, 2.0, 1.0), (0.2, 1.0, 0.7), (5.0, 0.5, 0.4)])
def test_triaxial_ellipsoid_follows_lambs_integrals(axes: tuple[float, float, float]) -> None:
    """Lamb's integrals by brute quadrature, all six coefficients."""
    a, b, c = axes

    def integral(axis: float) -> float:
        def inside(x: float) -> float:
            return 1 / ((axis**2 + x) * math.sqrt((a**2 + x) * (b**2 + x) * (c**2 + x)))

        near, far = quad(inside, 0, 50, epsrel=1e-12), quad(inside, 50, np.inf, epsrel=1e-12)
        return a * b * c * (near[0] + far[0])

    i = [integral(axis) for axis in axes]
    mass = 4 / 3 * math.pi * a * b * c
    expected = [v / (2 - v) * mass for v in i]
    for p, q in ((1, 2), (2, 0), (0, 1)):
        difference, total = axes[p] ** 2 - axes[q] ** 2, axes[p] ** 2 + axes[q] ** 2
        split = i[q] - i[p]
        expected.append(mass / 5 * difference**2 * split / (2 * difference - total * split))
    assert np.diag(ellipsoid_added_mass(axes, 1.0)) == pytest.approx(expected, rel=1e-8)


def test_flat_ellipsoid_becomes_the_disc() -> None:
    mass, inertia = disc_added_mass(0.7, 1000.0)
    flat = ellipsoid_added_mass((1e-5, 0.7, 0.7), 1000.0)
    assert flat[0, 0] == pytest.approx(mass, rel=1e-4)
    assert flat[4, 4] == pytest.approx(inertia, rel=1e-4)


@given(a=sides, b=sides, c=sides)
def test_ellipsoid_is_never_negative_and_turns_with_its_axes(a: float, b: float, c: float) -> None:
    first = np.diag(ellipsoid_added_mass((a, b, c), 1025.0))
    turned = np.diag(ellipsoid_added_mass((b, c, a), 1025.0))
    assert (first >= 0).all()
    assert turned == pytest.approx(first[[1, 2, 0, 4, 5, 3]], rel=1e-6, abs=1e-9 * first.max())


def test_square_section_is_newmans_two_numbers() -> None:
    """4.754 and 0.725 belong to a section (per metre); 4.754 has a closed form."""
    square = rectangle_section(2.0, 2.0, 1.0)
    assert square.sway_kgpm == pytest.approx(gamma(0.25) ** 4 / (2 * math.pi**2) - 4, rel=1e-12)
    assert round(square.sway_kgpm, 3) == 4.754
    assert round(square.roll_kgm, 3) == 0.725


@pytest.mark.parametrize(
    ("width_over_height", "printed"),
    [(10.0, 1.14), (5.0, 1.21), (2.0, 1.36), (1.0, 1.51), (0.5, 1.70), (0.2, 1.98), (0.1, 2.23)],
)
def test_rectangular_section_follows_the_published_table(
    width_over_height: float, printed: float
) -> None:
    """DNV-RP-H103 table A-1, motion across the width, on pi a^2 with 2a the width."""
    section = rectangle_section(2 * width_over_height, 2.0, 1.0)
    assert section.heave_kgpm / (math.pi * width_over_height**2) == pytest.approx(printed, abs=0.01)


def test_thin_rectangle_becomes_the_plate() -> None:
    thin, plate = rectangle_section(2.0, 2.1e-3, 1.0), ellipse_section(1.0, 0.0)
    assert thin.heave_kgpm == pytest.approx(plate.heave_kgpm, rel=5e-3)
    assert thin.roll_kgm == pytest.approx(plate.roll_kgm, rel=8e-3)
    assert thin.sway_kgpm < 1e-4


@given(width=st.floats(0.1, 10.0), height=st.floats(0.1, 10.0))
def test_rectangle_lies_between_the_ellipses_inside_and_around(width: float, height: float) -> None:
    """Of two bodies, one inside the other, the outer has more added plus displaced mass."""
    got = rectangle_section(width, height, 1.0)
    inside = ellipse_section(width / 2, height / 2)
    around = ellipse_section(width / math.sqrt(2), height / math.sqrt(2))
    area = width * height
    low, high = math.pi / 4 * area, math.pi / 2 * area
    assert inside.sway_kgpm + low <= got.sway_kgpm + area <= around.sway_kgpm + high
    assert inside.heave_kgpm + low <= got.heave_kgpm + area <= around.heave_kgpm + high
    other = rectangle_section(height, width, 1.0)
    assert other.roll_kgm == pytest.approx(got.roll_kgm, rel=1e-6)


def test_moved_part_keeps_its_kinetic_energy() -> None:
    """Any motion of the vehicle gives the part the same energy, seen from either point."""
    rng = np.random.default_rng(3)
    part = ellipsoid_added_mass((0.6, 0.3, 0.2), 1000.0)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    arm = np.array([0.4, -0.2, 0.7])
    moved = moved_added_mass(part, arm, rotation)
    for nu in rng.normal(size=(5, 6)):
        at_part = np.concatenate(
            [rotation.T @ (nu[:3] + np.cross(nu[3:], arm)), rotation.T @ nu[3:]]
        )
        assert nu @ moved @ nu == pytest.approx(at_part @ part @ at_part, rel=1e-12)
    assert moved == pytest.approx(moved.T, abs=1e-9)


def test_potapov_galyaev_number_by_number() -> None:
    """Section 4.1 prints 12.05 kg for the first; 18.92 kg were measured in the pool."""
    paper = potapov_galyaev()
    assert round(paper.surge_kg, 2) == 12.02
    assert round(paper.tilt_kgm2, 2) == 1.15
    # the formula as printed does not give the printed figure, 26.868 cut to 26.86
    assert round(paper.heave_formula_kg, 2) == 17.78
    assert paper.heave_figure_kg == pytest.approx(26.86, abs=0.01)
    # its two coefficients of a square of side 2a are those of a plane section, not of a plate
    square = rectangle_section(2.0, 2.0, 1.0)
    assert (round(square.sway_kgpm, 3), round(square.roll_kgm, 3)) == (4.754, 0.725)


def test_potapov_galyaev_plate_inertia_is_far_above_that_of_a_plate() -> None:
    """A disc of the plate's area has 18 times less: the printed 3.7 pi / 32 is not a plate's."""
    side = 0.33
    _, disc = disc_added_mass(side / math.sqrt(math.pi), 1000.0)
    assert 3.7 * math.pi / 32 * 1000 * side**5 / disc == pytest.approx(17.9, abs=0.1)


def test_a_sheet_is_no_rectangle() -> None:
    with pytest.raises(CannotComputeError, match="ratio of less than 1000"):
        rectangle_section(1.0, 1e-4, 1000.0)
