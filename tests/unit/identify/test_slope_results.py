"""A slope that no body can have is refused; the others are drawn."""

import json

import pytest
from click.testing import CliRunner

from pipeline.cli import cli
from pipeline.identify.slope_regression import Slope
from pipeline.identify.straight_line import estimate
from pipeline.records.identification import StraightLineIdentification
from pipeline.report.sections.trials import slope_figure

MASS_KG = 100.0


def slope(total_kg: float, std_share: float) -> Slope:
    return Slope(1.0 / total_kg, std_share / abs(total_kg))


@pytest.mark.parametrize("total_kg", [80.0, -150.0])
def test_an_added_mass_below_nothing_is_no_result(total_kg: float) -> None:
    found = estimate("least squares", slope(total_kg, 0.004), MASS_KG, "")
    assert found.ci95_kg is None
    assert "no added mass of any body" in found.refused


@pytest.mark.parametrize(("total_kg", "std_share"), [(112.0, 0.004), (95.0, 0.05)])
def test_what_may_be_positive_stands(total_kg: float, std_share: float) -> None:
    found = estimate("least squares", slope(total_kg, std_share), MASS_KG, "")
    assert not found.refused
    assert found.ci95_kg is not None
    assert found.ci95_kg[0] < total_kg - MASS_KG < found.ci95_kg[1]


def test_the_picture_has_the_points_and_the_slopes_that_stand() -> None:
    plain = estimate("least squares", slope(80.0, 0.004), MASS_KG, "")
    full = estimate("with the omitted terms", slope(112.0, 0.004), MASS_KG, "")
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


def test_the_papers_slope_is_taken_apart_by_a_command() -> None:
    done = CliRunner().invoke(cli, ["design", "slope", "--json"], catch_exceptions=False)
    told = json.loads(done.output)
    shifts = {(one["term"], one["size"]): one["shift_kg"] for one in told["terms"]}
    assert told["published_kg"] == 18.92
    assert abs(shifts["none", "thrust and inertia alone"]) < 0.05
    assert max(abs(shift) for (term, _), shift in shifts.items() if term == "drag") > 3.0
