"""What the engine has to do where it is started by itself, without ``rig2sea run``."""

import json
from pathlib import Path

from pipeline.provenance import write_atomically
from pipeline.workflow.engine import FOLDER
from pipeline.workflow.engine_jobs import engine_jobs, hand_over
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.run import RunRequest, due_of, vehicles_to_run, workers_of


def jobs_here(is_main: bool) -> dict[str, list[str]]:
    """Return the jobs of the vehicles under ``raw/`` and what each waits for.

    A process that the engine starts for one of them (not `is_main`) is told the same again.
    """
    told = Path(FOLDER, "waits.json")
    if not is_main:
        known: dict[str, list[str]] = json.loads(told.read_text(encoding="utf-8"))
        return known
    request = RunRequest()
    vehicles, _ = vehicles_to_run(request)
    due = due_of(vehicles, request, KnownFiles())
    waited = dict(hand_over(engine_jobs(due, Path(), workers_of(request), ()), Path()))
    write_atomically(told, json.dumps(waited))
    return waited
