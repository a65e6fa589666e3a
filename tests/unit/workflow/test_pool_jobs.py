"""Runs are shared out over processes, and nothing waits for what it does not need."""

from pathlib import Path

import pytest
from season_cases import finish, make_season

from pipeline.plan import VehicleFolder
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_batches import ALONE_BYTES, MOST_RUNS, batches, mark_file
from pipeline.workflow.pool_jobs import PoolJobs
from pipeline.workflow.pool_plan import RUN_STAGES, plan_pool
from pipeline.workflow.targets import Targets

BOAT = VehicleFolder("boat", "raw/boat")
RUNS = 30
DAYS = ("2026-04-24", "2026-04-25", "2026-04-26")


@pytest.fixture(scope="module")
def season(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("season")
    (root / "raw/boat").mkdir(parents=True)
    (root / "raw/boat/vehicle.yaml").write_text("name: boat\n")
    make_season(root, BOAT, RUNS)
    return root


def jobs(root: Path, workers: int = 2) -> PoolJobs:
    return PoolJobs(plan_pool(BOAT, root, KnownFiles(), workers=workers))


def test_every_stage_of_every_run_is_in_one_batch_and_a_batch_is_of_one_day(season: Path) -> None:
    found = jobs(season)
    work = [one for name in found.by_name for one in found.work_of(name)]
    assert sorted(work) == sorted((stage, run) for stage in RUN_STAGES for run in found.plan.logs)
    for batch in found.by_name.values():
        assert len(batch.runs) <= MOST_RUNS
        assert any(set(batch.runs) <= set(found.plan.days[day]) for day in DAYS)
    assert len(found.by_name) < RUNS


def test_work_of_a_run_keeps_its_order(season: Path) -> None:
    found = jobs(season)
    fly = next(name for name in found.by_name if name.startswith("fly-"))
    first = found.by_name[fly].runs[0]
    assert found.work_of(fly)[:2] == [("run_trial", first), ("run_page", first)]


def test_no_core_is_idle_for_the_sake_of_a_batch() -> None:
    due = {"pool_run": ["a", "b", "c", "d"]}
    days = {"2026-05-04": ["a", "b", "c", "d"]}
    assert [b.runs for b in batches(due, days, {}, 4)] == [("a",), ("b",), ("c",), ("d",)]
    assert [b.runs for b in batches(due, days, {}, 2)] == [("a", "b"), ("c", "d")]
    assert [b.runs for b in batches(due, days, {}, 1)] == [("a", "b", "c", "d")]


def test_large_log_is_alone_and_the_largest_of_a_batch_is_last() -> None:
    due = {"pool_run": ["a", "b", "c"]}
    sizes = {"a": 10, "b": ALONE_BYTES, "c": 5}
    assert [b.runs for b in batches(due, {"day": ["a", "b", "c"]}, sizes, 1)] == [
        ("c", "a"),
        ("b",),
    ]


def test_page_of_a_day_waits_for_the_batches_of_that_day_alone(season: Path) -> None:
    found = jobs(season)
    marks = [
        file
        for file in found.waits_for("trial_page", DAYS[1], BOAT.vehicle_file)
        if file.endswith(".done")
    ]
    own = set(found.plan.days[DAYS[1]])
    assert sorted(marks) == sorted(
        mark_file("boat", name)
        for name, batch in found.by_name.items()
        if name.startswith(("fly-", "diagnose-")) and own & set(batch.runs)
    )


def test_reading_waits_for_nothing_but_the_vehicle_and_flying_for_reading(season: Path) -> None:
    found = jobs(season)
    read = next(name for name in found.by_name if name.startswith("read-"))
    assert found.batch_waits_for(read, BOAT.vehicle_file) == [BOAT.vehicle_file]
    fly = f"fly-{found.by_name[read].runs[0]}"
    waits = found.batch_waits_for(fly, BOAT.vehicle_file)
    assert mark_file("boat", read) in waits
    assert "processed/boat/static.json" in waits
    assert mark_file("boat", fly) not in waits


def test_only_what_is_due_is_in_a_batch(season: Path, tmp_path: Path) -> None:
    import shutil

    root = tmp_path / "season"
    shutil.copytree(season, root)
    finish(root, BOAT)
    assert jobs(root).targets() == []
    (root / "reports/boat/runs/run-0003.html").unlink()
    found = jobs(root)
    assert {name: found.work_of(name) for name in found.by_name} == {
        "fly-run-0003": [("run_page", "run-0003")]
    }
    assert found.stages_beyond_jobs() == 0


def test_only_the_wanted_stages_are_asked_for() -> None:
    config = {"vehicles": {"boat": "raw/boat"}, "only": ["validation"]}
    assert Targets.from_config(config).all_files() == ["processed/boat/validation.json"]


def test_marks_of_an_earlier_execution_are_removed(season: Path) -> None:
    found = jobs(season)
    mark = season / found.targets()[0]
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.write_text("done\n")
    found.remove_marks(season)
    assert not mark.exists()
