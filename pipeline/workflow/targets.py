"""What the Snakefile asks: inputs that depend on the vehicle, and digests that make it re-run."""

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.plan import (
    RECEIPT_STAGES,
    RECORD_STAGES,
    VehicleFolder,
    discover,
    processed_file,
    report_file,
)
from pipeline.provenance import code_digest, file_digest
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_jobs import PoolJobs
from pipeline.workflow.pool_plan import PoolPlan, plan_pool
from pipeline.workflow.thruster_types import with_types


@dataclass(frozen=True)
class Targets:
    """The vehicles of this run, and those whose earlier results the index also leads to."""

    vehicles: Mapping[str, VehicleFolder]
    others: tuple[str, ...] = ()
    pool: Mapping[str, PoolJobs] = field(default_factory=dict)
    only: tuple[str, ...] = ()
    """Stages of which the results are wanted; everything when there are none."""

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> "Targets":
        """Take the vehicles that ``rig2sea run`` chose, or find them under ``raw/``."""
        here = Path.cwd()
        if "vehicles" in config:
            types = config.get("types", {})
            folders = {
                name: VehicleFolder(name, path, types.get(name, ""))
                for name, path in config["vehicles"].items()
            }
            pool = {
                name: PoolJobs(PoolPlan.from_config(name, body))
                for name, body in config.get("pool", {}).items()
            }
            only = tuple(config.get("only", ()))
            return cls(folders, tuple(config.get("others", ())), pool, only)
        found, _ = discover(Path(config.get("raw", "raw")), here)
        pool = {vehicle.name: PoolJobs(plan_pool(vehicle, here, KnownFiles())) for vehicle in found}
        for jobs in pool.values():
            jobs.remove_marks(here)
        return cls({one.name: one for one in with_types(found, here)}, (), pool)

    def all_files(self) -> list[str]:
        """Return every file of the workflow.

        All of them, because the engine does not miss an intermediate file that is gone as long as
        what was made from it is there.
        """
        if self.only:
            mains = [name for name, one in self.vehicles.items() if not one.thruster_type]
            return [processed_file(name, stage) for name in mains for stage in self.only]
        files = ["reports/index.html"]
        for name in self.vehicles:
            stages = (*RECORD_STAGES, "tables", *RECEIPT_STAGES)
            files += [report_file(name), *(processed_file(name, stage) for stage in stages)]
            files += self._pool_of(name).targets()
        return files

    def _pool_of(self, vehicle: str) -> PoolJobs:
        return self.pool.get(vehicle) or PoolJobs(PoolPlan(vehicle))

    def day_inputs(self, stage: str, vehicle: str, day: str) -> list[str]:
        """Return what a stage reads for one day."""
        return self._pool_of(vehicle).plan.inputs(stage, day, self.vehicle_file(vehicle))

    def day_waits_for(self, stage: str, vehicle: str, day: str) -> list[str]:
        """Return what has to be there before a stage of one day."""
        return self._pool_of(vehicle).waits_for(stage, day, self.vehicle_file(vehicle))

    def batch_waits_for(self, vehicle: str, batch: str) -> list[str]:
        """Return what has to be there before a batch of runs."""
        return self._pool_of(vehicle).batch_waits_for(batch, self.vehicle_file(vehicle))

    def batch_work(self, vehicle: str, batch: str) -> str:
        """Return what a batch has to do, for its process."""
        jobs = self._pool_of(vehicle)
        stages = jobs.work_of(batch)
        codes = {stage: code_digest(f"pipeline.stages.{stage}") for stage, _ in stages}
        return json.dumps(
            [
                {
                    "stage": stage,
                    "item": run,
                    "code": codes[stage],
                    "inputs": jobs.plan.inputs(stage, run, self.vehicle_file(vehicle)),
                    "outputs": jobs.plan.outputs(stage, run),
                }
                for stage, run in stages
            ]
        )

    def batch_content(self, vehicle: str, batch: str) -> str:
        """Return a digest of the logs and notes of a batch."""
        jobs = self._pool_of(vehicle)
        parts = [jobs.plan.contents.get(run, "") for run in jobs.by_name[batch].runs]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]

    def batch_pattern(self) -> str:
        """Return a pattern of all batches; of nothing if there are none."""
        names = {name for jobs in self.pool.values() for name in jobs.by_name}
        return "|".join(re.escape(name) for name in sorted(names)) or "(?!)"

    def day_pattern(self, stage: str) -> str:
        """Return a pattern of the days that a stage has to do; of nothing if none.

        What is not in it is a finished file to the engine, which then costs nothing.
        """
        due = {item for jobs in self.pool.values() for item in jobs.plan.pending.get(stage, ())}
        return "|".join(re.escape(item) for item in sorted(due)) or "(?!)"

    def trial_receipts(self, vehicle: str) -> list[str]:
        """Return the receipts of the pages of a vehicle's trial days."""
        return self._pool_of(vehicle).plan.page_receipts()

    def receipts(self) -> list[str]:
        """Return the receipts of the pages of this run's vehicles."""
        return [processed_file(name, "vehicle_page") for name in self.vehicles]

    def other_receipts(self) -> list[str]:
        """Return those of the vehicles that are not part of this run."""
        return [processed_file(name, "vehicle_page") for name in self.others]

    def vehicle_file(self, vehicle: str) -> str:
        """Return the path of a vehicle's description."""
        return _whatever_its_time(self.vehicles[vehicle].vehicle_file)

    def results_of_types(self, vehicle: str, *stages: str) -> list[str]:
        """Return results of the further types of thruster that a vehicle has."""
        of = self.vehicles[vehicle]
        return (
            [
                processed_file(one.name, stage)
                for one in self.vehicles.values()
                if one.thruster_type and one.folder == of.folder and one.name != vehicle
                for stage in stages
            ]
            if not of.thruster_type
            else []
        )

    def raw_files(self, vehicle: str, kind: str) -> list[str]:
        """Return a vehicle's raw files of one kind."""
        return [_whatever_its_time(path) for path in self.vehicles[vehicle].raw_files(kind)]

    def content(self, vehicle: str, kind: str | None = None) -> str:
        """Return a digest of the vehicle file and of the raw files of one kind.

        Times of files lie (an archive unpacked, a clock set back); names and contents do not.
        """
        folder = self.vehicles[vehicle]
        digest = hashlib.sha256(file_digest(Path(folder.vehicle_file)).encode())
        for path in folder.raw_files(kind) if kind else ():
            digest.update(f"{Path(path).name}\n{file_digest(Path(path))}\n".encode())
        for name in folder.misnamed_files(kind) if kind else ():
            digest.update(f"{name}\n".encode())
        return digest.hexdigest()[:16]

    def others_content(self) -> str:
        """Return a digest of the results of the vehicles that are not part of this run."""
        parts = [f"{path} {file_digest(Path(path))}" for path in self.other_receipts()]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def _whatever_its_time(path: str) -> str:
    """Mark a raw file, so that the engine goes by its content (`Targets.content`) alone.

    A clock that was ahead on the bench would else make the engine redo everything in every run.
    """
    from snakemake.io import ancient

    marked: str = ancient(path)
    return marked
