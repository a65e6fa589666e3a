"""``rig2sea run``: check, see what is due, start the engine, tell what happens, sum up."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path

from pipeline.errors import InputError, Place, Problem
from pipeline.plan import VehicleFolder, choose, processed_file
from pipeline.provenance import code_digest, unwritable, write_atomically
from pipeline.reader_language import current
from pipeline.stage_table import STAGES, needed_for, stages_of
from pipeline.workflow.engine import FOLDER
from pipeline.workflow.engine_jobs import Due, EngineJob, engine_jobs, hand_over
from pipeline.workflow.known_files import KnownFiles, due_stages, remove_results
from pipeline.workflow.outcome import Result, new_pages, outcome_of
from pipeline.workflow.pool_plan import PoolPlan, plan_pool
from pipeline.workflow.profile import find_profile
from pipeline.workflow.progress import Progress
from pipeline.workflow.start import only_run, start, usable_cores
from pipeline.workflow.vehicle_places import forget_gone, index_digest, taken_over, with_types

#: How many processes a cluster is taken to have at work side by side, for the size of batches.
_WORKERS_ELSEWHERE = 100


@dataclass(frozen=True)
class RunRequest:
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


def run(request: RunRequest, progress: Progress) -> Result:
    """Bring the results of the chosen vehicles up to date; `progress` is told every event.

    Raises `InputError` when nothing can be done at all: no vehicle, an unwritable folder, another
    run at work, a profile that cannot be used; `UsageError` when a vehicle that was asked for does
    not exist; `StoppedError` when the run was stopped from outside.
    """
    state = request.out / "processed" / ".rig2sea"
    profile = None if request.profile is None else find_profile(request.profile)
    chosen, refused = vehicles_to_run(request)
    with only_run(state / "lock"):
        # a part of the work writes no pages: their folder need not even be there
        tops = ("processed",) if request.only else ("processed", "reports")
        for top in tops:
            _writable(request.out / top)
        known = KnownFiles.load(state / "known_files.json")
        _tell_of_places(known.places, request, chosen, progress)
        sound, unsound = _sound(chosen, request.out, tops)
        complete = True
        plans: dict[str, PoolPlan] = {}
        if sound:
            due = due_of(sound, request, known)
            plans = {one.vehicle.name: one.plan for one in due if one.plan is not None}
            _remember(known, request)  # what was read is kept if this run is stopped
            complete = _bring_up_to_date(_Execution(request, due, state, known, profile), progress)
        outcomes = tuple(outcome_of(one, request.out, plans.get(one.name), known) for one in sound)
        if sound:
            _remember(known, request)
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


def _remember(known: KnownFiles, request: RunRequest) -> None:
    """Keep what was read; a part of the work has looked at a part of the files."""
    if not request.only:
        known.save(request.out / "processed" / ".rig2sea" / "known_files.json")


def _tell_of_places(
    places: dict[str, str],
    request: RunRequest,
    chosen: Sequence[VehicleFolder],
    progress: Progress,
) -> None:
    """Tell of vehicles that are gone, and of results that a namesake's replace."""
    for name, other in taken_over(places, request.out, chosen):
        progress.say(
            f"{name}: its results here are those of {other}, another vehicle of this name, and are "
            "replaced. Name one of the two folders anew, or another place with --out, to keep both."
        )
    for name in () if request.only else forget_gone(places, request.out, chosen):
        progress.say(f"{name}: its raw folder is gone. Its results and pages stay.")


def vehicles_to_run(request: RunRequest) -> tuple[tuple[VehicleFolder, ...], tuple[Problem, ...]]:
    """Return the vehicles that are asked for, and why others are none."""
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


def due_of(
    vehicles: Sequence[VehicleFolder], request: RunRequest, known: KnownFiles
) -> tuple[Due, ...]:
    """Return what is to be made of each vehicle, and remove what does not fit any more.

    Further types of thruster come before the vehicles that they are of, which read their results.
    """
    wanted = needed_for(request.only or stages_of("vehicle"))
    read = {one for stage in wanted for one in STAGES[stage].of_types}
    of_types = needed_for(tuple(read)) if request.only else wanted
    found, code = [], cache(code_digest)
    for vehicle in sorted(vehicles, key=lambda one: not one.thruster_type):
        out, plan = request.out, None
        own = of_types if vehicle.thruster_type else wanted
        beside = [
            one.name
            for one in (() if vehicle.thruster_type else vehicles)
            if one.thruster_type and one.folder == vehicle.folder
        ]
        ask = partial(due_stages, vehicle, out, known=known, force=request.force)
        stages = ask(own - {"vehicle_page"}, code, beside)
        remove_results(vehicle, out, stages)
        if not request.only and not vehicle.thruster_type:
            plan = plan_pool(
                vehicle,
                out,
                known,
                waiting=request.waiting.get(vehicle.name, frozenset()),
                force=request.force,
                workers=workers_of(request),
            )
            for path in plan.stale:
                (out / path).unlink(missing_ok=True)
        receipts = () if plan is None else plan.page_receipts()
        page = ask(own & {"vehicle_page"}, code, beside, receipts)
        remove_results(vehicle, out, page)
        stages += page
        found.append(Due(vehicle, stages, plan, tuple(beside)))
    return tuple(found)


def has_page(vehicle: str, out: Path) -> bool:
    """Whether a vehicle has a page that fits what there is."""
    return (out / processed_file(vehicle, "vehicle_page")).is_file()


def workers_of(request: RunRequest) -> int:
    """Return how many processes may be at work side by side."""
    here_or_there = usable_cores() if request.profile is None else _WORKERS_ELSEWHERE
    return request.cores or here_or_there


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

    request: RunRequest
    due: tuple[Due, ...]
    state: Path
    known: KnownFiles
    profile: Path | None

    @property
    def vehicles(self) -> list[str]:
        """Names of the vehicles."""
        return [one.vehicle.name for one in self.due]

    def others(self) -> list[str]:
        """Return the vehicles with results from before, to which the index also leads."""
        receipts = (self.request.out / "processed").glob("*/vehicle_page.json")
        return sorted({one.parent.name for one in receipts} - set(self.vehicles))

    def run(self, jobs: Sequence[EngineJob], progress: Progress) -> bool:
        """Run the engine over these jobs."""
        request, config = self.request, self.state / "config.json"
        told = {"jobs": hand_over(jobs, request.out), "language": current()}
        write_atomically(config, json.dumps(told, indent=1))
        progress.total = sum(len(job.steps) for job in jobs)
        return start(config, request.out, request.cores, progress, profile=self.profile)

    def index_digest(self) -> str:
        """Digest of the index and of all that it was made from."""
        return index_digest(self.vehicles, self.others(), self.request.out)


def _bring_up_to_date(job: _Execution, progress: Progress) -> bool:
    """Run the engine; after a failure once more, so that the index leads to all that is whole."""
    request, out = job.request, job.request.out
    pages = not request.only
    changed = any(one.stages or (one.plan and one.plan.pending) for one in job.due)
    if not changed and (not pages or job.known.settled == job.index_digest()):
        (job.state / "journal.jsonl").unlink(missing_ok=True)
        return True
    others = job.others() if pages else None
    jobs = engine_jobs(job.due, out, workers_of(request), others)
    if job.run(jobs, progress):
        job.known.settled = job.index_digest() if pages else job.known.settled
        return True
    whole = [name for name in job.vehicles if has_page(name, out)]
    if whole and len(whole) < len(job.due) and pages:
        job.run(engine_jobs((), out, 1, [*whole, *job.others()]), progress)
    return False


def jobs_here(is_main: bool) -> dict[str, list[str]]:
    """Return the jobs of the vehicles under ``raw/`` and what each waits for.

    A process that the engine starts for one of them (not `is_main`) is told the same again.
    """
    told = Path(FOLDER, "waits.json")
    if not is_main:
        known: dict[str, list[str]] = json.loads(told.read_text(encoding="utf-8"))
        return known
    request = RunRequest()
    vehicles, _ = vehicles_to_run(request)
    due = due_of(vehicles, request, KnownFiles())
    waited = dict(hand_over(engine_jobs(due, Path(), workers_of(request), ()), Path()))
    write_atomically(told, json.dumps(waited))
    return waited
