"""Timing on a machine that others use too: interleaved rounds, medians of paired ratios.

What runs on one thread is measured in its processor time, so that time spent waiting for a core
that is busy elsewhere does not count; it would count against the slowest most. What runs on several
is measured by the clock on the wall, and needs the machine to itself.
"""

import gc
import os
import platform
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np

Call = Callable[[], object]


@dataclass(frozen=True)
class Timing:
    """Seconds of one call, round by round."""

    rounds_s: tuple[float, ...]

    @property
    def median_s(self) -> float:
        """Median of the rounds. [s]."""
        return statistics.median(self.rounds_s)

    @property
    def best_s(self) -> float:
        """Fastest round: what the machine can do when left alone. [s]."""
        return min(self.rounds_s)

    def times_slower_than(self, other: "Timing") -> float:
        """Median over the rounds of this time over the other's in the same round."""
        pairs = zip(self.rounds_s, other.rounds_s, strict=True)
        return statistics.median(mine / its for mine, its in pairs)


def interleaved(
    calls: Mapping[str, Call], rounds: int, clock: Callable[[], float] = time.thread_time
) -> dict[str, Timing]:
    """Time calls by turns: each round runs every one, each round begins with another.

    Every call runs once before, untimed.
    """
    names = list(calls)
    for call in calls.values():
        call()
    seconds: dict[str, list[float]] = {name: [] for name in names}
    gc.collect()
    for k in range(rounds):
        for name in names[k % len(names) :] + names[: k % len(names)]:
            start = clock()
            calls[name]()
            seconds[name].append(clock() - start)
    return {name: Timing(tuple(values)) for name, values in seconds.items()}


def conditions() -> dict[str, str]:
    """Tell what the figures are taken on."""
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "load average before": load_average(),
        "Python": platform.python_version(),
        "NumPy": np.__version__,
        "Numba": numba.__version__,
    }


def load_average() -> str:
    """Return how many processes wanted to run during the last minute."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def _processor() -> str:
    table = Path("/proc/cpuinfo")
    if table.exists():
        for line in table.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
