"""``rig2sea watch``."""

import time
from typing import Any

import click

from pipeline.commands.common.options import ALL_RAW, CORES, RESULTS, VEHICLES, NumberRange
from pipeline.commands.common.say import say


@click.command()
@VEHICLES
@ALL_RAW
@RESULTS
@CORES
@click.option(
    "--every",
    "every_s",
    type=NumberRange(0.05, 3600.0),
    default=2.0,
    show_default=True,
    metavar="S",
    help="Seconds between two looks.",
)
@click.option(
    "--settle",
    "settle_s",
    type=NumberRange(0.0, 3600.0),
    default=3.0,
    show_default=True,
    metavar="S",
    help="Seconds that a file must stay as it is; ten times that for a log that was not closed.",
)
@click.option("--once", is_flag=True, help="Run what is whole, then end.")
def watch(*, every_s: float, settle_s: float, once: bool, **request: Any) -> None:  # noqa: ANN401 - fields of the request
    r"""Run the workflow whenever a file lands in raw/, and say where the new report is.

    A file counts when it is whole: unchanged for a while, and a log closed by its recorder. One
    that is still being copied is waited for, a broken one is named, and the others go on. Ctrl-C
    ends it; the next start goes on from there.

    \b
    Examples:
      rig2sea watch
      rig2sea watch mmt300 --settle 10
      rig2sea watch --once
    """
    from pipeline.workflow.run import RunRequest, vehicles_to_run
    from pipeline.workflow.start import StoppedError
    from pipeline.workflow.watch import Watcher

    watcher = Watcher(RunRequest(**request), settle_s)
    try:
        if once:
            vehicles_to_run(watcher.request)
            _say(watcher.look())
            time.sleep(settle_s)
            _say(watcher.look())
            _say([f"left for later, not whole yet: {path}" for path in watcher.still_coming])
            raise click.exceptions.Exit(1 if watcher.failed else 0)
        say(f"Watching {watcher.request.raw}; Ctrl-C ends it.")
        while True:
            _say(watcher.look())
            time.sleep(every_s)
    except (KeyboardInterrupt, StoppedError):
        say("Stopped watching. The next start goes on from here.", err=True)
        if once:  # who asked for one look was not given it; a watch has no other end
            raise click.exceptions.Exit(1) from None


def _say(lines: list[str]) -> None:
    for line in lines:
        say(line, err=line.startswith("error: "))
