"""What the engine is told of the pool runs: batches of runs, stages of days, who waits for what."""

import shutil
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pipeline.workflow.pool_batches import MARKS, PHASES, Batch, mark_file
from pipeline.workflow.pool_plan import DAY_STAGES, RUN_STAGES, PoolPlan


@dataclass(frozen=True)
class PoolJobs:
    """The jobs of a vehicle's plan."""

    plan: PoolPlan

    @cached_property
    def by_name(self) -> dict[str, Batch]:
        """The batches."""
        return {batch.name: batch for batch in self.plan.batches}

    @cached_property
    def _mark_of(self) -> dict[str, str]:
        """File that a batch makes -> its mark."""
        return {
            file: mark_file(self.plan.vehicle, name)
            for name in self.by_name
            for stage, run in self.work_of(name)
            for file in self.plan.outputs(stage, run)
        }

    @cached_property
    def _pending(self) -> dict[str, frozenset[str]]:
        return {stage: frozenset(items) for stage, items in self.plan.pending.items()}

    def targets(self) -> list[str]:
        """Return what the engine is asked for: marks of batches, and the files of days."""
        marks = [mark_file(self.plan.vehicle, name) for name in self.by_name]
        return marks + [
            file
            for stage in DAY_STAGES
            for day in self.plan.pending.get(stage, ())
            for file in self.plan.outputs(stage, day)
        ]

    def work_of(self, name: str) -> list[tuple[str, str]]:
        """Return (stage, run) of all that a batch has to do, in order."""
        batch = self.by_name[name]
        return [
            (stage, run)
            for run in batch.runs
            for stage in PHASES[batch.phase]
            if run in self._pending.get(stage, ())
        ]

    def waits_for(self, stage: str, item: str, vehicle_file: str) -> list[str]:
        """Return what has to be there before a stage: its inputs, for those of batches the marks.

        Not the raw files of runs: their names may hold what the engine reads as signs of its own.
        """
        raw = self.plan.raw_files(stage, item) if stage in RUN_STAGES else []
        files = [f for f in self.plan.inputs(stage, item, vehicle_file) if f not in raw]
        return list(dict.fromkeys(self._mark_of.get(file, file) for file in files))

    def batch_waits_for(self, name: str, vehicle_file: str) -> list[str]:
        """Return what has to be there before a batch begins."""
        own = mark_file(self.plan.vehicle, name)
        found = [
            file
            for stage, run in self.work_of(name)
            for file in self.waits_for(stage, run, vehicle_file)
        ]
        return [file for file in dict.fromkeys(found) if file != own]

    def stages_beyond_jobs(self) -> int:
        """Return how many more stages there are than jobs: a batch is one job to the engine."""
        return sum(len(self.work_of(name)) - 1 for name in self.by_name)

    def remove_marks(self, out: Path) -> None:
        """Remove the marks of an earlier execution: they say nothing of what is to do now."""
        shutil.rmtree(out / MARKS / self.plan.vehicle, ignore_errors=True)
