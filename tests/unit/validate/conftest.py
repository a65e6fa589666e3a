"""mmt300, ready to be flown by everyone."""

from pathlib import Path

import pytest
from bundled_models import bundled, mmt300_bench
from flight_cases import Bench

from pipeline.identify.inverse import inverse_characteristic
from pipeline.simulate.pack import pack_vehicle
from pipeline.validate.closed_loop import ClosedLoop


@pytest.fixture(scope="session")
def mmt300(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Bench:
    vehicle = bundled(repository, "mmt300")
    model = mmt300_bench(repository, tmp_path_factory)
    inverse = inverse_characteristic(model.static, None, vehicle)
    return Bench(vehicle, model, pack_vehicle(vehicle, model), inverse)


@pytest.fixture(scope="session")
def field(mmt300: Bench) -> ClosedLoop:
    return ClosedLoop.of(mmt300.vehicle, mmt300.packed, mmt300.inverse, None)
