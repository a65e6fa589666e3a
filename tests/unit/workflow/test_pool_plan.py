"""Of a season of runs only what is new, changed or spoilt is to be done."""

import os
import time
from pathlib import Path

import pytest
from season_cases import FIRST_NS, HOUR_NS, finish, make_season, write_log

from pipeline.plan import VehicleFolder
from pipeline.provenance import file_digest
from pipeline.workflow import known_files
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_plan import DAY_STAGES, RUN_STAGES, PoolPlan, plan_pool

BOAT = VehicleFolder("boat", "raw/boat")
RUNS = 30


@pytest.fixture(scope="module")
def _season(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("season")
    (root / "raw/boat").mkdir(parents=True)
    (root / "raw/boat/vehicle.yaml").write_text("name: boat\n")
    make_season(root, BOAT, RUNS)
    finish(root, BOAT)
    return root


@pytest.fixture
def season(_season: Path, tmp_path: Path) -> Path:
    import shutil

    root = tmp_path / "season"
    shutil.copytree(_season, root)
    return root


def plan(root: Path, **more: object) -> PoolPlan:
    return plan_pool(BOAT, root, KnownFiles(), **more)  # type: ignore[arg-type]


def pending_files(found: PoolPlan) -> list[str]:
    """Return all files that are to be made."""
    return [
        file
        for stage, items in found.pending.items()
        for item in items
        for file in found.outputs(stage, item)
    ]


def test_finished_season_has_nothing_to_do(season: Path) -> None:
    found = plan(season)
    assert found.pending == {}
    assert found.stale == ()
    assert len(found.logs) == RUNS
    assert list(found.days) == ["2026-04-24", "2026-04-25", "2026-04-26"]


def test_one_new_run_is_all_there_is_to_do(season: Path) -> None:
    write_log(season / "raw/boat/pool/new.mcap", FIRST_NS + 24 * 30 * HOUR_NS)
    found = plan(season)
    assert {stage: found.pending[stage] for stage in RUN_STAGES} == dict.fromkeys(
        RUN_STAGES, ("new",)
    )
    assert {stage: found.pending[stage] for stage in DAY_STAGES} == dict.fromkeys(
        DAY_STAGES, ("2026-05-24",)
    )
    assert len(pending_files(found)) == 10


def test_run_on_a_known_day_redoes_that_day_and_the_trends_after_it(season: Path) -> None:
    write_log(season / "raw/boat/pool/late.mcap", FIRST_NS + 24 * HOUR_NS)
    found = plan(season)
    assert found.pending["trial_day"] == ("2026-04-25",)
    assert found.pending["trial_page"] == ("2026-04-25", "2026-04-26")
    assert "day_tables" not in found.pending


@pytest.mark.parametrize("ending", [".mcap", ".yaml"])
def test_changed_log_or_notes_redo_the_run(season: Path, ending: str) -> None:
    path = season / f"raw/boat/pool/run-0003{ending}"
    before = path.read_bytes() if path.exists() else b""
    path.write_bytes(before[:-8] + b"x" * 8)
    os.utime(path, (946684800, 946684800))
    found = plan(season)
    assert found.pending["pool_run"] == ("run-0003",)
    assert "processed/boat/pool/run-0003.npz" in found.stale


@pytest.mark.parametrize(
    ("spoilt", "stage"),
    [
        ("processed/boat/pool/run-0002.npz", "pool_run"),
        ("processed/boat/run_trials/run-0002.json", "run_trial"),
        ("reports/boat/runs/run-0002.html", "run_page"),
        ("reports/boat/trials/2026-04-25.html", "trial_page"),
    ],
)
def test_edited_or_half_written_result_is_made_again(season: Path, spoilt: str, stage: str) -> None:
    (season / spoilt).write_text("half")
    assert len(plan(season).pending[stage]) == 1


def test_tables_of_a_past_day_are_history(season: Path) -> None:
    (season / "processed/boat/inverse.json").write_text("{}")
    found = plan(season)
    assert found.pending["day_tables"] == ("2026-04-26",)
    assert found.pending["trial_page"] == ("2026-04-26",)
    forced = plan(season, force=True)
    assert forced.pending["day_tables"] == ("2026-04-26",)
    assert len(forced.pending["pool_run"]) == RUNS


def test_results_of_a_log_that_is_gone_go_too(season: Path) -> None:
    (season / "raw/boat/pool/run-0029.mcap").unlink()
    found = plan(season)
    assert "reports/boat/runs/run-0029.html" in found.stale
    assert "processed/boat/pool/run-0029.npz" in found.stale
    assert found.pending["trial_day"] == ("2026-04-26",)
    assert "pool_run" not in found.pending


def test_half_written_file_of_a_stage_that_was_ended_goes(season: Path) -> None:
    (season / "processed/boat/run_trials/.run-0001.mcap.77.part").write_text("half")
    assert plan(season).stale == ("processed/boat/run_trials/.run-0001.mcap.77.part",)


def test_log_that_is_still_coming_is_left(season: Path) -> None:
    write_log(season / "raw/boat/pool/new.mcap", FIRST_NS)
    assert plan(season, waiting=frozenset({"new.mcap"})).pending == {}


def test_log_without_a_time_is_kept_apart(season: Path) -> None:
    (season / "raw/boat/pool/junk.mcap").write_bytes(b"no log at all")
    found = plan(season)
    assert found.days["undated"] == ("junk",)
    assert found.pending["trial_page"] == ("undated",)


def test_memory_saves_reading_and_is_not_needed(
    season: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(known_files, "_YOUNG_NS", 0)
    read: list[Path] = []

    def counted(path: Path) -> str:
        read.append(path)
        return file_digest(path)

    monkeypatch.setattr(known_files, "file_digest", counted)
    memory = season / "processed/.rig2sea/known_files.json"
    known = KnownFiles.load(memory)
    plan_pool(BOAT, season, known)
    assert len(read) > RUNS
    known.save(memory)
    read.clear()
    assert plan_pool(BOAT, season, KnownFiles.load(memory)).pending == {}
    assert read == []
    log = season / "raw/boat/pool/run-0001.mcap"
    status = log.stat()
    log.write_bytes(log.read_bytes()[:-1] + b"?")
    os.utime(log, ns=(status.st_atime_ns, status.st_mtime_ns))  # same size, same time
    found = plan_pool(BOAT, season, KnownFiles.load(memory))
    assert found.pending["pool_run"] == ("run-0001",)
    memory.write_text("{half")
    assert "run_page" in plan_pool(BOAT, season, KnownFiles.load(memory)).pending


def test_young_file_is_not_trusted_to_stay(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("1")
    known = KnownFiles()
    known.digest(path)
    assert known.digests == {}
    time.sleep(0.15)
    known.digest(path)
    assert len(known.digests) == 1
