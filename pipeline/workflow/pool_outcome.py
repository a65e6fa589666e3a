"""What the pool runs have to say at the end: logs that were refused, pages that are new."""

from dataclasses import replace
from pathlib import Path

from pipeline.plan import VehicleFolder
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.outcome import Outcome, by_severity, problems_of, with_path
from pipeline.workflow.pool_plan import PoolPlan
from pipeline.workflow.pool_runs import (
    day_problems,
    pool_problems,
    result_file,
)


def with_pool(
    outcome: Outcome, vehicle: VehicleFolder, plan: PoolPlan, out: Path, known: KnownFiles
) -> Outcome:
    """Add to a vehicle's outcome the logs that could not be read, before what the stages say.

    Warnings of single runs stay on their pages: a season has hundreds.
    """
    found = list(pool_problems(vehicle, out))
    days = {run: day for day, runs in plan.days.items() for run in runs}
    found += day_problems(vehicle.name, plan.logs.values(), days)
    for run in plan.logs:
        for stage in ("pool_run", "run_trial"):
            head = known.head(out / result_file(vehicle.name, stage, run), stage)
            if head is not None:
                found += [one for one in problems_of(head.problems) if one.severity == "error"]
    shown = tuple(with_path(problem, vehicle, out) for problem in found)
    return replace(outcome, problems=by_severity(shown + outcome.problems))


def new_pages(plan: PoolPlan, out: Path) -> tuple[str, ...]:
    """Return the pages of runs and days that this run has made, days last."""
    made = [
        plan.outputs(stage, item)[1]
        for stage in ("run_page", "trial_page")
        for item in plan.pending.get(stage, ())
    ]
    return tuple(page for page in made if (out / page).is_file())
