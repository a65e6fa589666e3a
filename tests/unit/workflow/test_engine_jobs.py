"""Stages and runs are shared out over processes, and nothing waits for what it does not need."""

import json
import shutil
from pathlib import Path

import pytest
from season_cases import finish, make_season

from pipeline.plan import VehicleFolder
from pipeline.workflow.engine_jobs import FOLDER, Due, EngineJob, engine_jobs, hand_over, waits
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_plan import (
    ALONE_BYTES,
    MOST_RUNS,
    RUN_STAGES,
    PoolPlan,
    batches,
    plan_pool,
)

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


def plan_of(root: Path) -> PoolPlan:
    return plan_pool(BOAT, root, KnownFiles(), workers=2)


def jobs(root: Path, stages: tuple[str, ...] = ("vehicle_page",)) -> dict[str, EngineJob]:
    found = engine_jobs([Due(BOAT, stages, plan_of(root))], root, 2, ())
    return {job.name: job for job in found}


def work_of(job: EngineJob) -> list[tuple[str, str]]:
    return [(step.stage, step.item) for step in job.steps]


def test_every_stage_of_every_run_is_in_one_job_and_a_job_is_of_one_day(season: Path) -> None:
    plan, found = plan_of(season), jobs(season)
    work = [one for job in found.values() for one in work_of(job) if one[0] in RUN_STAGES]
    assert sorted(work) == sorted((stage, run) for stage in RUN_STAGES for run in plan.logs)
    for job in found.values():
        runs = {step.item for step in job.steps if step.stage in RUN_STAGES}
        assert len(runs) <= MOST_RUNS
        assert not runs or any(runs <= set(plan.days[day]) for day in DAYS)
    assert len(found) < RUNS


def test_few_steps_that_wait_for_each_other_share_a_process(season: Path) -> None:
    due = [Due(VehicleFolder(name, f"raw/{name}"), ("vehicle_page",)) for name in "ab"]
    (chain,) = engine_jobs(due[:1], Path(), 2, ())
    assert [step.stage for step in chain.steps] == ["vehicle_page", "index_page"]
    (alone,) = engine_jobs(due, Path(), 1, ())
    assert [step.vehicle for step in alone.steps] == ["a", "b", ""]
    assert len(engine_jobs(due, Path(), 2, ())) == 3
    # a season tells the engine now and then what is done
    assert len(engine_jobs([Due(BOAT, (), plan_of(season))], season, 1, ())) > RUNS / MOST_RUNS


def test_work_of_a_run_keeps_its_order(season: Path) -> None:
    fly = next(job for name, job in jobs(season).items() if name.startswith("boat/fly-"))
    first = fly.steps[0].item
    assert work_of(fly)[:2] == [("run_trial", first), ("run_page", first)]
    # the pages of all runs come before the first diagnosis, which takes longer
    stages = [stage for stage, _ in work_of(fly)]
    runs = len(stages) // 3
    assert stages == [*["run_trial", "run_page"] * runs, *["run_diagnosis"] * runs]


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


def test_page_of_a_day_waits_for_the_runs_of_that_day_alone(season: Path) -> None:
    plan, found = plan_of(season), jobs(season)
    waited = waits([*found.values()])[f"boat/trial_page-{DAYS[1]}"]
    own = set(plan.days[DAYS[1]])
    of_runs = [name for name in waited if name.startswith("boat/fly-")]
    assert sorted(of_runs) == sorted(
        name
        for name, job in found.items()
        if name.startswith("boat/fly-") and own & {s.item for s in job.steps}
    )


def test_reading_waits_for_nothing_and_flying_for_reading_and_the_bench(season: Path) -> None:
    found = jobs(season, ("drive", "static", "inverse", "vehicle_page"))
    assert work_of(found["boat/bench"]) == [("drive", ""), ("static", "")]
    waited = waits([*found.values()])
    read = next(name for name in found if name.startswith("boat/read-"))
    assert waited[read] == []
    fly = read.replace("read-", "fly-")
    assert waited[fly] == ["boat/bench", read]
    assert waited["boat/tables"] == ["boat/bench"]
    assert {f"boat/trial_page-{day}" for day in DAYS} < set(waited["boat/page"])
    assert waited["index/page"] == ["boat/page"]


def test_vehicles_without_runs_share_a_process_and_no_core_is_idle_for_it() -> None:
    due = [Due(VehicleFolder(name, f"raw/{name}"), ("static", "inverse")) for name in "abcde"]
    found = engine_jobs(due, Path(), 2, ["z"])
    assert [job.name for job in found] == ["a/stages", "d/stages", "index/page"]
    assert [(step.vehicle, step.stage) for step in found[1].steps] == [
        ("d", "static"), ("d", "inverse"), ("e", "static"), ("e", "inverse"),
    ]  # fmt: skip
    assert found[2].steps[0].inputs[-1] == "processed/z/vehicle_page.json"
    assert len(engine_jobs(due, Path(), 100, None)) == 5
    assert engine_jobs([Due(BOAT, ())], Path(), 2, None) == ()


def test_only_what_is_due_is_in_a_job(season: Path, tmp_path: Path) -> None:
    root = tmp_path / "season"
    shutil.copytree(season, root)
    finish(root, BOAT)
    assert [*jobs(root, ())] == ["index/page"]
    (root / "reports/boat/runs/run-0003.html").unlink()
    found = jobs(root)
    work = work_of(found["boat/fly-run-0003"])
    assert [one for one in work if one[0] in RUN_STAGES] == [("run_page", "run-0003")]


def test_marks_of_an_earlier_execution_are_forgotten(season: Path) -> None:
    found = [*jobs(season).values()]
    mark = season / FOLDER / f"{found[0].name}.done"
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.write_text("done\n")
    hand_over(found, season)
    assert not mark.exists()
    work = json.loads(mark.with_suffix(".json").read_text())
    assert [one["stage"] for one in work] == [step.stage for step in found[0].steps]
    assert all(one["code"] for one in work)
