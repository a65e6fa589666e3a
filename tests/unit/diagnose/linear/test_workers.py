"""Tasks side by side: in their order, never more at once than there are workers."""

import threading
import time
from collections.abc import Callable
from functools import partial

import pytest

from pipeline.diagnose.linear.workers import Workers


class Counter:
    """Counts how many tasks are under way at once."""

    def __init__(self) -> None:
        self.now = self.most = 0
        self._lock = threading.Lock()

    def task(self, give: int, meet: threading.Barrier | None = None, pause_s: float = 0.0) -> int:
        with self._lock:
            self.now += 1
            self.most = max(self.most, self.now)
        if meet is not None:
            meet.wait(10.0)
        time.sleep(pause_s)
        with self._lock:
            self.now -= 1
        return give


@pytest.mark.parametrize("count", [0, 1, 2, 5])
@pytest.mark.parametrize("tasks", [0, 1, 2, 30])
def test_what_tasks_give_comes_in_their_order(count: int, tasks: int) -> None:
    counter = Counter()
    found = Workers(count).each([partial(counter.task, k) for k in range(tasks)])
    assert found == list(range(tasks))
    assert counter.most <= max(count, 1)


def test_as_many_as_there_are_work_at_once() -> None:
    meet, counter = threading.Barrier(3), Counter()
    Workers(3).each([partial(counter.task, k, meet) for k in range(3)])
    assert counter.most == 3


def test_tasks_of_tasks_are_no_more_at_once() -> None:
    workers, counter = Workers(2), Counter()

    def deep(level: int) -> list[int]:
        below: list[Callable[[], int]] = [partial(counter.task, k) for k in range(20)]
        if level:
            below = [lambda: sum(deep(level - 1)) for _ in range(3)]
        return workers.each(below)

    assert sum(deep(3)) == 27 * sum(range(20))
    assert counter.most <= 2


@pytest.mark.parametrize("long_first", [True, False])
def test_who_is_done_helps_with_the_tasks_of_others(long_first: bool) -> None:
    """Whoever it is: the one that asked, or the one that helped."""
    workers, counter, both_began = Workers(2), Counter(), threading.Barrier(2)

    def long() -> int:
        both_began.wait(10.0)
        # one of these rounds comes after the other is done
        for _ in range(200):
            workers.each([partial(counter.task, k, pause_s=0.005) for k in range(2)])
            if counter.most == 2:
                break
        return counter.most

    def short() -> int:
        both_began.wait(10.0)
        return 0

    assert max(workers.each([long, short] if long_first else [short, long])) == 2


def test_what_goes_wrong_is_told_and_the_others_are_free_again() -> None:
    workers, counter = Workers(2), Counter()

    def wrong() -> int:
        raise ValueError("wrong")

    for place in range(4):
        tasks: list[Callable[[], int]] = [partial(counter.task, k) for k in range(4)]
        tasks[place] = wrong
        with pytest.raises(ValueError, match="wrong"):
            workers.each(tasks)
    meet = threading.Barrier(2)
    assert workers.each([partial(counter.task, k, meet) for k in range(2)]) == [0, 1]
