"""Where a vehicle lies that was asked for, and what it is called."""

import shutil
from pathlib import Path

import pytest

from pipeline.errors import InputError
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import UsageError


@pytest.fixture
def rov8(repository: Path) -> Path:
    return repository / "pipeline" / "bundled" / "vehicles" / "rov8" / "vehicle.yaml"


@pytest.mark.parametrize("folder", ["001", "2026-11-25 pool", "assets"])
@pytest.mark.parametrize("by_file", [False, True])
def test_a_folder_of_any_name_is_called_what_its_file_says(
    tmp_path: Path, rov8: Path, folder: str, by_file: bool
) -> None:
    place = tmp_path / folder
    place.mkdir()
    shutil.copy(rov8, place)
    asked = place / "vehicle.yaml" if by_file else place
    name, file = find_vehicle(str(asked), tmp_path / "raw", tmp_path)
    assert name == "rov8"
    assert file == place / "vehicle.yaml"


def test_a_folder_with_a_name_of_vehicles_gives_the_name(tmp_path: Path, rov8: Path) -> None:
    place = tmp_path / "my_rov"
    place.mkdir()
    shutil.copy(rov8, place)
    name, file = find_vehicle(str(place), tmp_path / "raw", tmp_path)
    assert name == "my_rov"
    assert file.samefile(place / "vehicle.yaml")


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    place = tmp_path / "001"
    place.mkdir()
    (place / "vehicle.yaml").write_text("name: [", encoding="utf-8")
    with pytest.raises(InputError, match="vehicle"):
        find_vehicle(str(place), tmp_path / "raw", tmp_path)


def test_a_path_without_a_vehicle_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no vehicle"):
        find_vehicle(str(tmp_path / "001"), tmp_path / "raw", tmp_path)
