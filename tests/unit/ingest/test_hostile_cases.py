"""Files that a reader did not withstand."""

from pathlib import Path

import pytest

from pipeline.errors import InputError
from pipeline.ingest.workbook import read_sheets
from pipeline.vehicle.load import load_vehicle

CASES = Path(__file__).parents[2] / "cases" / "hostile"


def test_cells_behind_a_part_that_does_not_begin_as_xml() -> None:
    with pytest.raises(InputError, match=r"scan_bypass_x\.xlsx.*sheet1\.xml.*not begin as XML"):
        read_sheets(CASES / "scan_bypass_x.xlsx", "scan_bypass_x.xlsx")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("vehicle_rate_1e9.yaml", r"row 217: sensors\.command_rate_hz is 1000000000\.0"),
        ("vehicle_del_char.yaml", "row 2: control character 0x7f"),
    ],
)
def test_vehicle_files_are_refused_by_name(name: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        load_vehicle(CASES / name)
