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
    from snakemake.dag import DAG

    DAG.check_output_mtime = _no_check
    snakemake(sys.argv[2:])


async def _no_check(*_: object, **__: object) -> None:
    """Let a result be older than what it was made from, by the clocks.

    The engine takes it for a fault and throws the result away, in every run until the clock has
    caught up; but raw files come from machines whose clocks are ahead, and clocks are set back.
    What was made from what is told by digests.
    """


def _end_with_parent(alive: int) -> None:
    while os.read(alive, 1):
        pass
    os.killpg(os.getpgrp(), signal.SIGKILL)


if __name__ == "__main__":
    main()
