"""Published tables that have no speed in common with ours are not said to agree."""

import dataclasses

import pytest

from pipeline.report.blocks import Section, Table, Text
from pipeline.report.results import VehicleResults
from pipeline.report.sections.allocation import allocation_section
from pipeline.report.sections.inverse import inverse_section
from pipeline.report.sections.static import static_section


def shifted(results: VehicleResults) -> VehicleResults:
    """The published speeds 0.25 m/s higher: between ours."""
    published = results.vehicle.published
    assert published is not None
    moved = {
        name: one.model_copy(update={"speed_mps": tuple(v + 0.25 for v in one.speed_mps)})
        for name in ("table2", "table4")
        if (one := getattr(published, name)) is not None
    }
    assert len(moved) == 2
    vehicle = results.vehicle.model_copy(update={"published": published.model_copy(update=moved)})
    return dataclasses.replace(results, vehicle=vehicle)


def sentences(section: Section) -> list[str]:
    return [one.text for one in section.blocks if isinstance(one, Text)]


@pytest.mark.usefixtures("undrawn")
def test_table_4_is_compared_at_speeds_in_common_alone(results: VehicleResults) -> None:
    both = inverse_section(results)
    assert any(text.startswith("Our Table 4 differs") for text in sentences(both))
    apart = inverse_section(shifted(results))
    assert "The published Table 4 has no speed in common with ours." in sentences(apart)
    assert not any(text.startswith("Our Table 4") for text in sentences(apart))


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("section", [inverse_section, static_section])
def test_none_of_no_coefficients_is_not_said(results: VehicleResults, section) -> None:  # noqa: ANN001
    assert not any("of the 0 published" in text for text in sentences(section(shifted(results))))


@pytest.mark.usefixtures("undrawn")
def test_both_shares_of_the_allocator_are_of_all_demands(results: VehicleResults) -> None:
    (table,) = [
        one
        for one in allocation_section(results).blocks
        if isinstance(one, Table) and one.caption.startswith("Wrench error")
    ]
    assert table.header[-2:] == ("Demands within reach", "Within reach, opposed to motion")
    assert "Both shares are of all demands." in table.note
