"""Results of a whole vehicle and its page, made once."""

import pytest
import synthetic_records
from markupsafe import Markup

from pipeline.report import plotting
from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_page


@pytest.fixture(scope="session")
def results() -> VehicleResults:
    return synthetic_records.full_results()


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures out where a test is about words."""

    def frame(_: object, alt: str) -> Markup:
        return Markup('<svg class="plot" aria-label="{}"></svg>').format(alt)

    monkeypatch.setattr(plotting.Canvas, "finish", frame)


@pytest.fixture(scope="session")
def page(results: VehicleResults) -> str:
    return vehicle_page(results)
