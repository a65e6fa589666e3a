"""The gap between the mooring test and the calculation at rest."""

import dataclasses

import pytest

from pipeline.records.fit_values import code_gaps, static_thrust
from pipeline.records.measurements import MooringRecord
from pipeline.report.results import VehicleResults, mooring_points_of_tables
from pipeline.report.sections.static import gap_section


def shifted(record: MooringRecord, static, offset_n: float) -> MooringRecord:  # noqa: ANN001
    """Mooring points that lie `offset_n` above the calculation at every code."""
    points = tuple(
        point.model_copy(
            update={
                "thrust_n": (1 if point.code > 0 else -1)
                * (float(static_thrust(static, 0, abs(point.code))) + offset_n)
            }
        )
        for point in record.points
    )
    return record.model_copy(update={"points": points})


def test_gap_is_found_with_its_sign_for_both_signs_of_thrust(results: VehicleResults) -> None:
    assert results.mooring is not None
    assert results.static is not None
    record = shifted(results.mooring, results.static, 0.75)
    gaps = code_gaps(record.points, results.static)
    assert {gap.code for gap in gaps} == {point.code for point in record.points}
    assert [gap.gap_n for gap in gaps] == pytest.approx([0.75] * len(gaps))


def test_an_agreement_within_the_intervals_is_not_called_a_gap(results: VehicleResults) -> None:
    assert results.mooring is not None
    assert results.static is not None
    record = shifted(results.mooring, results.static, 0.01)
    section = gap_section(dataclasses.replace(results, mooring=record))
    texts = [block.text for block in section.blocks if block.kind == "paragraph"]
    assert texts == [
        "The two routes agree at rest within 0.01 N, inside their 95 % intervals at every code."
    ]


def test_points_with_marks_or_of_another_voltage_do_not_count(results: VehicleResults) -> None:
    assert results.mooring is not None
    assert results.static is not None
    marked = results.mooring.model_copy(
        update={
            "points": tuple(
                point.model_copy(update={"marks": ("duplicate",)}) if point.code < 0 else point
                for point in results.mooring.points
            )
        }
    )
    at_24_v = dataclasses.replace(results, mooring=marked)
    points = mooring_points_of_tables(at_24_v)
    assert points
    assert all(gap.code > 0 for gap in code_gaps(points, results.static))
    tables = results.vehicle.tables.model_copy(update={"supply_voltage_v": 12.0})
    vehicle = results.vehicle.model_copy(update={"tables": tables})
    assert mooring_points_of_tables(dataclasses.replace(at_24_v, vehicle=vehicle)) == ()
