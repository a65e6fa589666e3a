"""What of the pool runs is to be done: only runs and days whose results do not fit any more.

A season has hundreds of runs. The engine is told of those that have something to do; all others
are finished files to it, so a run costs what is new and not what there is. What a
small run costs is mostly the start of a process: a batch takes runs of one day through the stages
of a phase in one process, each run with results, message and freshness of its own.
"""

from bisect import bisect_left
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from pipeline.errors import InputError
from pipeline.ingest.log_files import day_of
from pipeline.plan import VehicleFolder, processed_file
from pipeline.provenance import code_digest, read_raw_envelope
from pipeline.stage_table import STAGES, module_of, stages_of
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.pool_runs import UNDATED, PoolLog, by_day, log_size, pool_logs, result_file

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

RUN_STAGES, DAY_STAGES = stages_of("run"), stages_of("day")
#: The trend of a day's page goes back over this many trial days.
TREND_DAYS = 30


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

    `pending` gives the runs of each stage, `sizes` the bytes of each run's log. A batch has runs of
    one of the `days`: its page waits for no other's. Of `workers`, processes that may be at work
    side by side, none is to be idle for the sake of a batch.

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


@dataclass(frozen=True)
class PoolPlan:
    """A vehicle's runs and days, and what of each is to be made.

    `logs` run -> log; `days` day -> its runs, in order of time; `pending` stage -> runs or days;
    `stale` files are to be removed before the engine starts; `sound` are the runs of the reference
    that is used.
    """

    vehicle: str
    logs: Mapping[str, PoolLog] = field(default_factory=dict)
    days: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    pending: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    stale: tuple[str, ...] = ()
    batches: tuple[Batch, ...] = ()
    sound: tuple[str, ...] = ()

    @cached_property
    def _dated(self) -> tuple[str, ...]:
        """The days that are known, in order."""
        return tuple(sorted(day for day in self.days if day != UNDATED))

    def inputs(self, stage: str, item: str, vehicle_file: str) -> list[str]:
        """Return the files that a stage reads for a run or a day."""
        one = self.vehicle
        bench = [processed_file(one, name) for name in STAGES[stage].needs]
        return [vehicle_file, *bench, *self._own_inputs(stage, item)]

    def _own_inputs(self, stage: str, item: str) -> list[str]:
        """Return what a stage reads of the runs and days themselves."""
        runs = (item,) if STAGES[stage].of == "run" else self.days[item]
        read = self._of_runs("pool_run", runs)
        if stage == "pool_run":
            return list(self.logs[item].inputs)
        if stage == "run_trial":
            return [self.logs[item].path, *read]
        if stage == "run_page":
            return [*read, *self._of_runs("run_trial", runs)]
        if stage == "trial_page":
            return self._page_inputs(item)
        if stage in {"run_diagnosis", "day_diagnosis"}:
            sound = self._of_runs("pool_run", [one for one in self.sound if one not in runs])
            reference = [processed_file(self.vehicle, "reference")] if self.sound else []
            own = self._of_runs("run_diagnosis", runs) if stage == "day_diagnosis" else []
            return [*read, *sound, *reference, *own]
        return read if stage == "trial_day" else []

    def _of_runs(self, stage: str, runs: Sequence[str]) -> list[str]:
        return [result_file(self.vehicle, stage, run) for run in runs]

    def _page_inputs(self, day: str) -> list[str]:
        """Return what the page of a day reads: of that day, and of those before it."""
        earlier = self._dated[: bisect_left(self._dated, day)]
        days = {
            "trial_day": (day, *earlier[-TREND_DAYS:]),
            "day_tables": (*earlier[-1:], day),
            "day_diagnosis": (*earlier[-1:], day),
        }
        read = [result_file(self.vehicle, stage, one) for stage, own in days.items() for one in own]
        runs = self.days[day]
        return [*read, *self._of_runs("run_page", runs), *self._of_runs("run_diagnosis", runs)]

    def outputs(self, stage: str, item: str) -> list[str]:
        """Return the files that a stage declares for a run or a day."""
        first, page = result_file(self.vehicle, stage, item), STAGES[stage].page
        return [first, f"reports/{self.vehicle}/{page}/{item}.html"] if page else [first]

    def is_history(self, stage: str, item: str) -> bool:
        """Whether a result is of a past day, and is to stay as it was then."""
        return STAGES[stage].history and item != (self._dated or (UNDATED,))[-1]

    def page_receipts(self) -> list[str]:
        """Return the receipts of the days' pages, in order of time."""
        return [result_file(self.vehicle, "trial_page", day) for day in self.days]


def plan_pool(
    vehicle: VehicleFolder,
    out: Path,
    known: KnownFiles,
    *,
    waiting: frozenset[str] = frozenset(),
    force: bool = False,
    workers: int = 1,
) -> PoolPlan:
    """Compare the results of a vehicle's runs with what they were made from.

    `known` has digests from earlier runs, `waiting` names logs that are still being copied.
    `force`: everything is to be made anew, but the tables of past days: they are history.
    """
    found = pool_logs(vehicle, out, waiting)
    logs = {log.run: log for log in found}
    days = by_day({run: day_of(out / log.path) for run, log in logs.items()})
    sound = sound_of_reference(out / processed_file(vehicle.name, "reference"), logs)
    plan = PoolPlan(vehicle.name, logs, days, sound=sound)
    pending: dict[str, tuple[str, ...]] = {}
    gone: set[str] = set()
    for stages, items in ((RUN_STAGES, tuple(logs)), (DAY_STAGES, tuple(days))):
        for stage in stages:
            code = code_digest(module_of(stage)) if items else ""
            due = []
            for item in items:
                head = known.head(out / plan.outputs(stage, item)[0], stage)
                if plan.is_history(stage, item):
                    stays = head is not None and all(
                        known.digest(out / name) == own for name, own in head.files.items()
                    )
                else:
                    files = plan.inputs(stage, item, vehicle.vehicle_file)
                    names = vehicle.names_in_results(files)
                    stays = not force and gone.isdisjoint(files)
                    stays = stays and known.fits(head, code, vehicle, out, names)
                if not stays:
                    due.append(item)
                    # pages of runs stay until they are replaced
                    beside = () if head is None or stage == "trial_page" else head.files
                    gone.update((*plan.outputs(stage, item), *beside))
            if due:
                pending[stage] = tuple(due)
    stale = sorted(gone | set(_orphans(vehicle.name, out, plan)))
    there = tuple(file for file in stale if (out / file).is_file())
    sizes = {run: log_size(out / log.path) for run, log in logs.items()}
    shared = batches(pending, days, sizes, workers)
    return replace(plan, pending=pending, stale=there, batches=shared)


def sound_of_reference(path: Path, logs: Mapping[str, PoolLog]) -> tuple[str, ...]:
    """Return the runs of a vehicle's reference; none where there is none, or it is not used."""
    if not path.is_file():
        return ()
    try:
        record = read_raw_envelope(path, "reference")["record"] or {}
        names = [str(run["name"]) for run in record["runs"]] if record["used"] else []
    except (InputError, KeyError, TypeError):
        return ()
    return tuple(name for name in names if name in logs)


def _orphans(vehicle: str, out: Path, plan: PoolPlan) -> list[str]:
    """Return results of runs and days that are no longer there."""
    found = []
    rooms: list[tuple[str, str, Collection[str]]] = []
    for stage in (*RUN_STAGES, *DAY_STAGES):
        own = STAGES[stage]
        there = plan.logs if own.of == "run" else plan.days
        if not own.history:
            processed = f"processed/{vehicle}/{own.room}"
            rooms += [(processed, ending, there) for ending in (".json", *own.beside)]
        if own.page:
            rooms.append((f"reports/{vehicle}/{own.page}", ".html", there))
    for room, ending, kept in rooms:
        folder = out / room
        if folder.is_dir():
            found += [
                f"{room}/{path.name}"
                for path in folder.iterdir()
                # one that a stage was writing when it was ended, or of what is gone
                if (path.name.startswith(".") and path.name.endswith(".part"))
                or (path.name.endswith(ending) and path.name[: -len(ending)] not in kept)
            ]
    return found
