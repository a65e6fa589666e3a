"""Which runs are known to be sound."""

import shutil
from pathlib import Path

import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import InputError
from pipeline.inputs import gains as room
from pipeline.inputs.gains import sound_runs
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.vehicle.load import load_vehicle


@pytest.fixture
def one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SimulatedVehicle:
    """A vehicle with an accepted day and five logs that nobody looks into."""
    folder = tmp_path / "raw" / "rov8"
    shutil.copytree(bundled_vehicle("rov8"), folder)
    file = folder / "vehicle.yaml"
    file.write_text(file.read_text() + "\naccepted_days: [2024-05-14]\n")
    pool = folder / "pool"
    pool.mkdir(exist_ok=True)
    for name, notes in {
        "well": "healthy: true",
        "of-the-day": "what: nothing of note",
        "bad-of-the-day": "healthy: false",
        "broken-notes": "healthy: perhaps",
        "other-day": "",
    }.items():
        (pool / f"{name}.mcap").touch()
        (pool / f"{name}.yaml").write_text(notes)
    days = {"of-the-day": "2024-05-14", "bad-of-the-day": "2024-05-14"}
    monkeypatch.setattr(room, "day_of", lambda log: days.get(log.stem, "2024-05-15"))
    return load_simulated(str(folder), tmp_path / "raw", tmp_path)


def test_runs_are_sound_by_their_notes_or_by_their_day(one: SimulatedVehicle) -> None:
    found, refused = sound_runs(one)
    assert {path.stem: why for path, why in found.items()} == {
        "well": "healthy: true in its notes",
        "of-the-day": "2024-05-14 is an accepted day",
    }
    assert len(refused) == 1
    assert refused[0].startswith("broken-notes.mcap is not taken for sound: ")


def test_a_day_that_is_none_is_refused_with_its_place(one: SimulatedVehicle) -> None:
    text = one.file.read_text()
    one.file.write_text(text.replace("[2024-05-14]", "[14.05.2024]"))
    with pytest.raises(InputError, match="accepted_days"):
        load_vehicle(one.file)
