"""Start Snakemake in its own process, which dies with the one that started it.

``python -m pipeline.workflow.engine FD ARG...``: FD is the reading end of a pipe that only the
parent holds open. When the parent is gone, however it went, the pipe closes, and the engine and
its stages are ended at once; the next run finds nothing at work.
"""

import os
import signal
import sys
import threading


def main() -> None:
    """Watch the parent and hand over to Snakemake."""
    alive = int(sys.argv[1])
    threading.Thread(target=_end_with_parent, args=(alive,), daemon=True).start()
    from snakemake.cli import main as snakemake

    snakemake(sys.argv[2:])


def _end_with_parent(alive: int) -> None:
    while os.read(alive, 1):
        pass
    os.killpg(os.getpgrp(), signal.SIGKILL)


if __name__ == "__main__":
    main()
