"""Several runs in one process: what a small run costs is mostly the start of a process.

A batch takes runs of one day through the stages of a phase, each run with results, message and
freshness of its own.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

#: Phase -> its stages, in groups that all runs of a batch go through before the next: a page waits
#: for no diagnosis. Reading does not wait for the bench; flying does.
PHASES: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "read": (("pool_run",),),
    "fly": (("run_trial", "run_page"), ("run_diagnosis",)),
}
#: A process takes at most so many runs: what is lost when it is killed.
MOST_RUNS = 8
#: A log of this size or more has a process of its own, whose memory is then its own too.
ALONE_BYTES = 50_000_000


@dataclass(frozen=True)
class Batch:
    """Runs that one process takes through a phase, in this order."""

    phase: str
    runs: tuple[str, ...]

    @property
    def name(self) -> str:
        """A name that no other batch of the vehicle has, since a run is in one of each phase."""
        return f"{self.phase}-{self.runs[0]}"


def batches(
    pending: Mapping[str, Sequence[str]],
    days: Mapping[str, Sequence[str]],
    sizes: Mapping[str, int],
    workers: int,
) -> tuple[Batch, ...]:
    """Share the runs that have something to do out.

    Parameters
    ----------
    pending : mapping of str to sequence of str
        Stage -> runs.
    days : mapping of str to sequence of str
        Day -> its runs. A batch has runs of one day: its page waits for no other's.
    sizes : mapping of str to int
        Run -> bytes of its log.
    workers : int
        Processes that may be at work side by side; none is to be idle for the sake of a batch.

    Returns
    -------
    tuple of Batch

    Examples
    --------
    >>> due = {"pool_run": ["a", "b", "c"], "run_page": ["c"]}
    >>> [b.name for b in batches(due, {"2026-05-04": ["a", "b", "c"]}, {"b": 9}, 2)]
    ['read-a', 'read-b', 'fly-c']
    >>> batches(due, {"2026-05-04": ["a", "b", "c"]}, {"b": 9}, 2)[0].runs
    ('a', 'c')
    """
    found = []
    for phase, groups in PHASES.items():
        due = {run for group in groups for stage in group for run in pending.get(stage, ())}
        most = min(MOST_RUNS, max(1, -(-len(due) // max(workers, 1))))
        for runs in days.values():
            # the largest last: a process that runs out of memory has done the others by then
            ordered = sorted(due.intersection(runs), key=lambda run: (sizes.get(run, 0), run))
            found += [Batch(phase, tuple(part)) for part in _parts(ordered, sizes, most)]
    return tuple(found)


def _parts(runs: Sequence[str], sizes: Mapping[str, int], most: int) -> Iterator[Sequence[str]]:
    small = [run for run in runs if sizes.get(run, 0) < ALONE_BYTES]
    for begin in range(0, len(small), most):
        yield small[begin : begin + most]
    for run in runs[len(small) :]:
        yield [run]
