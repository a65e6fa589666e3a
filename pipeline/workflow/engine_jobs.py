"""What the engine is told: jobs, each a process that takes steps one after the other.

What a small result costs is mostly the start of a process. So the stages of a vehicle share one,
and vehicles that have nothing else to do share it too. To the engine a job is a mark that it is
done; the results are no outputs of it, which it would remove where another step of the job fails.
Whether a result is good is told by its envelope (`known_files`, `pool_plan`).
"""

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from graphlib import TopologicalSorter
from itertools import chain, pairwise
from pathlib import Path

from pipeline.plan import RAW_KINDS, VehicleFolder, processed_file, report_file
from pipeline.provenance import code_digest, write_atomically
from pipeline.stage_table import module_of
from pipeline.workflow.engine import FOLDER
from pipeline.workflow.known_files import stage_inputs
from pipeline.workflow.pool_plan import MOST_RUNS, PHASES, PoolPlan

#: Stages that pool runs wait for; with all that they need they are a job of their own then.
_BEFORE_RUNS = (*RAW_KINDS, "propeller", "drive", "static")
#: Stages of a day: the long one by itself, then what waits for it.
_OF_DAY = (("trial_day",), ("day_diagnosis", "day_tables", "trial_page"))
INDEX = "reports/index.html"
#: Steps that are soon done: with more, what is done is better told to the engine now and then.
_FEW_STEPS = 40


@dataclass(frozen=True)
class Step:
    """One stage of a vehicle, a run or a day, with all files that it reads and writes."""

    vehicle: str
    stage: str
    item: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class EngineJob:
    """Steps that one process takes in this order; `name` is ``<vehicle>/<what>``."""

    name: str
    steps: tuple[Step, ...]


@dataclass(frozen=True)
class Due:
    """What of a vehicle is to be made: stages of its own, and what its plan of pool runs says.

    `types` are its further types of thruster, by the names of their results.
    """

    vehicle: VehicleFolder
    stages: tuple[str, ...]
    plan: PoolPlan | None = None
    types: tuple[str, ...] = ()


def engine_jobs(
    due: Sequence[Due], out: Path, workers: int, others: Sequence[str] | None
) -> tuple[EngineJob, ...]:
    """Share what is due out over processes; jobs without steps are left out.

    Of `workers`, processes that may be at work side by side, none is to be idle for the sake of a
    job. The index also leads to `others`, vehicles that are not part of this execution; None where
    no index is made.
    """
    found: list[EngineJob] = []
    small = [one for one in due if one.stages and not (one.plan and one.plan.pending)]
    most = min(MOST_RUNS, max(1, -(-len(small) // max(workers, 1))))
    for begin in range(0, len(small), most):
        part = small[begin : begin + most]
        steps = [step for one in part for step in _vehicle_steps(one, one.stages, out)]
        found.append(EngineJob(f"{part[0].vehicle.name}/stages", tuple(steps)))
    for one in due:
        if one.plan is not None and one.plan.pending:
            found += _with_runs(one, one.plan, out)
    if others is not None:
        names = (*(one.vehicle.name for one in due), *others)
        receipts = tuple(processed_file(name, "vehicle_page") for name in names)
        found.append(EngineJob("index/page", (Step("", "index_page", "", receipts, (INDEX,)),)))
    return _in_one(tuple(job for job in found if job.steps), workers)


def _in_one(jobs: tuple[EngineJob, ...], workers: int) -> tuple[EngineJob, ...]:
    """Give few steps to one process where no two jobs would be at work side by side."""
    before = waits(jobs)
    order = tuple(TopologicalSorter(before).static_order())
    one_by_one = all(job in before[after] for job, after in pairwise(order))
    few = sum(len(job.steps) for job in jobs) <= _FEW_STEPS
    if len(jobs) < 2 or not few or not (one_by_one or workers == 1):
        return jobs
    steps = {job.name: job.steps for job in jobs}
    together = tuple(chain.from_iterable(steps[name] for name in order))
    return (EngineJob(order[0], together),)


def _with_runs(one: Due, plan: PoolPlan, out: Path) -> Iterator[EngineJob]:
    """Yield the jobs of a vehicle that has pool runs to do: these wait for a part of the bench."""
    name, file = one.vehicle.name, one.vehicle.vehicle_file
    shares = {
        "bench": [stage for stage in one.stages if stage in _BEFORE_RUNS],
        "tables": [s for s in one.stages if s not in (*_BEFORE_RUNS, "vehicle_page")],
        "page": [stage for stage in one.stages if stage == "vehicle_page"],
    }
    for share, stages in shares.items():
        yield EngineJob(f"{name}/{share}", tuple(_vehicle_steps(one, stages, out)))

    def step(stage: str, item: str) -> Step:
        inputs, outputs = plan.inputs(stage, item, file), plan.outputs(stage, item)
        return Step(name, stage, item, tuple(inputs), tuple(outputs))

    def steps(stages: Sequence[str], items: Sequence[str]) -> tuple[Step, ...]:
        due = {stage: frozenset(plan.pending.get(stage, ())) for stage in stages}
        return tuple(step(stage, item) for item in items for stage in stages if item in due[stage])

    for batch in plan.batches:
        groups = [steps(group, batch.runs) for group in PHASES[batch.phase]]
        yield EngineJob(f"{name}/{batch.name}", tuple(chain.from_iterable(groups)))
    for day in plan.days:
        for of_day in _OF_DAY:
            yield EngineJob(f"{name}/{of_day[-1]}-{day}", steps(of_day, (day,)))


def _vehicle_steps(one: Due, stages: Sequence[str], out: Path) -> Iterator[Step]:
    vehicle, name = one.vehicle, one.vehicle.name
    for stage in stages:
        inputs = stage_inputs(vehicle, stage, out, one.types)
        outputs = [processed_file(name, stage)]
        if stage == "vehicle_page":
            inputs += [] if one.plan is None else one.plan.page_receipts()
            outputs.append(report_file(name))
        yield Step(name, stage, "", tuple(inputs), tuple(outputs))


def waits(jobs: Sequence[EngineJob]) -> dict[str, list[str]]:
    """Return the jobs that each waits for: those that make what its steps read."""
    maker = {file: job.name for job in jobs for step in job.steps for file in step.outputs}
    found = {}
    for job in jobs:
        makers = (maker.get(file, job.name) for step in job.steps for file in step.inputs)
        found[job.name] = [name for name in dict.fromkeys(makers) if name != job.name]
    return found


def hand_over(jobs: Sequence[EngineJob], out: Path) -> Mapping[str, list[str]]:
    """Write what each job has to do, and forget the marks of an earlier execution.

    Returns what each job waits for (`waits`), for the engine's configuration.
    """
    code = cache(code_digest)
    shutil.rmtree(out / FOLDER, ignore_errors=True)
    for job in jobs:
        work = [{**asdict(s), "code": code(module_of(s.stage))} for s in job.steps]
        write_atomically(out / FOLDER / f"{job.name}.json", json.dumps(work, indent=1))
    return waits(jobs)
