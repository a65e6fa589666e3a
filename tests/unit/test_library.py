"""Bench files and tables as pandas frames."""

from pathlib import Path

import numpy as np
import pytest

import pipeline
from pipeline.errors import InputError
from pipeline.plan import UsageError
from pipeline.provenance import tables_text
from pipeline.vehicle.schema import Vehicle


@pytest.fixture(scope="module")
def vehicle(repository: Path) -> Vehicle:
    return pipeline.load_vehicle("mmt300", raw=repository / "raw")


def test_a_mooring_table_has_a_row_for_each_point(repository: Path, vehicle: Vehicle) -> None:
    path = repository / "raw/mmt300/mooring/bollard-01.xlsx"
    frame = pipeline.read_bench(path, vehicle)
    assert set(frame["file"]) == {"bollard-01.xlsx"}
    assert frame.attrs["record"].points[5].thrust_n == frame.loc[5, "thrust_n"]
    full = frame[(frame["code"] == frame["code"].max()) & (frame["marks"] == "")]
    # the paper's Table 3: thrust at rest and code 127
    assert full["thrust_n"].mean() == pytest.approx(42.5, abs=1.0)


def test_the_small_example_of_the_guide_is_read_whole(repository: Path) -> None:
    small = pipeline.load_vehicle("small", raw=repository / "docs/examples")
    for file, points in (("load_test/drive", 20), ("mooring/bollard", 16), ("open_water/screw", 8)):
        frame = pipeline.read_bench(repository / f"docs/examples/small/{file}.csv", small)
        assert len(frame) == points
        assert set(frame["marks"]) <= {"", "zero reading"}


def test_the_kind_of_a_file_outside_its_folder_is_asked_for(
    repository: Path, vehicle: Vehicle, tmp_path: Path
) -> None:
    path = tmp_path / "screw-01.csv"
    path.write_bytes((repository / "raw/mmt300/open_water/screw-01.csv").read_bytes())
    with pytest.raises(InputError, match="does not tell what was tested"):
        pipeline.read_bench(path, vehicle)
    frame = pipeline.read_bench(path, vehicle, kind="open_water")
    assert frame["advance_ratio"].is_monotonic_increasing


def test_a_file_without_a_point_is_refused(vehicle: Vehicle, tmp_path: Path) -> None:
    path = tmp_path / "notes.csv"
    path.write_text("tested,by\nMay,Ann\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"notes\.csv"):
        pipeline.read_bench(path, vehicle, kind="mooring")


def test_tables_are_frames_with_the_papers_columns(tmp_path: Path) -> None:
    folder = tmp_path / "processed/any"
    folder.mkdir(parents=True)
    body = {
        "vehicle": "any",
        "table1": {"KT": [0.139, -0.155, -0.061], "KM": [0.016, -0.01, -0.012], "ci95": {}},
        "table2": {"speed_mps": [0.0, 0.5], "KF0": [1.0, 2.0], "KF1": [0.1, 0.2]},
        "table3": None,
        "table4": None,
    }
    (folder / "tables.json").write_text(tables_text(body, inputs={}, code="x"), encoding="utf-8")
    tables = pipeline.thruster_tables("any", out=tmp_path)
    assert list(tables) == ["table1", "table2"]
    assert tables["table2"].loc[1, "KF0"] == 2.0
    np.testing.assert_array_equal(tables["table1"]["KT"], [0.139, -0.155, -0.061])


def test_a_vehicle_that_is_not_there_is_named() -> None:
    with pytest.raises(UsageError, match="rov9"):
        pipeline.load_vehicle("rov9")


def test_what_is_not_offered_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="read_everything"):
        _ = pipeline.read_everything  # type: ignore[attr-defined]
