"""Tasks side by side, as many as there are workers, however deep they call for each other."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from threading import Lock
from typing import TypeVar

T = TypeVar("T")


class Workers:
    """So many threads, the one that asks among them; compiled code lets go of Python's lock.

    A task may have tasks of its own. It shares them with whoever has nothing to do, and does them
    alone where everybody is busy: more threads than workers would only wait for each other.
    """

    def __init__(self, count: int) -> None:
        self._idle = max(count, 1) - 1
        self._lock = Lock()

    def each(self, tasks: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions, and return what they give in their order."""
        waiting, found = iter(list(enumerate(tasks))), dict[int, T]()

        def work() -> None:
            for number, task in waiting:
                found[number] = task()

        def help_out() -> None:
            with self._idle_after():
                work()

        helpers = self._taken(len(tasks) - 1)
        if not helpers:
            work()
            return [found[number] for number in range(len(tasks))]
        try:
            with ThreadPoolExecutor(helpers) as pool:
                others = [pool.submit(help_out) for _ in range(helpers)]
                # who waits for the others has nothing to do either
                with self._idle_after():
                    work()
        finally:
            self._add(-1)
        for one in others:
            one.result()
        return [found[number] for number in range(len(tasks))]

    def _taken(self, most: int) -> int:
        """Take at most so many who have nothing to do."""
        with self._lock:
            count = max(min(most, self._idle), 0)
            self._idle -= count
        return count

    def _add(self, count: int) -> None:
        with self._lock:
            self._idle += count

    @contextmanager
    def _idle_after(self) -> Iterator[None]:
        try:
            yield
        finally:
            self._add(1)
