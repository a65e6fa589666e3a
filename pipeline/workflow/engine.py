"""Start Snakemake in its own process, which dies with the one that started it.

``python -m pipeline.workflow.engine FD ARG...``: FD is the reading end of a pipe that only the
parent holds open. When the parent is gone, however it went, the pipe closes, and the engine and
its stages are ended at once; the next run finds nothing at work.
"""

import os
import pkgutil
import signal
import sys
import threading

#: Folder of the jobs' work, marks and logs, from the output folder; of use within one execution.
FOLDER = "processed/.rig2sea/jobs"


def main() -> None:
    """Watch the parent and hand over to Snakemake."""
    alive = int(sys.argv[1])
    threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()
    if "--profile" not in sys.argv:
        _without_clusters()
    from snakemake.cli import main as snakemake

    snakemake(sys.argv[2:])


def _without_clusters() -> None:
    """Hide the plugins for clusters, one of which imports pandas; look for others once."""
    every = pkgutil.iter_modules
    found = [one for one in every() if one.name.startswith("snakemake_")]
    kept = [one for one in found if not one.name.startswith("snakemake_executor_plugin_")]
    pkgutil.iter_modules = lambda path=None, prefix="": every(path, prefix) if path else iter(kept)


def _end_with_parent(alive: int) -> None:
    while os.read(alive, 1):
        pass
    os.killpg(os.getpgrp(), signal.SIGKILL)


if __name__ == "__main__":
    main()
