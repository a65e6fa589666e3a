"""The tables of the flights: every column says what it holds."""

from collections.abc import Iterator
from dataclasses import replace

import pytest

from pipeline.records.validation import (
    AllocatorValidation,
    FlightTrace,
    KeepingFlight,
    PortionFlight,
    SettingFlight,
    StepFlight,
    Variant,
)
from pipeline.report.blocks import Block, Details, Table
from pipeline.report.results import VehicleResults
from pipeline.report.sections.allocation import validation_section

VARIANTS: tuple[Variant, ...] = ("ideal", "mooring", "compensated")


def keeping(variant: Variant) -> KeepingFlight:
    return KeepingFlight(
        variant=variant, speed_mps=1.0, reached_mps=0.9, speed_error_mps=0.1, depth_error_m=0.02,
        heading_error_deg=0.3, pitch_error_deg=0.4, wrench_error=(0.1, 0.2, 0.3, 0.4),
        wrench_gain=(0.9, 1.0, None, 1.0), shaft_power_w=90.0,
    )  # fmt: skip


def flown() -> AllocatorValidation:
    compensated = keeping("compensated")
    steps = tuple(
        StepFlight(
            variant=variant, speed_at_mps=1.0, step=step, speed_mps=0.05, depth_m=0.01,
            heading_deg=0.2, pitch_deg=0.6, wrench=(0.1, 0.1, 0.1, 0.1),
        )
        for variant in VARIANTS for step in ("heading", "depth")
    )  # fmt: skip
    portions = PortionFlight(
        surge=0.7, heading=0.3, pitch=0.3, flight=compensated, heading_step_cut_share=0.1,
        heading_step_reached_deg=88.0,
    )  # fmt: skip
    traces = tuple(
        FlightTrace(
            variant=one, time_s=(0.0,), speed_mps=(1.0,), heading_deg=(0.0,), depth_m=(3.0,)
        )
        for one in VARIANTS
    )
    return AllocatorValidation(
        allocator="paper", mooring_inverse="at rest", compensated_inverse="with speed",
        speed_mps=(1.0,), portions=(0.7, 0.3, 0.3), form="table 4", flight_s=60.0,
        control_period_s=0.1, disturbance=(1.0, 1.0, 1.0, 1.0),
        disturbance_period_s=(5.0, 6.0, 7.0, 8.0), range_n_nm=((1.0, 1.0, 1.0, 1.0),),
        heading_step_deg=10.0, depth_step_m=0.5, large_step_deg=90.0,
        keeping=tuple(keeping(variant) for variant in VARIANTS), steps=steps,
        settings=(SettingFlight(setting="no lag", flight=compensated),), settings_at_mps=1.0,
        portions_flown=(portions,), fixed_point=None, traces=traces, traces_at_mps=1.0,
        electrical=None, power_text="Nothing measured.", explanations=(),
    )  # fmt: skip


def tables(blocks: tuple[Block, ...]) -> Iterator[Table]:
    for block in blocks:
        if isinstance(block, Table):
            yield block
        elif isinstance(block, Details):
            yield from tables(block.blocks)


@pytest.mark.usefixtures("undrawn")
def test_no_table_has_two_columns_of_one_name(results: VehicleResults) -> None:
    section = validation_section(replace(results, validation=flown()))
    found = list(tables(section.blocks))
    assert len(found) == 2
    for one in found:
        assert len(set(one.header)) == len(one.header), one.header
