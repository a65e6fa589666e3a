"""Many cases in several processes, each as it comes; once stopped no waiting one is begun."""

import os
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from pipeline.campaign.result_lines import appending, read_lines
from pipeline.stopping import stopped_by_sigterm

Case = TypeVar("Case")
Result = TypeVar("Result")


def as_they_come(
    run: Callable[[Case], Result], cases: Sequence[Case], processes: int
) -> Iterator[Result]:
    """Run cases, and yield what comes of them: in their order with one process, in any with more.

    Parameters
    ----------
    run : callable
        From a case to its result; another process must be able to import it.
    cases : sequence
        What is given to it.
    processes : int
        Cases at a time. One runs them here.
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


def lines_of_cases(
    file: Path,
    numbers: Collection[int],
    run: Callable[[int], dict[str, Any]],
    said: Callable[[int, int, str], None],
    text_of: Callable[[dict[str, Any]], str],
    *,
    processes: int,
) -> list[dict[str, Any]]:
    """Run the cases that have no line in a file yet, and return the lines of all that are done.

    Parameters
    ----------
    file : Path
        Has a line for each case; what is done is added to it at once.
    numbers : collection of int
        The cases that are asked for.
    run : callable
        From a number to the line; another process must be able to import it.
    said : callable
        Told of every case: how many are done, how many there are, one line.
    text_of : callable
        That line.
    processes : int
        Cases at a time.
    """
    done = {line["number"]: line for line in read_lines(file) if line["number"] in numbers}
    wanted = [number for number in numbers if number not in done]
    with appending(file) as append, stopped_by_sigterm():
        try:
            for line in as_they_come(run, wanted, processes):
                append(line)
                done[line["number"]] = line
                said(len(done), len(numbers), text_of(line))
        except KeyboardInterrupt:
            said(len(done), len(numbers), "stopped; --resume goes on from here")
    return list(done.values())
