"""The bands drawn and the intervals printed have the quantile of the sweeps behind them."""

import dataclasses

import numpy as np
import pytest
from markupsafe import Markup

from pipeline.records.fits import DriveFit, StaticCharacteristic
from pipeline.records.intervals import drive_factor, static_factor, student_95
from pipeline.report import plotting
from pipeline.report.blocks import Details, Paragraph, Table
from pipeline.report.curves import drive_torque
from pipeline.report.figures.drive import family_figure as drive_figure
from pipeline.report.figures.drive import fitted_points
from pipeline.report.figures.static import family_figure as static_figure
from pipeline.report.numbers import with_interval
from pipeline.report.results import VehicleResults
from pipeline.report.sections.drive import drive_section
from pipeline.report.sections.gap import code_gaps
from pipeline.report.sections.uncertainty import uncertainty_section


@pytest.fixture
def bands(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Largest height of every band that is drawn, in the order of drawing."""
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    heights: list[float] = []

    def fill(_: Axes, _x: object, low: object, high: object, **_more: object) -> None:
        heights.append(float(np.max(np.asarray(high) - np.asarray(low))))

    def draw(_name: str, _alt: str, paint: object, **_: object) -> Markup:
        assert callable(paint)
        paint(Figure())
        return Markup("")

    monkeypatch.setattr(Axes, "fill_between", fill)
    monkeypatch.setattr(plotting, "draw", draw)
    return heights


@pytest.fixture
def few(results: VehicleResults) -> DriveFit:
    """The drive as if of three sweeps: Student's t is 4.3 and not 2.07."""
    assert results.drive is not None
    few = results.drive.model_copy(update={"clusters": 3})
    assert drive_factor(few) == pytest.approx(4.3027, abs=1e-4)
    return few


@pytest.fixture
def tableless(results: VehicleResults) -> StaticCharacteristic:
    """The family of a bench of which no speed has codes enough for Table 2."""
    assert results.static is not None
    return results.static.model_copy(update={"table2": ()})


def test_bands_of_the_drive(bands: list[float], few: DriveFit) -> None:
    drive_figure(few, [], [])
    assert len(bands) == len(few.codes)
    for spread, height in zip(few.codes, bands, strict=True):
        std = drive_torque(few, np.linspace(*spread.shaft_speed_rpm, 60), spread.code)[1]
        assert height == pytest.approx(2 * student_95(2) * std.max())


def test_bands_of_the_family(
    bands: list[float], results: VehicleResults, few: DriveFit, tableless: StaticCharacteristic
) -> None:
    assert results.static is not None
    three = dataclasses.replace(results, drive=few)
    static_figure(three, results.static, None)
    own, bands[:] = list(bands), []
    static_figure(three, tableless, None)
    assert own
    ratio = student_95(2) / static_factor(results.static)
    assert bands == pytest.approx([ratio * height for height in own])


@pytest.mark.usefixtures("undrawn")
def test_coefficients_of_the_drive(results: VehicleResults, few: DriveFit) -> None:
    section = drive_section(dataclasses.replace(results, drive=few))
    (table,) = (
        block.blocks[0]
        for block in section.blocks
        if isinstance(block, Details) and block.summary == "Coefficients of the surface"
    )
    assert isinstance(table, Table)
    half = student_95(2) * np.sqrt(np.diag(np.asarray(few.covariance)))
    expected = [
        with_interval(value, (value - one, value + one))
        for value, one in zip(few.coefficients, half.tolist(), strict=True)
    ]
    assert [row[1:] for row in table.rows] == expected


@pytest.mark.usefixtures("undrawn")
def test_intervals_of_the_thrust(
    results: VehicleResults, few: DriveFit, tableless: StaticCharacteristic
) -> None:
    row = tableless.speed_mps.index(0.0)
    three = dataclasses.replace(results, drive=few, static=tableless)
    (table,) = (one for one in uncertainty_section(three).blocks if isinstance(one, Table))
    half = student_95(2) * tableless.thrust_std_n[row][-1]
    assert float(table.rows[-1][1].rpartition("± ")[2]) == pytest.approx(half, rel=0.06)
    assert results.mooring is not None
    wide, narrow = (
        code_gaps(results.mooring.points, tableless, drive)[-1].half_width_n
        for drive in (few, None)
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
        if isinstance(block, Paragraph) and "clustered by sweep" in block.text
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
