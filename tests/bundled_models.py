"""The bundled vehicles ready to fly; what mmt300 takes from its bench is computed from raw/."""

from pathlib import Path

import pytest
from shared_runs import once

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.identify.drive import fit_drive
from pipeline.identify.propeller import fit_propeller
from pipeline.identify.static import static_characteristic, thruster_model
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.open_water import read_open_water
from pipeline.records.fits import DriveFit, PropellerFit, StaticCharacteristic
from pipeline.simulate.context import BenchModel
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

NAMES = ("mmt300", "rov8", "cargo_carrier")


def bundled(repository: Path, name: str) -> Vehicle:
    """Read one of the three."""
    return load_vehicle(repository / "raw/mmt300" if name == "mmt300" else bundled_vehicle(name))


def mmt300_bench(repository: Path, factory: pytest.TempPathFactory) -> BenchModel:
    """Fit propeller, drive and static family of mmt300, once for all test processes."""
    vehicle = bundled(repository, "mmt300")

    def build(folder: Path) -> None:
        raw = repository / "raw"
        load_tests = sorted((raw / "mmt300/load_test").glob("*.xlsx"))
        open_water = sorted(p for p in (raw / "mmt300/open_water").iterdir() if p.suffix != ".md")
        drive = fit_drive(read_load_tests(load_tests, vehicle, raw), vehicle)
        propeller = fit_propeller(read_open_water(open_water, vehicle, raw), vehicle)
        static = static_characteristic(propeller, drive, vehicle)
        for stage, record in (("drive", drive), ("propeller", propeller), ("static", static)):
            (folder / f"{stage}.json").write_text(record.model_dump_json(), encoding="utf-8")

    folder = once(factory, "mmt300_fits", build)
    drive = DriveFit.model_validate_json((folder / "drive.json").read_text())
    propeller = PropellerFit.model_validate_json((folder / "propeller.json").read_text())
    static = StaticCharacteristic.model_validate_json((folder / "static.json").read_text())
    fitted = thruster_model(propeller, drive, vehicle)
    return BenchModel(static, fitted.propeller, fitted.surface)
