"""One stage in its own process, as a workflow rule starts it."""

import importlib
import time
import traceback
from pathlib import Path

from pipeline.errors import Rig2SeaError
from pipeline.journal import Event, note


def run_stage(
    stage: str, vehicle: str, code: str, inputs: tuple[Path, ...], outputs: tuple[Path, ...]
) -> int:
    """Run a stage and tell the journal how it ended.

    Standard output is the rule's log: a fault of our own leaves its traceback there.

    Parameters
    ----------
    stage : str
        A module of `pipeline.stages` with ``run(job)``.
    vehicle : str
        Name of the vehicle; empty for the index.
    code : str
        Digest of the stage's code, kept in the result.
    inputs : tuple of Path
        All that it may read.
    outputs : tuple of Path
        The files that it writes; the first is the stage's own.

    Returns
    -------
    int
        0 done, 1 failed.
    """
    started = time.monotonic()
    note(Event("started", vehicle, stage))
    try:
        from pipeline.stages.job import Job

        module = importlib.import_module(f"pipeline.stages.{stage}")
        text: str = module.run(Job(stage, vehicle, code, inputs, outputs[0], outputs[1:]))
    except Rig2SeaError as error:
        print(error)
        note(Event("failed", vehicle, stage, str(error)))
        return 1
    except Exception as error:  # noqa: BLE001 - whatever it is, the user gets one line
        traceback.print_exc()
        fault = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        note(Event("failed", vehicle, stage, f"A fault of rig2sea itself ({fault})."))
        return 1
    seconds = time.monotonic() - started
    print(text or "done")
    note(Event("done", vehicle, stage, text, seconds))
    return 0
