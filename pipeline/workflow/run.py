"""``rig2sea run``: check, sweep, start the engine, tell what happens, sum up."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from pipeline.errors import InputError, Place, Problem
from pipeline.journal import Event
from pipeline.plan import VehicleFolder, choose, processed_file
from pipeline.provenance import unwritable, write_atomically
from pipeline.reader_language import current
from pipeline.workflow.freshness import remove_stale
from pipeline.workflow.known_files import KnownFiles
from pipeline.workflow.lock import only_run
from pipeline.workflow.outcome import Outcome, outcome_of
from pipeline.workflow.pool_jobs import PoolJobs
from pipeline.workflow.pool_outcome import new_pages, with_pool
from pipeline.workflow.pool_plan import PoolPlan, plan_pool
from pipeline.workflow.profile import find_profile
from pipeline.workflow.progress import Progress
from pipeline.workflow.settled import is_settled, keep, state_digest
from pipeline.workflow.start import forget_engine_state, start, usable_cores
from pipeline.workflow.thruster_types import with_types
from pipeline.workflow.vehicle_places import forget_gone, taken_over

#: How many processes a cluster is taken to have at work side by side, for the size of batches.
_WORKERS_ELSEWHERE = 100


@dataclass(frozen=True)
class Request:
    """What the user asked for.

    `waiting` names logs that are still being copied, by vehicle: they are left for a later run.
    `profile` names where the jobs are executed (`find_profile`); None for this machine.
    `only` names the stages whose results are wanted: they are made with all that they need, and
    neither pool runs nor pages. Everything when it is empty.
    """

    vehicles: tuple[str, ...] = ()
    raw: Path = Path("raw")
    out: Path = Path()
    cores: int | None = None
    force: bool = False
    waiting: Mapping[str, frozenset[str]] = field(default_factory=dict)
    profile: str | None = None
    only: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """How a run ended: `done` counts the stages that ran, `refused` what never became a vehicle.

    `pages` are those of pool runs and trial days that were made, from the output folder.
    `stopped` tells of an engine that ended by itself, with no stage to blame.
    """

    vehicles: tuple[str, ...]
    refused: tuple[Problem, ...]
    outcomes: tuple[Outcome, ...]
    failed: tuple[Event, ...]
    done: int
    complete: bool
    pages: tuple[str, ...] = ()
    stopped: str = ""

    @property
    def code(self) -> int:
        """Exit code: 1 when a file was refused, inputs contradict each other, or a stage failed."""
        bad = self.refused or any(outcome.failed for outcome in self.outcomes)
        return 1 if bad or not self.complete else 0


def run(request: Request, progress: Progress) -> Result:
    """Bring the results of the chosen vehicles up to date.

    Parameters
    ----------
    request : Request
        Vehicles, folders, number of cores.
    progress : Progress
        Is told every event.

    Returns
    -------
    Result
        What came of it.

    Raises
    ------
    InputError
        When nothing can be done at all: no vehicle, an unwritable folder, another run at work, a
        profile that cannot be used.
    UsageError
        When a vehicle that was asked for does not exist.
    StoppedError
        When the run was stopped from outside.
    """
    state = request.out / "processed" / ".rig2sea"
    profile = None if request.profile is None else find_profile(request.profile)
    chosen, refused = vehicles_to_run(request)
    with only_run(state / "lock"):
        # a part of the work writes no pages: their folder need not even be there
        tops = ("processed",) if request.only else ("processed", "reports")
        for top in tops:
            _writable(request.out / top)
        _tell_of_places(state, request, chosen, progress)
        sound, unsound = _sound(chosen, request.out, tops)
        complete = True
        known = KnownFiles.load(state / "known_files.json")
        plans: dict[str, PoolPlan] = {}
        if sound:
            stale = [
                path
                for one in sound
                for path in remove_stale(one, request.out, pages=not request.only)
            ]
            if not request.only:
                flown = [one for one in sound if not one.thruster_type]
                plans = {one.name: _plan_pool(one, request, known) for one in flown}
            stale += [path for plan in plans.values() for path in plan.stale]
            write_atomically(state / "swept.txt", "".join(f"{path}\n" for path in stale))
            job = _Execution(request, plans, state, known, profile)
            job.remember()  # what was read is kept if this run is stopped
            complete = _bring_up_to_date(job, sound, progress, swept=bool(stale))
        outcomes = tuple(_outcome(one, request.out, plans.get(one.name), known) for one in sound)
        if sound:
            job.remember()
        return Result(
            vehicles=tuple(vehicle.name for vehicle in sound),
            refused=refused + unsound,
            outcomes=outcomes,
            failed=tuple(progress.failed),
            done=progress.done,
            complete=complete,
            pages=tuple(page for plan in plans.values() for page in new_pages(plan, request.out)),
            stopped=progress.stopped,
        )


def _tell_of_places(
    state: Path, request: Request, chosen: Sequence[VehicleFolder], progress: Progress
) -> None:
    """Tell of vehicles that are gone, and of results that a namesake's replace."""
    for name, other in taken_over(state, request.out, chosen):
        progress.say(
            f"{name}: its results here are those of {other}, another vehicle of this name, and are "
            "replaced. Name one of the two folders anew, or another place with --out, to keep both."
        )
    for name in () if request.only else forget_gone(state, request.out, chosen):
        progress.say(f"{name}: its raw folder is gone. Its results and pages stay.")


def vehicles_to_run(request: Request) -> tuple[tuple[VehicleFolder, ...], tuple[Problem, ...]]:
    """Return the vehicles that are asked for, and why others are none.

    Raises
    ------
    InputError
        When the raw folder holds no vehicle at all.
    UsageError
        When a vehicle that was asked for does not exist.
    """
    found, refused = choose(request.vehicles, request.raw, request.out)
    chosen = with_types(found, request.out)
    if not chosen and not refused:
        raise InputError.at(
            Place(str(request.raw)),
            "holds no vehicle.",
            expected="a folder for each vehicle: raw/<vehicle>/vehicle.yaml beside its load_test, "
            "mooring and open_water folders.",
            remedy="Put one there, or say where the raw folder is with --raw.",
        )
    return chosen, refused


def _plan_pool(vehicle: VehicleFolder, request: Request, known: KnownFiles) -> PoolPlan:
    """Plan a vehicle's pool runs and remove what does not fit any more."""
    here_or_there = usable_cores() if request.profile is None else _WORKERS_ELSEWHERE
    plan = plan_pool(
        vehicle,
        request.out,
        known,
        waiting=request.waiting.get(vehicle.name, frozenset()),
        force=request.force,
        workers=request.cores or here_or_there,
    )
    PoolJobs(plan).remove_marks(request.out)
    for path in plan.stale:
        (request.out / path).unlink(missing_ok=True)
    return plan


def _writable(folder: Path) -> None:
    probe = folder / f".probe-{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise unwritable(folder, error) from error


def _sound(
    vehicles: Sequence[VehicleFolder], out: Path, tops: Sequence[str]
) -> tuple[list[VehicleFolder], tuple[Problem, ...]]:
    """Separate the vehicles that can be run from the reasons why others cannot.

    `tops` names the folders of `out` in which each vehicle's own has to be writable.
    """
    from pipeline.vehicle.load import load_vehicle

    sound: list[VehicleFolder] = []
    problems: list[Problem] = []
    for vehicle in vehicles:
        path = out / vehicle.vehicle_file
        try:
            load_vehicle(path)
            for top in tops:
                _writable(out / top / vehicle.name)
        except InputError as error:
            problems.append(error.problem)
        else:
            sound.append(vehicle)
    return sound, tuple(problems)


@dataclass(frozen=True)
class _Execution:
    """What one execution is made with; `state` is the folder of its memory and its logs."""

    request: Request
    plans: Mapping[str, PoolPlan]
    state: Path
    known: KnownFiles
    profile: Path | None

    def remember(self) -> None:
        """Keep what was read; a part of the work has looked at a part of the files."""
        if not self.request.only:
            self.known.save(self.state / "known_files.json")

    def start(self, vehicles: Sequence[VehicleFolder], progress: Progress, *, force: bool) -> bool:
        """Run the engine over these vehicles."""
        config = self.state / "config.json"
        write_atomically(config, json.dumps(self.config(vehicles), indent=1))
        out, cores = self.request.out, self.request.cores
        return start(config, out, cores, progress, force=force, profile=self.profile)

    def config(self, vehicles: Sequence[VehicleFolder]) -> dict[str, object]:
        """Tell the Snakefile which vehicles are run, and which have results from before."""
        names = {vehicle.name for vehicle in vehicles}
        others = sorted(
            receipt.parent.name
            for receipt in (self.request.out / "processed").glob("*/vehicle_page.json")
            if receipt.parent.name not in names
        )
        return {
            "vehicles": {one.name: one.folder for one in vehicles},
            "types": {one.name: one.thruster_type for one in vehicles if one.thruster_type},
            "others": others,
            "pool": {
                one.name: self.plans[one.name].to_config()
                for one in vehicles
                if one.name in self.plans
            },
            "only": list(self.request.only),
            # a part of the work makes no pages
            **({} if self.request.only else {"language": current()}),
        }


def _bring_up_to_date(
    job: _Execution, vehicles: Sequence[VehicleFolder], progress: Progress, *, swept: bool
) -> bool:
    """Run the engine; after a failure once more, so that the index leads to all that is whole."""
    request, out = job.request, job.request.out
    memory = job.state / ("settled" + "".join(f"-{stage}" for stage in request.only))
    due = swept or request.force or any(plan.pending for plan in job.plans.values())
    if not due and is_settled(memory, state_digest(job.config(vehicles), vehicles, out, job.known)):
        (job.state / "journal.jsonl").unlink(missing_ok=True)
        return True
    memory.unlink(missing_ok=True)
    progress.more = sum(PoolJobs(plan).stages_beyond_jobs() for plan in job.plans.values())
    done_all = job.start(vehicles, progress, force=request.force)
    if not done_all and progress.stopped and request.profile is None:
        # The engine itself gave up, with no stage to blame: a raw file was renamed or removed while
        # it was at work, or what it remembers is damaged. The others are not to wait for that.
        forget_engine_state(out)
        progress.stopped = ""
        progress.say("The workflow is started once more, over what is there now.")
        done_all = job.start(vehicles, progress, force=False)
    if done_all:
        done = {name: replace(plan, pending={}, batches=()) for name, plan in job.plans.items()}
        after = replace(job, plans=done)
        keep(memory, state_digest(after.config(vehicles), vehicles, out, job.known))
        return True
    whole = [one for one in vehicles if (out / processed_file(one.name, "vehicle_page")).is_file()]
    if whole and len(whole) < len(vehicles) and not request.only:
        job.start(whole, progress, force=False)
    return False


def _outcome(
    vehicle: VehicleFolder, out: Path, plan: PoolPlan | None, known: KnownFiles
) -> Outcome:
    found = outcome_of(vehicle, out)
    return found if plan is None else with_pool(found, vehicle, plan, out, known)
