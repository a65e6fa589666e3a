"""What the maker of the T200 measured at 16 V comes out of the exported C code, both signs."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from pipeline.export.allocator_layout import allocator_layout
from pipeline.export.firmware import write_firmware
from pipeline.identify.inverse import inverse_characteristic
from pipeline.identify.mooring_inverse import points_for_tables
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.fits import FirmwareCharacteristic
from pipeline.records.measurements import MooringPoint
from pipeline.simulate.bench_model import BenchModel
from pipeline.simulate.pack_thrusters import family_table
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

VEHICLE = Path(__file__).parent / "t200"

Measured = tuple[Vehicle, tuple[MooringPoint, ...], FirmwareCharacteristic, BenchModel]


@pytest.fixture(scope="module")
def measured(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Measured:
    found = sorted((shared_data / "t200_bollard").glob("*.xlsx"))
    if not found:
        pytest.skip(f"no T200 workbook in {shared_data}")
    folder = tmp_path_factory.mktemp("raw") / "t200"
    (folder / "mooring").mkdir(parents=True)
    shutil.copy(VEHICLE / "vehicle.yaml", folder)
    book = Path(shutil.copy(found[0], folder / "mooring" / "t200.xlsx"))
    vehicle = load_vehicle(folder)
    record = read_mooring_tables([book], vehicle, folder.parent)
    inverse = inverse_characteristic(None, record, vehicle)
    assert inverse.firmware is not None
    points = points_for_tables(record, vehicle)
    return vehicle, points, inverse.firmware, BenchModel(None, family=inverse.family)


def test_c_gives_the_measured_thrust_and_code(measured: Measured, tmp_path: Path) -> None:
    """Within 0.5 N and 2 codes of 400, wherever more than 1 N was measured."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    vehicle, points, firmware, _ = measured
    write_firmware(
        "t200", firmware, tables_digest="16v", tool_version="0", folder=tmp_path, tables=None,
        layout=allocator_layout(vehicle, firmware),
    )  # fmt: skip
    header = (tmp_path / "t200_thruster.h").read_text()
    assert "#define T200_THRUSTER_AT_REST_ONLY (1)" in header
    assert "#define T200_THRUSTER_SUPPLY_MV (16000)" in header
    assert "from t200/mooring/t200.xlsx" in header
    library = tmp_path / "t200.so"
    sources = [str(tmp_path / f"t200_{name}.c") for name in ("thruster", "allocator")]
    command = ["gcc", "-std=c99", "-O2", "-shared", "-fPIC", *sources, "-o", str(library)]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    functions = ctypes.CDLL(str(library))
    thrust_of, code_of = functions.t200_thrust_from_code_f32, functions.t200_code_from_thrust_f32
    thrust_of.restype, thrust_of.argtypes = ctypes.c_float, [ctypes.c_int16, ctypes.c_float]
    code_of.restype, code_of.argtypes = ctypes.c_int16, [ctypes.c_float, ctypes.c_float]
    signs = set()
    for point in points:
        code = round(point.code)
        assert thrust_of(code, 0.0) == pytest.approx(point.thrust_n, abs=0.5)
        if abs(point.thrust_n) > 1.0:
            signs.add(np.sign(point.thrust_n))
            assert abs(code_of(point.thrust_n, 0.0) - code) <= 2
    assert signs == {-1.0, 1.0}
    pulse = functions.t200_pulse_us_from_code
    pulse.restype, pulse.argtypes = ctypes.c_uint16, [ctypes.c_int16]
    assert [pulse(code) for code in (-400, 0, 1, 400)] == [1100, 1500, 1501, 1900]


def test_a_measured_table_flies_without_open_water(measured: Measured) -> None:
    _, points, _, bench = measured
    assert bench.family is not None
    rest, _, step = family_table(bench.family, None)
    assert rest.shape[:2] == (2, 1)
    largest = max(p.thrust_n for p in points)
    assert rest[0].max() == pytest.approx(largest, abs=0.5)
    assert rest[1].max() == pytest.approx(-min(p.thrust_n for p in points), abs=0.5)
    falling, _, _ = family_table(bench.family, 5.0)
    assert falling[0, -1].max() == 0.0
    assert (np.diff(falling, axis=1) <= 0).all()
    assert step * (rest.shape[2] - 1) == pytest.approx(400.0)
