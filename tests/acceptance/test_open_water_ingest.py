"""Measured open-water files that nobody here wrote, with nothing but a vehicle.yaml."""

import csv
import math
import shutil
from pathlib import Path

import pytest

from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import OpenWaterRecord
from pipeline.vehicle.load import load_vehicle, vehicle_notes

HERE = Path(__file__).parent


def read(name: str, data: Path, folder: Path) -> OpenWaterRecord:
    """Read one data file as the file of a vehicle."""
    if not data.is_file():
        pytest.skip(f"no {data}")
    target = folder / "raw" / name
    (target / "open_water").mkdir(parents=True)
    shutil.copy(HERE / name / "vehicle.yaml", target)
    path = Path(shutil.copy(data, target / "open_water"))
    return read_open_water([path], load_vehicle(target), folder / "raw")


@pytest.mark.parametrize("name", ["pptc", "uiuc"])
def test_the_vehicle_files_agree_with_themselves(name: str) -> None:
    assert vehicle_notes(load_vehicle(HERE / name)) == ()


def test_pptc_is_read_and_its_efficiency_agrees(shared_data: Path, tmp_path: Path) -> None:
    data = shared_data / "propeller_open_water/pptc_vp1304/pptc_vp1304_open_water_measured.csv"
    record = read("pptc", data, tmp_path)
    assert record.problems == ()
    assert len(record.points) == 6
    first = record.points[0]
    assert (first.advance_ratio, first.thrust_coefficient) == (0.7985, 0.5052)
    assert first.torque_coefficient == pytest.approx(0.11836)
    assert str(first.source) == f"pptc/open_water/{data.name}, row 2"
    with data.open() as stream:
        stated = [float(row["eta_O"]) for row in csv.DictReader(stream)]
    for point, eta in zip(record.points, stated, strict=True):
        assert point.thrust_coefficient is not None
        assert point.torque_coefficient is not None
        computed = (
            point.advance_ratio
            * point.thrust_coefficient
            / (2.0 * math.pi * point.torque_coefficient)
        )
        assert computed == pytest.approx(eta, abs=6e-4)


def test_uiuc_one_propeller_out_of_63(shared_data: Path, tmp_path: Path) -> None:
    data = shared_data / "propeller_open_water/uiuc_air/volume2_exp.csv"
    record = read("uiuc", data, tmp_path)
    assert {problem.severity for problem in record.problems} == {"note"}
    with data.open() as stream:
        rows = [
            (number, row)
            for number, row in enumerate(csv.DictReader(stream), start=2)
            if row["PropName"] == "apcff 4.2x4.0 - 2"
        ]
    assert len(rows) == 102
    assert [point.source.row for point in record.points] == [number for number, _ in rows]
    for point, (_, row) in zip(record.points, rows, strict=True):
        assert point.advance_ratio == float(row["J"])
        assert point.thrust_coefficient == float(row["CT"])
        assert point.torque_coefficient == pytest.approx(float(row["CP"]) / (2.0 * math.pi))
    assert sum(point.advance_ratio == 0.0 for point in record.points) == 18


def test_uiuc_other_volume_does_not_hold_that_propeller(shared_data: Path, tmp_path: Path) -> None:
    data = shared_data / "propeller_open_water/uiuc_air/volume3_exp.csv"
    record = read("uiuc", data, tmp_path)
    assert record.points == ()
    (problem,) = record.problems
    assert problem.severity == "error"
    assert 'PropName = "apcff 4.2x4.0 - 2"' in problem.what


def test_all_propellers_at_once_are_warned_of(shared_data: Path, tmp_path: Path) -> None:
    data = shared_data / "propeller_open_water/uiuc_air/volume2_exp.csv"
    record = read("pptc", data, tmp_path)
    assert len(record.points) == 5050
    assert any('"PropName" has 63 different texts' in problem.what for problem in record.problems)


def test_a_table_of_regression_coefficients_is_not_taken_for_a_test(
    shared_data: Path, tmp_path: Path
) -> None:
    data = shared_data / "propeller_open_water/wageningen_b_series/wageningen_KT.csv"
    record = read("pptc", data, tmp_path)
    assert record.points == ()
    assert any(problem.severity == "error" for problem in record.problems)
