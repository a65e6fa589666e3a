"""The logs that a person names: found, read, and checked for what a fit needs."""

import difflib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.errors import InputError, Place
from pipeline.identify.channel_noise import QUANTITIES
from pipeline.ingest.log_files import LOG_SUFFIXES, logs_of
from pipeline.ingest.pool_run import read_pool_run, resample
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, with_known
from pipeline.plan import UsageError
from pipeline.provenance import file_digest
from pipeline.records.identification import RunRead
from pipeline.records.run_arrays import PoolRun
from pipeline.records.run_table import RunTable
from pipeline.vehicle.run_notes import BAG_FILE, notes_file, read_run_notes, run_of

#: Rate of the tables that the fits work on. [Hz]
RATE_HZ = 50.0
SHORTEST_S = 4.0


def find_logs(texts: Sequence[str], one: SimulatedVehicle) -> list[Path]:
    """Find the logs of runs: names under the vehicle's ``pool/``, files, or folders of files."""
    found: list[Path] = []
    for text in texts:
        found += _logs(text, one.file.parent / "pool", one.name)
    twice = {run_of(path) for path in found if found.count(path) > 1}
    if twice:
        raise UsageError(f"{', '.join(sorted(twice))} is named twice.")
    return found


def _logs(text: str, pool: Path, vehicle: str) -> list[Path]:
    logs = logs_of(pool)
    is_plain = "/" not in text and "\\" not in text
    named = [pool / text, *(log for log in logs if run_of(log) == text)] if is_plain else []
    for path in (*named, Path(text)):
        if path.is_file():
            return [path.resolve()]
        if path.is_dir():
            within = [one.resolve() for one in logs_of(path)]
            if within:
                return within
            raise UsageError(f"{path} is a folder without logs (*{', *'.join(LOG_SUFFIXES)}).")
    known = [run_of(path) for path in logs]
    near = difflib.get_close_matches(text, known, n=1)
    hint = f' Did you mean "{near[0]}"?' if near else ""
    there = f"There are {', '.join(known)}." if known else f"{pool} holds no logs."
    raise UsageError(f'{vehicle} has no run "{text}", and there is no such file.{hint} {there}')


def read_runs(
    texts: Sequence[str],
    one: SimulatedVehicle,
    raw: Path,
    tell: Callable[[str], None],
    without: Sequence[str] = (),
) -> list[tuple[RunRead, RunTable]]:
    """Find the logs of runs and read each, which is told before, as `find_logs` and `read_run`."""
    found = []
    for log in find_logs(texts, one):
        tell(f"reading {log.parent.name if log.name == BAG_FILE else log.name}")
        found.append(read_run(log, one, raw, without))
    return found


def read_run(
    path: Path, one: SimulatedVehicle, raw: Path, without: Sequence[str] = ()
) -> tuple[RunRead, RunTable]:
    """Read a log for the fits: on one time base, dead and unwanted channels left out.

    With what the notes of the run and the vehicle file's tether say of it (`with_known`).

    Raises `InputError` for a log that is none, is of another vehicle, too short, without commands,
    or without any measurement that a fit can use.
    """
    run = read_pool_run(path, one.vehicle, raw.resolve())
    place = Place(run.file)
    _of_this_vehicle(run, one, place)
    if run.duration_s < SHORTEST_S:
        raise InputError.at(
            place,
            f"the run is {run.duration_s:.1f} s long.",
            expected=f"at least {SHORTEST_S:g} s with commands; a minute is usual.",
            remedy="Give a longer run.",
        )
    table, warnings = _without_dead(resample(run, RATE_HZ, by_step=True), without)
    if "command" not in table.values or not table.valid["command"].any():
        raise InputError.at(
            place,
            "no thruster commands were found.",
            expected="a command for each thruster, as standard messages or as pool: of the vehicle "
            "file maps them.",
            remedy="See what `rig2sea check` says of the log's topics.",
        )
    usable = [name for name in QUANTITIES if name in table.values]
    if not usable:
        raise InputError.at(
            place,
            "no channel that a fit can use was measured.",
            expected=f"at least one of {', '.join(QUANTITIES)}, and not constant.",
            remedy="See what `rig2sea check` says of the log's topics.",
        )
    table = with_known(table, run.notes, one)
    told = [str(problem) for problem in run.problems if problem.severity != "note"]
    warnings = told + warnings + ([] if table.known is None else list(table.known.notes))
    read = RunRead(
        name=table.name,
        file=str(path),
        sha256=file_digest(path),
        seconds=round(float(table.time_s[-1]), 3),
        quantities=tuple(usable),
        warnings=tuple(dict.fromkeys((*warnings, *table.notes))),
    )
    return read, table


def healthy_runs(runs: Sequence[tuple[RunRead, RunTable]]) -> list[RunTable]:
    """Return the runs whose notes say ``healthy: true``."""
    found = []
    for read, table in runs:
        file = notes_file(Path(read.file))
        if file is not None and read_run_notes(file, str(file)).healthy is True:
            found.append(table)
    return found


def _of_this_vehicle(run: PoolRun, one: SimulatedVehicle, place: Place) -> None:
    """Refuse a log that says it is of another vehicle and has not this one's thrusters."""
    said = dict(run.metadata).get("rig2sea.log", {}).get("vehicle")
    named = {
        column.removeprefix("command.")
        for channel in run.channels.values()
        if channel.quantity == "thruster_command"
        for column in channel.columns
    }
    if said is not None and said != one.name and named != set(one.packed.thruster_names):
        raise InputError.at(
            place,
            f"the log is of the vehicle {said}, not of {one.name}.",
            expected=f"commands for {', '.join(one.packed.thruster_names)}.",
            remedy=f"Give a log of {one.name}, or the vehicle {said}.",
        )


def _without_dead(table: RunTable, without: Sequence[str]) -> tuple[RunTable, list[str]]:
    """Leave out channels that never change or are not wanted; say so where commands are still."""
    dead, warnings = list(without), []
    for quantity in (*QUANTITIES, "command"):
        if quantity not in table.values or quantity in without:
            continue
        measured = table.values[quantity]
        known = np.isfinite(measured).all(axis=1) & table.valid[quantity]
        values = measured[known]
        if values.size and np.ptp(values, axis=0).max() > 0.0:
            continue
        if quantity == "command":
            warnings.append(
                f"{table.name}: the commands never change, so thrust and drag cannot be told apart."
            )
        elif values.size:
            dead.append(quantity)
            warnings.append(f"{table.name}: {quantity} never changes and is left out.")
        else:
            dead.append(quantity)
            if np.isfinite(measured[table.valid[quantity]]).any():
                warnings.append(
                    f"{table.name}: {quantity} has no reading with all of its components and is "
                    "left out."
                )
    kept = {name: values for name, values in table.values.items() if name not in dead}
    valid = {
        # a reading that lacks a component is none
        name: flags & np.isfinite(kept[name]).all(axis=1) if name in QUANTITIES else flags
        for name, flags in table.valid.items()
        if name not in dead
    }
    reading = {name: marks for name, marks in table.reading.items() if name not in dead}
    off_row = {name: off for name, off in table.off_row.items() if name not in dead}
    return replace(table, values=kept, valid=valid, reading=reading, off_row=off_row), warnings
