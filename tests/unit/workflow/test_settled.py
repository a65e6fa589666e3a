"""The index is made anew where a page that it leads to has changed, and only there."""

from pathlib import Path

import pytest

from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.vehicle_places import index_digest

FILES = (
    "processed/boat/vehicle_page.json",
    "processed/ship/vehicle_page.json",
    "reports/index.html",
)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    for name in FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("as it was")
    return tmp_path


def state(place: Path, others: tuple[str, ...] = ("ship",)) -> str:
    return index_digest(["boat"], others, place)


def test_same_state_is_settled_and_a_lost_or_broken_memory_is_not(place: Path) -> None:
    memory = place / "known_files.json"
    assert KnownFiles.load(memory).settled != state(place)
    KnownFiles(settled=state(place)).save(memory)
    assert KnownFiles.load(memory).settled == state(place)
    memory.write_bytes(b"\xff\xfe")
    assert KnownFiles.load(memory).settled != state(place)


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("gone", [False, True])
def test_every_file_counts(place: Path, name: str, gone: bool) -> None:
    before = state(place)
    if gone:
        (place / name).unlink()
    else:
        (place / name).write_text("as it is")
    assert state(place) != before


def test_the_vehicles_and_the_code_count(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = state(place)
    assert state(place, ()) != before
    monkeypatch.setattr("pipeline.workflow.vehicle_places.code_digest", lambda _: "other")
    assert state(place) != before
