"""The allocator's error map speaks of demands that can be met, and greys out the others."""

import dataclasses

import numpy as np
import pytest
import synthetic_records

from pipeline.records.allocation import AllocationMap
from pipeline.report.figures.allocation import error_map_figure, within_reach
from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_page

pytestmark = pytest.mark.usefixtures("undrawn")


def clipped() -> AllocationMap:
    """The map of a thruster that gives less at speed: 94 N at rest, 56 N at 2 m/s."""
    return synthetic_records.allocation().model_copy(
        update={
            "speed_mps": (0.0, 2.0),
            "surge_demand_n": (-94.0, 0.0, 50.0, 94.0),
            "surge_error_mooring": ((0.0, 0.0, 1.0, 2.0), (0.5, 0.0, -44.0, -54.0)),
            "surge_error_compensated": ((0.0, 0.0, 0.01, 0.02), (0.1, 0.0, 0.01, 7.0)),
            "surge_reach_n": (94.0, 56.0),
            "yaw_demand_nm": (-10.0, 0.0, 10.0),
            "yaw_error_mooring": ((0.1, 0.0, 0.1), (4.0, 0.0, 4.0)),
            "yaw_error_compensated": ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
            "yaw_reach_nm": (10.0, 6.0),
        }
    )


def test_the_worst_miss_is_that_of_a_demand_within_reach() -> None:
    lead = error_map_figure(clipped()).lead
    assert "Asked for 50 N of surge at 2 m/s, which is within reach" in lead
    assert "misses by 44.0 N" in lead
    assert lead.endswith("the largest miss within reach is 0.10 N.")


def test_reverse_and_both_turns_have_their_own_reach() -> None:
    surge, yaw = within_reach(clipped())
    assert surge.tolist() == [[True, True, True, True], [True, True, True, False]]
    assert yaw.tolist() == [[True, True, True], [False, True, False]]


def test_in_the_printed_form_a_demand_may_be_the_whole_of_the_range() -> None:
    scaled = clipped().model_copy(update={"form": "scaled"})
    surge, _ = within_reach(scaled)
    assert surge[1].tolist() == [True, True, True, False]  # 56 / 0.6 is 93.3 N
    assert surge[0].all()


def test_a_record_without_reach_is_drawn_whole() -> None:
    surge, yaw = within_reach(
        clipped().model_copy(update={"surge_reach_n": (), "yaw_reach_nm": ()})
    )
    assert np.all(surge)
    assert np.all(yaw)


def test_the_caption_explains_the_grey(results: VehicleResults) -> None:
    page = vehicle_page(dataclasses.replace(results, allocation=clipped()))
    assert "grey: beyond what the thrusters can give" in page
