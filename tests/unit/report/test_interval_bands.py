"""The bands drawn and the intervals printed have the quantile of the sweeps behind them."""

import dataclasses
from collections.abc import Sequence

import numpy as np
import pytest
from markupsafe import Markup

from pipeline.records.fit_values import (
    code_gaps,
    drive_factor,
    drive_torque,
    static_factor,
    student_95,
)
from pipeline.records.fits import DriveFit
from pipeline.report.blocks import Figure, Text
from pipeline.report.panels import Panel
from pipeline.report.results import VehicleResults
from pipeline.report.sections.drive import drive_section, fitted_points
from pipeline.report.sections.static import _family, static_section


@pytest.fixture
def bands(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Largest height of every band that is drawn, in the order of drawing."""
    heights: list[float] = []

    def figure(name: str, lead: str, caption: str, panels: Sequence[Panel], **_: object) -> Figure:
        drawn = [trace.band for panel in panels for trace in panel.traces]
        heights.extend(float(np.nanmax(one[1] - one[0])) for one in drawn if one is not None)
        return Figure(name, lead, Markup(""), caption)

    for section in ("drive", "static"):
        monkeypatch.setattr(f"pipeline.report.sections.{section}.zoomable_figure", figure)
    return heights


@pytest.fixture
def few(results: VehicleResults) -> DriveFit:
    """The drive as if of three sweeps: Student's t is 4.3 and not 2.07."""
    assert results.drive is not None
    few = results.drive.model_copy(update={"clusters": 3})
    assert drive_factor(few) == pytest.approx(4.3027, abs=1e-4)
    return few


def test_bands_of_the_drive(bands: list[float], results: VehicleResults, few: DriveFit) -> None:
    drive_section(dataclasses.replace(results, drive=few))
    assert len(bands) == len(few.codes)
    for spread, height in zip(few.codes, bands, strict=True):
        std = drive_torque(few, np.linspace(*spread.shaft_speed_rpm, 60), spread.code)[1]
        assert height == pytest.approx(2 * student_95(2) * std.max())


def test_bands_of_the_family(bands: list[float], results: VehicleResults, few: DriveFit) -> None:
    static = results.static
    assert static is not None
    static_section(results)
    own, bands[:] = list(bands), []
    # a bench of which no speed has codes enough for Table 2: the drive's sweeps count
    bare = static.model_copy(update={"table2": ()})
    three = dataclasses.replace(results, drive=few)
    _family(three, bare, None)
    assert own
    ratio = student_95(2) / static_factor(static)
    assert bands == pytest.approx([ratio * height for height in own])
    assert results.mooring is not None
    wide, narrow = (
        code_gaps(results.mooring.points, bare, drive)[-1].half_width_n for drive in (few, None)
    )
    assert wide > narrow


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(("clusters", "warned"), [(20, False), (19, True)])
def test_fewer_than_two_sweeps_a_term_are_warned_of(
    results: VehicleResults, *, clusters: int, warned: bool
) -> None:
    assert results.drive is not None
    assert len(results.drive.coefficients) == 10
    drive = results.drive.model_copy(update={"clusters": clusters})
    (said,) = (
        block
        for block in drive_section(dataclasses.replace(results, drive=drive)).blocks
        if isinstance(block, Text) and "clustered by sweep" in block.text
    )
    assert (said.tone == "warning") is warned
    assert ("the 19 sweeps are fewer than two for each of the 10 terms" in said.text) is warned


def test_readings_at_code_0_are_no_fitted_points(results: VehicleResults) -> None:
    assert results.load_test is not None
    assert results.drive is not None
    fitted, outliers = fitted_points(results.load_test, results.drive)
    assert len(fitted) == results.drive.quality.points
    idle = tuple(point.model_copy(update={"code": 0.0}) for point in results.load_test.points[:30])
    both = results.load_test.model_copy(update={"points": (*results.load_test.points, *idle)})
    assert fitted_points(both, results.drive) == (fitted, outliers)
