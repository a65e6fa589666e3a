"""A stage is due where its result does not fit what it was made from, and all that follow it."""

from pathlib import Path

import pytest

from pipeline.plan import VehicleFolder, processed_file
from pipeline.provenance import Envelope, code_digest, file_digest, write_envelope
from pipeline.records.base import Record
from pipeline.stage_table import STAGES, module_of, needed_for, stages_of
from pipeline.workflow.known_files import due_stages, remove_results

BOAT = VehicleFolder("boat", "raw/boat")
#: All but tables.json and what needs it, which are no envelopes of nothing.
LOOKED_AT = needed_for(("validation", "allocation"))


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Results of nothing that are up to date."""
    for kind in ("load_test", "mooring", "open_water"):
        (tmp_path / "raw/boat" / kind).mkdir(parents=True)
        (tmp_path / f"raw/boat/{kind}/a.csv").write_text("1,2\n")
    (tmp_path / "raw/boat/vehicle.yaml").write_text("name: boat\n")
    for stage in stages_of("vehicle"):
        if stage not in LOOKED_AT:
            continue
        inputs = {"raw/boat/vehicle.yaml": file_digest(tmp_path / "raw/boat/vehicle.yaml")}
        for need in STAGES[stage].needs:
            name = processed_file("boat", need)
            inputs[name] = file_digest(tmp_path / name)
        if not STAGES[stage].needs:
            name = f"raw/boat/{stage}/a.csv"
            inputs[name] = file_digest(tmp_path / name)
        code = code_digest(module_of(stage))
        made = Envelope[Record](stage, "boat", inputs, code, None, "not needed")
        write_envelope(tmp_path / processed_file("boat", stage), made)
    return tmp_path


def due(place: Path, **more: bool) -> set[str]:
    return set(due_stages(BOAT, place, LOOKED_AT, **more))


def test_nothing_is_due_where_all_fits_and_all_of_it_by_force(place: Path) -> None:
    assert due(place) == set()
    assert due(place, force=True) == LOOKED_AT


AFTER_DRIVE = {"drive", "static", "inverse", "allocation", "validation"}
ALL_THAT_MOORING_LEADS_TO = {"mooring", "inverse", "allocation", "validation"}


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("raw/boat/mooring/a.csv", ALL_THAT_MOORING_LEADS_TO),
        ("raw/boat/mooring/new.csv", ALL_THAT_MOORING_LEADS_TO),
        ("raw/boat/mooring/{code}.csv", ALL_THAT_MOORING_LEADS_TO),
        ("raw/boat/vehicle.yaml", LOOKED_AT),
        ("processed/boat/drive.json", AFTER_DRIVE),
    ],
)
def test_a_change_makes_due_what_follows_and_no_more(
    place: Path, file: str, expected: set[str]
) -> None:
    (place / file).write_text("otherwise\n")
    assert due(place) == expected


def test_what_is_lost_is_due_and_code_counts(place: Path) -> None:
    (place / "raw/boat/load_test/a.csv").unlink()
    assert due(place) == {"load_test", *AFTER_DRIVE}
    (place / "processed/boat/validation.json").unlink()
    assert "validation" in due(place)
    assert set(due_stages(BOAT, place, LOOKED_AT, lambda _: "other")) == LOOKED_AT


def test_what_is_removed_is_what_is_due(place: Path) -> None:
    pieces = [
        place / "processed/boat/.static.json.x.part",
        place / "reports/.index.html.7.part",
        place / "reports/boat/runs/.a.html.7.part",
    ]
    for piece in pieces:
        piece.parent.mkdir(parents=True, exist_ok=True)
        piece.touch()
    remove_results(BOAT, place, ("static",))
    assert not any(piece.exists() for piece in pieces)
    left = {path.name for path in (place / "processed/boat").iterdir()}
    assert left == {f"{stage}.json" for stage in LOOKED_AT - {"static"}}
