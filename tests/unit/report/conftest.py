"""Results of a whole vehicle and its page, made once."""

import pytest
import synthetic_records
from markupsafe import Markup

from pipeline.report import bars, track, zoomable
from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_page


@pytest.fixture(scope="session")
def results() -> VehicleResults:
    return synthetic_records.full_results()


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures out where a test is about words."""

    def frame(_name: str, alt: str, *_: object) -> Markup:
        return Markup('<svg class="plot" aria-label="{}"></svg>').format(alt)

    for room in (bars, track, zoomable):
        monkeypatch.setattr(room, "draw", frame)


@pytest.fixture(scope="session")
def page(results: VehicleResults) -> str:
    return vehicle_page(results)
