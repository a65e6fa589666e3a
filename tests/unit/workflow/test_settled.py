"""The engine is left out only when nothing that it looks at has changed."""

from pathlib import Path
from typing import Any

import pytest

from pipeline.plan import VehicleFolder
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.settled import is_settled, keep, state_digest

BOAT = VehicleFolder("boat", "raw/boat")
CONFIG: dict[str, Any] = {"vehicles": {"boat": "raw/boat"}, "others": ["ship"], "pool": {}}
FILES = (
    "raw/boat/vehicle.yaml",
    "raw/boat/mooring/bollard.csv",
    "processed/boat/static.json",
    "processed/boat/tables.json",
    "processed/ship/vehicle_page.json",
    "reports/index.html",
    "reports/boat/index.html",
)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    for name in FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("as it was")
    return tmp_path


def state(place: Path, config: dict[str, Any] | None = None) -> str:
    return state_digest(config or CONFIG, [BOAT], place, KnownFiles())


def test_same_state_is_settled_and_a_lost_or_broken_memory_is_not(place: Path) -> None:
    memory = place / "settled"
    assert not is_settled(memory, state(place))
    keep(memory, state(place))
    assert is_settled(memory, state(place))
    memory.write_bytes(b"\xff\xfe")
    assert not is_settled(memory, state(place))


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("gone", [False, True])
def test_every_file_counts(place: Path, name: str, gone: bool) -> None:
    before = state(place)
    if gone:
        (place / name).unlink()
    else:
        (place / name).write_text("as it is")
    assert state(place) != before


@pytest.mark.parametrize("name", ["new.csv", "n<e>w.csv", "n{e}w.csv"])
def test_new_raw_file_counts_even_one_that_cannot_be_read(place: Path, name: str) -> None:
    before = state(place)
    (place / "raw/boat/mooring" / name).write_text("1,2\n")
    assert state(place) != before


def test_what_the_engine_is_told_counts(place: Path) -> None:
    assert state(place, {**CONFIG, "others": []}) != state(place)


def test_code_of_every_stage_counts(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = state(place)
    asked: list[str] = []

    def changed(module: str) -> str:
        asked.append(module.rpartition(".")[2])
        return "other"

    monkeypatch.setattr("pipeline.workflow.settled.code_digest", changed)
    assert state(place) != before
    assert {"load_test", "static", "firmware", "tables", "vehicle_page", "index_page"} <= set(asked)
