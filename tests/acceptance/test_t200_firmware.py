"""What the maker of the T200 measured at 16 V comes out of the exported C code, both signs."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from pipeline.export.allocator_layout import allocator_layout
from pipeline.export.c_source import voltage_tables
from pipeline.export.firmware import write_firmware
from pipeline.identify.cubic_inverse import points_for_tables
from pipeline.identify.inverse import inverse_characteristic
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.records.fits import InverseCharacteristic
from pipeline.records.measurements import MooringRecord
from pipeline.simulate.context import BenchModel
from pipeline.simulate.pack_thrusters import family_table
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.schema import Vehicle

Measured = tuple[Vehicle, MooringRecord, InverseCharacteristic]


@pytest.fixture(scope="module")
def measured(t200_workbook: Path) -> Measured:
    folder = t200_workbook.parents[1]
    vehicle = load_vehicle(folder)
    record = read_mooring_tables([t200_workbook], vehicle, folder.parent)
    return vehicle, record, inverse_characteristic(None, record, vehicle)


def test_c_gives_the_measured_thrust_and_code(measured: Measured, tmp_path: Path) -> None:
    """At 16 V within 0.5 N and, beyond 1 N, 2 codes of 400; at five others within 0.62 N."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    vehicle, record, inverse = measured
    firmware = inverse.firmware
    assert firmware is not None
    write_firmware(
        "t200", firmware, tables_digest="16v", tool_version="0", folder=tmp_path, tables=None,
        layout=allocator_layout(vehicle, firmware), voltages=voltage_tables(inverse),
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
    thrust_at, code_at = (
        getattr(functions, f"t200_{name}_at_f32")
        for name in ("thrust_from_code", "code_from_thrust")
    )
    for function, result, first in (
        (thrust_of, ctypes.c_float, ctypes.c_int16),
        (thrust_at, ctypes.c_float, ctypes.c_int16),
        (code_of, ctypes.c_int16, ctypes.c_float),
        (code_at, ctypes.c_int16, ctypes.c_float),
    ):
        more = [ctypes.c_float] * (2 if function in (thrust_at, code_at) else 1)
        function.restype, function.argtypes = result, [first, *more]
    seen = set()
    for point in record.points:
        code, volts = round(point.code), point.voltage_v
        assert volts is not None
        assert thrust_at(code, 0.0, volts) == pytest.approx(point.thrust_n, abs=0.62)
        seen.add((volts, np.sign(point.thrust_n)))
        if volts == 16.0:
            assert thrust_of(code, 0.0) == pytest.approx(point.thrust_n, abs=0.5)
            if abs(point.thrust_n) > 1.0:
                assert abs(code_of(point.thrust_n, 0.0) - code) <= 2
                assert code_of(point.thrust_n, 0.0) == code_at(point.thrust_n, 0.0, volts)
    assert {(v, s) for v, s in seen if s} == {(v, s) for v in range(10, 21, 2) for s in (-1, 1)}
    pulse = functions.t200_pulse_us_from_code
    pulse.restype, pulse.argtypes = ctypes.c_uint16, [ctypes.c_int16]
    assert [pulse(code) for code in (-400, 0, 1, 400)] == [1100, 1500, 1501, 1900]


@pytest.mark.parametrize(("left_out_v", "rms_n"), [(14.0, 0.3), (16.0, 0.7)])
def test_a_voltage_that_was_left_out_lies_within_its_interval(
    measured: Measured, left_out_v: float, rms_n: float
) -> None:
    """Told by its neighbours, no worse than by a straight line through thrust at equal code."""
    vehicle, record, _ = measured
    rest = record.model_copy(
        update={"points": tuple(p for p in record.points if p.voltage_v != left_out_v)}
    )
    tables = vehicle.tables.model_copy(update={"supply_voltage_v": left_out_v})
    told = inverse_characteristic(None, rest, vehicle.model_copy(update={"tables": tables}))
    assert told.family is not None
    assert told.firmware is not None
    assert told.firmware.supply_voltage_v == left_out_v
    for side in (told.family.positive, told.family.negative):
        held = [
            p
            for p in record.points
            if p.voltage_v == left_out_v and p.code * side.sign > 0 and abs(p.thrust_n) > 0.5
        ]
        code = np.array([abs(p.code) for p in held])
        thrust = np.array([side.sign * p.thrust_n for p in held])
        off = np.interp(code, side.code, side.thrust_n[0]) - thrust
        half = np.interp(code, side.code, side.half95_n[0])
        beside = [
            {p.code: abs(p.thrust_n) for p in record.points if p.voltage_v == left_out_v + step}
            for step in (-2.0, 2.0)
        ]
        straight = np.array([(beside[0][p.code] + beside[1][p.code]) / 2 for p in held]) - thrust
        assert np.sqrt(np.mean(off**2)) < min(rms_n, 1.06 * np.sqrt(np.mean(straight**2)))
        assert np.mean(np.abs(off) <= half) > 0.94
        assert half.mean() < 1.1


def test_a_measured_table_flies_without_open_water(measured: Measured) -> None:
    vehicle, record, inverse = measured
    points, bench = points_for_tables(record, vehicle), BenchModel(None, family=inverse.family)
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
