"""Many cases in several processes, each as it comes; once stopped no waiting one is begun."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

Case = TypeVar("Case")
Result = TypeVar("Result")


def as_they_come(
    run: Callable[[Case], Result], cases: Sequence[Case], processes: int
) -> Iterator[Result]:
    """Run cases, and yield what comes of them: in their order with one process, in any with more.

    Another process must be able to import `run`.
    """
    if processes == 1 or len(cases) < 2:
        yield from map(run, cases)
        return
    # each process has one core: linear algebra is not to start threads on top
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        waiting = [pool.submit(run, case) for case in cases]
        try:
            for future in as_completed(waiting):
                yield future.result()
        except BaseException:
            # only the cases that are at work are waited for, not all that were asked for
            for future in waiting:
                future.cancel()
            raise
