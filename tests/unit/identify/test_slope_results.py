"""A slope that no body can have is refused; the others are drawn."""

import numpy as np
import pytest

from pipeline.identify.straight_line import estimate
from pipeline.records.identification import StraightLineIdentification
from pipeline.report.sections.trials import slope_figure

MASS_KG = 100.0


def slope(total_kg: float, std_share: float) -> tuple[float, np.ndarray]:
    """Slope and the ends of its interval."""
    return 1.0 / total_kg, 1.0 / total_kg + 1.96 * std_share / abs(total_kg) * np.array([-1, 1])


@pytest.mark.parametrize("total_kg", [80.0, -150.0])
def test_an_added_mass_below_nothing_is_no_result(total_kg: float) -> None:
    found = estimate("least squares", *slope(total_kg, 0.004), MASS_KG, "")
    assert found.ci95_kg is None
    assert "no added mass of any body" in found.refused


@pytest.mark.parametrize(("total_kg", "std_share"), [(112.0, 0.004), (95.0, 0.05)])
def test_what_may_be_positive_stands(total_kg: float, std_share: float) -> None:
    found = estimate("least squares", *slope(total_kg, std_share), MASS_KG, "")
    assert not found.refused
    assert found.ci95_kg is not None
    assert found.ci95_kg[0] < total_kg - MASS_KG < found.ci95_kg[1]


def test_the_picture_has_the_points_and_the_slopes_that_stand() -> None:
    plain = estimate("least squares", *slope(80.0, 0.004), MASS_KG, "")
    full = estimate("with the omitted terms", *slope(112.0, 0.004), MASS_KG, "")
    line = StraightLineIdentification(
        vehicle="rov", axis="surge", segments=(), seconds=1.0, smoother="", bandwidth_hz=1.0,
        acceleration_noise_mps2=0.0, thrust_noise_n=0.0, reliability=1.0, dry_mass_kg=MASS_KG,
        plain=(plain,), with_terms=full, terms=(), warnings=(),
        points=tuple((float(x), x / 112.0) for x in range(-5, 6)),
    )  # fmt: skip
    picture = slope_figure(line)
    assert picture.startswith("<svg")
    assert "with the omitted terms" in picture
    assert "least squares" not in picture
