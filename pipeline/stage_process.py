"""One stage in its own process, or several one after the other, as a workflow rule starts them."""

import gc
import importlib
import time
import traceback
from collections.abc import Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from pipeline.errors import Rig2SeaError
from pipeline.journal import Event, note
from pipeline.plan import RAW_KINDS, stage_log
from pipeline.stage_table import module_of

#: Objects made before garbage is searched for, and searches before older ones are searched. Results
#: are thousands of objects that stay: at Python's own numbers a tenth of a diagnosis was searching.
_SEARCH_AFTER = (50_000, 20, 20)


def run_stage(
    stage: str, vehicle: str, code: str, inputs: tuple[Path, ...], outputs: tuple[Path, ...]
) -> int:
    """Run a stage, a module of `pipeline.stages`, and tell the journal how it ended.

    Standard output is the rule's log: a fault of our own leaves its traceback there. `vehicle` is
    empty for the index, `code` the digest kept in the result; of the `outputs` the first is the
    stage's own. Returns 0 done, 1 failed.
    """
    started = time.monotonic()
    name = outputs[0].stem
    item = name if vehicle and name != stage else ""
    note(Event("started", vehicle, stage, item=item))
    try:
        from pipeline.stages.job import Job

        module = importlib.import_module(module_of(stage))
        job = Job(stage, vehicle, code, inputs, outputs[0], outputs[1:])
        text: str
        if stage in RAW_KINDS and len(inputs) > 1:
            from pipeline.ingest.reading_process import in_reading_process

            text = in_reading_process(lambda: module.run(job))
        else:
            text = module.run(job)
    except Rig2SeaError as error:
        print(error)
        note(Event("failed", vehicle, stage, str(error), item=item))
        return 1
    except Exception as error:  # noqa: BLE001 - whatever it is, the user gets one line
        traceback.print_exc()
        fault = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        note(Event("failed", vehicle, stage, f"A fault of rig2sea itself ({fault}).", item=item))
        return 1
    seconds = time.monotonic() - started
    print(text or "done")
    note(Event("done", vehicle, stage, text, seconds, item))
    return 0


def run_steps(work: Sequence[Mapping[str, Any]]) -> int:
    """Run stages one after the other, each as if it were alone; returns 1 when any has failed.

    A stage that fails takes with it those that need its results, and no others. Of each, `work` has
    `vehicle`, `stage`, `item`, `code`, `inputs` and `outputs`.
    """
    gc.set_threshold(*_SEARCH_AFTER)
    missing: set[str] = set()
    for one in work:
        if missing.intersection(one["inputs"]):
            missing.update(one["outputs"])
            continue
        log = Path(stage_log(one["vehicle"], one["stage"], one["item"]))
        log.parent.mkdir(parents=True, exist_ok=True)
        inputs = tuple(map(Path, one["inputs"]))
        outputs = tuple(map(Path, one["outputs"]))
        with (
            log.open("w", encoding="utf-8", errors="backslashreplace") as text,
            redirect_stdout(text),
            redirect_stderr(text),
        ):
            code = run_stage(one["stage"], one["vehicle"], one["code"], inputs, outputs)
        if code != 0:
            missing.update(one["outputs"])
            print(f"{one['vehicle']} {one['item']}: {one['stage']} failed: {log}")
        if one["item"]:
            gc.collect()  # the next log may be large too
            gc.freeze()  # what is left are modules: not to be searched again and again
    return 1 if missing else 0
