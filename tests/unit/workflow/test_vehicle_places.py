"""A vehicle that was deleted leaves the index; one that lies elsewhere does not; namesakes."""

import shutil
from pathlib import Path

import pytest

from pipeline.plan import VehicleFolder, processed_file
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.vehicle_places import forget_gone, taken_over


def vehicle(root: Path, name: str, folder: str) -> VehicleFolder:
    """Write a vehicle with its receipt."""
    (root / folder).mkdir(parents=True)
    (root / folder / "vehicle.yaml").touch()
    receipt = root / processed_file(name, "vehicle_page")
    receipt.parent.mkdir(parents=True, exist_ok=True)
    receipt.touch()
    return VehicleFolder(name, folder)


def test_who_is_deleted_goes_and_who_lies_elsewhere_stays(tmp_path: Path) -> None:
    places: dict[str, str] = {}
    here = vehicle(tmp_path, "here", "raw/here")
    gone = vehicle(tmp_path, "gone", "raw/gone")
    elsewhere = vehicle(tmp_path, "elsewhere", str(tmp_path / "far/elsewhere"))
    assert forget_gone(places, tmp_path, (here, gone, elsewhere)) == ()
    index = tmp_path / "reports/index.html"
    index.parent.mkdir()
    index.touch()
    shutil.rmtree(tmp_path / "raw/gone")
    # an execution of one vehicle only
    assert forget_gone(places, tmp_path, (here,)) == ("gone",)
    left = {path.parent.name for path in tmp_path.glob("processed/*/vehicle_page.json")}
    assert left == {"here", "elsewhere"}
    assert not index.exists()
    assert forget_gone(places, tmp_path, (here,)) == (), "it is told once"


@pytest.mark.parametrize(
    "places", ["", "[1]", '{"../x": "y", "a": 3}', '{"a": ["y"]}', "null", "{" * 5000]
)
def test_a_broken_memory_misses_nobody(tmp_path: Path, places: str) -> None:
    here = vehicle(tmp_path, "here", "raw/here")
    memory = tmp_path / "known_files.json"
    KnownFiles().save(memory)
    memory.write_text(memory.read_text().replace('"places": {}', f'"places": {places}'))
    assert forget_gone(KnownFiles.load(memory).places, tmp_path, (here,)) == ()
    assert (tmp_path / processed_file("here", "vehicle_page")).exists()


def test_a_namesake_in_another_raw_folder_is_told_of(tmp_path: Path) -> None:
    places: dict[str, str] = {}
    first = vehicle(tmp_path, "boat", "raw/boat")
    second = vehicle(tmp_path, "boat", str(tmp_path / "other/boat"))
    assert taken_over(places, tmp_path, (first,)) == ()
    forget_gone(places, tmp_path, (first,))
    assert taken_over(places, tmp_path, (first,)) == ()
    assert taken_over(places, tmp_path, (second,)) == (("boat", "raw/boat"),)
    forget_gone(places, tmp_path, (second,))
    assert taken_over(places, tmp_path, (second,)) == (), "it is told once"


def test_a_folder_that_was_moved_or_is_named_otherwise_is_no_namesake(tmp_path: Path) -> None:
    places: dict[str, str] = {}
    forget_gone(places, tmp_path, (vehicle(tmp_path, "boat", "raw/boat"),))
    (tmp_path / "link").symlink_to(tmp_path / "raw")
    assert taken_over(places, tmp_path, (VehicleFolder("boat", "link/boat"),)) == ()
    (tmp_path / "raw").rename(tmp_path / "season")
    assert taken_over(places, tmp_path, (VehicleFolder("boat", "season/boat"),)) == ()
