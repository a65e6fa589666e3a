"""What a person compares: a day, runs, a bench file or part of it, a vehicle; found and read."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.bundled.vehicles import bundled_vehicles
from pipeline.control.inverse import firmware_grid
from pipeline.errors import CannotComputeError, InputError
from pipeline.ingest.log_files import LOG_SUFFIXES, day_of, logs_of
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.inputs.runs_to_identify import read_runs
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_inverse, load_simulated
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import POOL, VEHICLE_FILE, UsageError, discover
from pipeline.records.comparison import CodeChange, Curve, Difference, Side
from pipeline.records.measurements import MooringPoint
from pipeline.records.pool_run import RunNotes
from pipeline.records.run_table import RunTable
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.run_notes import BAG_FILE, notes_file, read_run_notes, run_of
from pipeline.vehicle.schema import Vehicle

_DAY = re.compile(r"\d{4}-\d\d-\d\d")
_VOLTS = re.compile(r"(\d+(?:\.\d+)?) ?[vV]")
_TABLES = (".csv", ".tsv", ".txt", ".xlsx", ".xlsm", ".xls", ".ods")
_VOLTAGE_APART = 0.5
_EXPECTED = (
    "Expected a day (2024-05-14), a run, a log, a bench file, a vehicle or its vehicle.yaml; of a "
    "bench file or a vehicle's bench files also one voltage or thruster, NAME@12V or NAME@left."
)


@dataclass(frozen=True)
class FoundSide:
    """One side, read: the runs of a vehicle, points of the bench, or a vehicle file."""

    side: Side
    vehicle: Vehicle
    one: SimulatedVehicle | None = None
    runs: tuple[RunTable, ...] = ()
    notes: tuple[RunNotes | None, ...] = ()
    digests: frozenset[str] = frozenset()
    points: tuple[MooringPoint, ...] = ()


def find_side(
    text: str, vehicle: str | None, raw: Path, out: Path, tell: Callable[[str], None]
) -> FoundSide:
    """Find and read what a text names, of `vehicle` where it does not say of which."""
    name, _, part = text.partition("@")
    path = Path(name)
    if path.is_file() and path.name != VEHICLE_FILE:
        return _file(text, path, part, vehicle, (raw, out), tell)
    if path.name == VEHICLE_FILE or (path / VEHICLE_FILE).is_file():
        folder = path.parent if path.name == VEHICLE_FILE else path
        return _vehicle(text, str(folder), raw, out, part)
    if name == vehicle or (not _DAY.fullmatch(name) and name in _vehicles(raw, out)):
        return _vehicle(text, name, raw, out, part)
    holds = _logs_of(name, vehicle, raw, out)
    if len(holds) > 1:
        raise UsageError(f'"{name}" is of {", ".join(holds)}; name one with --vehicle.')
    for owner, logs in holds.items():
        return _runs(text, owner, logs, (raw, out), tell)
    if "/" not in name and (not vehicle or name in bundled_vehicles()):
        return _vehicle(text, name, raw, out, part)  # a bundled one, or the words that it is none
    raise UsageError(f'there is no "{name}". {_EXPECTED}')


def _file(  # noqa: PLR0917 - what `find_side` was given
    text: str,
    path: Path,
    part: str,
    vehicle: str | None,
    folders: tuple[Path, Path],
    tell: Callable[[str], None],
) -> FoundSide:
    """Read a log or a bench file."""
    above = (str(one) for one in path.resolve().parents if (one / VEHICLE_FILE).is_file())
    owner = vehicle or next(above, None)
    if owner is None:
        raise UsageError(
            f"{path}: of which vehicle is it? There is no {VEHICLE_FILE} in the folders above; "
            "name it with --vehicle."
        )
    if path.suffix.lower() in LOG_SUFFIXES or path.name == BAG_FILE:
        return _runs(text, owner, [str(path)], folders, tell)
    if path.suffix.lower() in _TABLES:
        return _bench(text, find_vehicle(owner, *folders)[1], [path], part)
    raise UsageError(f"{path} is neither a log nor a bench file. {_EXPECTED}")


def _logs_of(name: str, vehicle: str | None, raw: Path, out: Path) -> dict[str, list[str]]:
    """Find the logs of a day or run, by the vehicles that have some: DAY, or VEHICLE/DAY."""
    before, _, last = name.rpartition("/")
    owners = [before] if before else [vehicle] if vehicle else _vehicles(raw, out)
    holds: dict[str, list[str]] = {}
    for owner in owners:
        _, file = find_vehicle(owner, raw, out)
        logs = logs_of(file.parent / POOL)
        own = [log for log in logs if last in {log.name, run_of(log)}]
        if not own and _DAY.fullmatch(last):
            own = [log for log in logs if day_of(log) == last]
        if own:
            holds[owner] = [str(log) for log in own]
    return holds


def _vehicles(raw: Path, out: Path) -> list[str]:
    return [one.name for one in discover(raw, out)[0]]


def _runs(
    text: str, owner: str, logs: list[str], folders: tuple[Path, Path], tell: Callable[[str], None]
) -> FoundSide:
    raw, out = folders
    one = load_simulated(owner, raw, out)
    read = read_runs(logs, one, raw, tell)
    files = [notes_file(Path(run.file)) for run, _ in read]
    notes = tuple(None if file is None else read_run_notes(file, str(file)) for file in files)
    holds = tuple(f"{run.name}, {run.seconds:.0f} s" for run, _ in read)
    return FoundSide(
        Side(name=text, kind="runs", vehicle=one.name, holds=holds),
        one.vehicle,
        one,
        tuple(table for _, table in read),
        notes,
        frozenset(run.sha256 for run, _ in read),
    )


def _vehicle(text: str, name: str, raw: Path, out: Path, part: str) -> FoundSide:
    name, file = find_vehicle(name, raw, out)
    if part:
        folder = file.parent / "mooring"
        files = sorted(p for p in folder.glob("*") if p.suffix.lower() in _TABLES)
        if not files:
            raise UsageError(f"{name} has no bench file under {folder}, of which {part} could be.")
        return _bench(text, file, files, part)
    side = Side(name=text, kind="vehicle", vehicle=name, holds=(str(file),))
    return FoundSide(side, load_vehicle(file))


def _bench(text: str, vehicle_file: Path, files: list[Path], part: str) -> FoundSide:
    vehicle = load_vehicle(vehicle_file)
    record = read_mooring_tables(files, vehicle, files[0].parent)
    refused = [str(one) for one in record.problems if one.severity == "error"]
    points = [point for point in record.points if not point.marks]
    volts = _VOLTS.fullmatch(part)
    if volts:
        wanted = float(volts[1])
        apart = ((p, abs(p.voltage_v - wanted)) for p in points if p.voltage_v is not None)
        points = [point for point, by in apart if by <= _VOLTAGE_APART]
    elif part:
        points = [point for point in points if point.thruster == part]
    if not points:
        volts_there = {round(p.voltage_v) for p in record.points if p.voltage_v is not None}
        there = [f"{one:g}V" for one in sorted(volts_there)]
        there += sorted({p.thruster for p in record.points if p.thruster})
        listed = ", ".join(there) or "no point that can be used"
        why = refused[0] if refused else f"There is {listed}."
        raise UsageError(f"{text}: no point of the bench files is that. {why}")
    supply = sorted({round(p.voltage_v, 1) for p in points if p.voltage_v is not None})
    holds = [f"{len(points)} readings of {', '.join(path.name for path in files)}"]
    if len(supply) == 1:
        holds.append(f"supply {supply[0]:g} V")
    elif supply:
        holds.append(f"supply {supply[0]:g} to {supply[-1]:g} V")
    side = Side(name=text, kind="bench", vehicle=vehicle.name, holds=tuple(holds))
    return FoundSide(side, vehicle, points=tuple(points))


def vehicle_differences(first: FoundSide, second: FoundSide, out: Path) -> dict[str, Any]:
    """Compare what vehicle files state, and codes of their tables; fields of the `Comparison`."""
    stated = [dict(_leaves(found.vehicle.model_dump())) for found in (first, second)]
    differences = []
    for key in dict.fromkeys([*stated[0], *stated[1]]):
        a, b = stated[0].get(key), stated[1].get(key)
        if a == b:
            continue
        ratio = b / a if a is not None and b is not None and a * b > 0.0 else None
        share = f", {ratio:.3g} times" if ratio is not None else ""
        shown = ["not stated" if one is None else f"{one:g}" for one in (a, b)]
        differences.append(
            Difference(
                kind="stated",
                what=key,
                unit="",
                a=a,
                b=b,
                ratio=ratio,
                text=f"{key}: {shown[0]} in A, {shown[1]} in B{share}.",
            )
        )
    codes, count, curve, why = _codes(first, second, out)
    return {
        "cautions": why,
        "differences": tuple(differences),
        "codes": codes,
        "codes_compared": count,
        "curves": curve,
    }


def _leaves(value: object, at: str = "") -> Iterator[tuple[str, float]]:
    """Yield every number that a file states, by its key."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in {"name", "published"}:
                yield from _leaves(inner, f"{at}.{key}" if at else str(key))
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            label = inner.get("name") if isinstance(inner, dict) else None
            yield from _leaves(inner, f"{at}[{label or number}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield at, float(value)


def _codes(
    first: FoundSide, second: FoundSide, out: Path
) -> tuple[tuple[CodeChange, ...], int, tuple[Curve, ...], tuple[str, ...]]:
    """Compare the codes at rest of both sides' tables, at 201 thrusts that both reach."""
    grids = []
    for found in (first, second):
        try:
            grids.append(firmware_grid(load_inverse(found.side.vehicle, out)))
        except (InputError, CannotComputeError, OSError):
            why = f"{found.side.vehicle} has no tables, so no codes are compared."
            return (), 0, (), (why,)
    limits = [grid.limits(0.0) for grid in grids]
    thrust = np.linspace(
        -min(one.reverse_n for one in limits), min(one.forward_n for one in limits), 201
    )
    a, b = (np.asarray(grid.code(thrust, 0.0), float) for grid in grids)
    changed = tuple(
        CodeChange(thrust_n=float(t), a=int(x), b=int(y))
        for t, x, y in zip(thrust, np.rint(a), np.rint(b), strict=True)
        if x != y
    )
    values = [tuple(one.tolist()) for one in (thrust, a, b)]
    curve = Curve(
        title="Code against thrust at rest",
        x_label="thrust  [N]",
        y_label="control code",
        points=False,
        a_x=values[0],
        a_y=values[1],
        b_x=values[0],
        b_y=values[2],
    )
    return changed, thrust.size, (curve,), ()
