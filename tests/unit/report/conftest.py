"""Results of a whole vehicle and its page, made once."""

import pytest
import synthetic_records

from pipeline.report.results import VehicleResults
from pipeline.report.vehicle_page import vehicle_page


@pytest.fixture(scope="session")
def results() -> VehicleResults:
    return synthetic_records.full_results()


@pytest.fixture(scope="session")
def page(results: VehicleResults) -> str:
    return vehicle_page(results)
