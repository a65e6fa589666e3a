"""``rig2sea run``: check, sweep, start the engine, tell what happens, sum up."""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import InputError, Place, Problem
from pipeline.journal import Event
from pipeline.plan import VehicleFolder, choose, processed_file
from pipeline.provenance import unwritable, write_atomically
from pipeline.workflow.freshness import remove_stale
from pipeline.workflow.lock import only_run
from pipeline.workflow.outcome import Outcome, outcome_of
from pipeline.workflow.progress import Progress
from pipeline.workflow.start import start


@dataclass(frozen=True)
class Request:
    """What the user asked for."""

    vehicles: tuple[str, ...] = ()
    raw: Path = Path("raw")
    out: Path = Path()
    cores: int | None = None
    force: bool = False


@dataclass(frozen=True)
class Result:
    """How a run ended: `done` counts the stages that ran, `refused` what never became a vehicle."""

    vehicles: tuple[str, ...]
    refused: tuple[Problem, ...]
    outcomes: tuple[Outcome, ...]
    failed: tuple[Event, ...]
    done: int
    complete: bool

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
        When nothing can be done at all: no vehicle, an unwritable folder, another run at work.
    UsageError
        When a vehicle that was asked for does not exist.
    StoppedError
        When the run was stopped from outside.
    """
    state = request.out / "processed" / ".rig2sea"
    chosen, refused = choose(request.vehicles, request.raw, request.out)
    if not chosen and not refused:
        raise InputError.at(
            Place(str(request.raw)),
            "holds no vehicle.",
            expected="a folder for each vehicle: raw/<vehicle>/vehicle.yaml beside its load_test, "
            "mooring and open_water folders.",
            remedy="Put one there, or say where the raw folder is with --raw.",
        )
    with only_run(state / "lock"):
        _writable(request.out / "reports")
        sound, unsound = _sound(chosen, request.out)
        complete = True
        if sound:
            stale = [path for one in sound for path in remove_stale(one, request.out)]
            write_atomically(state / "swept.txt", "".join(f"{path}\n" for path in stale))
            complete = _bring_up_to_date(request, sound, state, progress)
        return Result(
            vehicles=tuple(vehicle.name for vehicle in sound),
            refused=refused + unsound,
            outcomes=tuple(outcome_of(vehicle, request.out) for vehicle in sound),
            failed=tuple(progress.failed),
            done=progress.done,
            complete=complete,
        )


def _writable(folder: Path) -> None:
    probe = folder / f".probe-{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise unwritable(folder, error) from error


def _sound(
    vehicles: Sequence[VehicleFolder], out: Path
) -> tuple[list[VehicleFolder], tuple[Problem, ...]]:
    """Separate the vehicles that can be run from the reasons why others cannot."""
    from pipeline.vehicle.load import load_vehicle

    sound: list[VehicleFolder] = []
    problems: list[Problem] = []
    for vehicle in vehicles:
        path = out / vehicle.vehicle_file
        try:
            load_vehicle(path)
            for top in ("processed", "reports"):
                _writable(out / top / vehicle.name)
        except InputError as error:
            problems.append(error.problem)
        else:
            sound.append(vehicle)
    return sound, tuple(problems)


def _bring_up_to_date(
    request: Request, vehicles: Sequence[VehicleFolder], state: Path, progress: Progress
) -> bool:
    """Run the engine; after a failure once more, so that the index leads to all that is whole."""
    config = state / "config.json"
    write_atomically(config, json.dumps(_config(request, vehicles), indent=1))
    if start(config, request.out, request.cores, progress, force=request.force):
        return True
    whole = [
        vehicle
        for vehicle in vehicles
        if (request.out / processed_file(vehicle.name, "vehicle_page")).is_file()
    ]
    if whole and len(whole) < len(vehicles):
        write_atomically(config, json.dumps(_config(request, whole), indent=1))
        start(config, request.out, request.cores, progress, force=False)
    return False


def _config(request: Request, vehicles: Sequence[VehicleFolder]) -> dict[str, object]:
    """Tell the Snakefile which vehicles are run, and which have results from earlier runs."""
    names = {vehicle.name for vehicle in vehicles}
    others = sorted(
        receipt.parent.name
        for receipt in (request.out / "processed").glob("*/vehicle_page.json")
        if receipt.parent.name not in names
    )
    return {"vehicles": {one.name: one.folder for one in vehicles}, "others": others}
