"""``rig2sea compare``: two sides -> whether they can be compared, what differs, the page."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.actions.comparison_sides import FoundSide, find_side, vehicle_differences
from pipeline.errors import CannotComputeError
from pipeline.identify.bench_changes import bench_changes
from pipeline.identify.run_changes import RunChange, changes_between
from pipeline.provenance import write_record
from pipeline.records.comparison import Comparison, Curve, Difference
from pipeline.records.pool_run import RunNotes
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.sensor_schema import Sensors

RESULT, PAGE = "comparison.json", "comparison.html"
#: A supply that differs by more makes another thruster of the same one. [1]
_SUPPLY = 0.1
#: Share of its range by which a thruster is commanded, at least, to say anything of it.
_EXCITED = 0.02
#: Ballast of which nobody says what it displaces, as a share of the vehicle's mass.
_BALLAST = 0.005
_DENSITY_KGPM3 = 2.0
#: Quantity -> its columns that are drawn, with the name of their axis.
_CURVES = {
    "velocity": ((0, "u  [m/s]"), (2, "w  [m/s]")),
    "angular_velocity": ((1, "q  [deg/s]"), (2, "r  [deg/s]")),
    "depth": ((0, "depth  [m]"),),
}


def compare(  # noqa: PLR0917 - what the command is given
    a: str, b: str, vehicle: str | None, raw: Path, out: Path, tell: Callable[[str], None]
) -> Comparison:
    """Compare two sides, B against A."""
    first, second = (find_side(text, vehicle, raw, out, tell) for text in (a, b))
    found = Comparison(a=first.side, b=second.side, comparable=True)
    kinds = {"runs": "runs", "bench": "readings of the bench", "vehicle": "a vehicle file"}
    if first.side.kind != second.side.kind:
        why = f"A is {kinds[first.side.kind]}, B is {kinds[second.side.kind]}."
        return _finished(found, why_not=(why,))
    try:
        if first.side.kind == "runs":
            return _runs(found, first, second, tell)
        if first.side.kind == "bench":
            return _bench(found, first, second)
        return _finished(found, **vehicle_differences(first, second, out))
    except CannotComputeError as error:
        return _finished(found, why_not=(str(error),))


def write_comparison(record: Comparison, to: Path, assets: Path) -> tuple[Path, Path]:
    """Write the JSON and the page; returns both."""
    from pipeline.report.comparison_page import comparison_page
    from pipeline.report.html import placed, write_page

    write_record(to / RESULT, record)
    page = to / PAGE
    write_page(comparison_page(record, placed(assets, page)), page)
    return to / RESULT, page


def _finished(record: Comparison, **more: Any) -> Comparison:  # noqa: ANN401 - fields
    """Fill in what was found, and the sentence that says it."""
    record = record.model_copy(update=more)
    if record.why_not:
        verdict = "They cannot be compared: " + " ".join(record.why_not)
    elif record.differences:
        verdict = " ".join(one.text for one in record.differences)
    elif record.codes:
        verdict = "The codes of the firmware tables differ; nothing else does."
    else:
        verdict = "Nothing differs."
    return record.model_copy(update={"comparable": not record.why_not, "verdict": verdict})


def _runs(
    record: Comparison, first: FoundSide, second: FoundSide, tell: Callable[[str], None]
) -> Comparison:
    one, other = first.one, second.one
    assert one is not None  # noqa: S101 - runs have a vehicle
    assert other is not None  # noqa: S101 - runs have a vehicle
    if one.packed.thruster_names != other.packed.thruster_names:
        why = f"A is of {one.name}, B of {other.name}: other thrusters."
        return _finished(record, why_not=(why,))
    if first.digests == second.digests:
        return _finished(record, cautions=("The same logs stand on both sides.",))
    shared = first.digests & second.digests
    if shared:
        why = f"{len(shared)} of the logs stand on both sides; each can only be on one."
        return _finished(record, why_not=(why,))
    why_not, cautions = conditions_apart(first, second)
    commands = [_excited(found.runs, one.packed) for found in (first, second)]
    both = [name for name in one.packed.thruster_names if all(name in c for c in commands)]
    only = [
        f"{name} was commanded in {'A' if name in commands[0] else 'B'} alone."
        for name in one.packed.thruster_names
        if (name in commands[0]) != (name in commands[1])
    ]
    if not both:
        lazy = [side for side, own in zip("AB", commands, strict=True) if not own]
        why_not.append(
            f"in {' and '.join(lazy)} no thruster was commanded enough to say anything."
            if lazy
            else "no thruster was commanded in both."
        )
    if why_not:
        return _finished(record, why_not=tuple(why_not), cautions=tuple(cautions))
    tell(f"fitting {len(first.runs) + len(second.runs)} runs together")
    names = tuple(run.name for run in (*first.runs, *second.runs))
    found = changes_between(
        one.packed,
        one.vehicle.sensors or Sensors(),
        first.runs,
        second.runs,
        model_of(one.vehicle).uncertainty,
    )
    told = [_told(change, names, len(first.runs)) for change in found.asked]
    standing = [_told(change, names, len(first.runs)) for change in found.changes]
    return _finished(
        record,
        cautions=(*cautions, *only),
        differences=tuple(standing),
        asked=tuple(told),
        curves=_run_curves(first.runs, second.runs, [w for one in standing for w in one.where]),
    )


def _told(change: RunChange, names: Sequence[str], count: int) -> Difference:
    """Say a shift: what the runs concerned have, against what the others have."""
    shift, base = change.shift, change.base
    where = tuple(names[run] for run in shift.runs)
    value = base + change.value
    half = 1.96 * change.std
    gain = shift.kind != "parameter"
    ratio = value / base if gain and base > 0.0 else None
    side = "A" if shift.runs[0] < count else "B"
    of = "all of B" if shift.runs == tuple(range(count, len(names))) else ", ".join(where)
    if ratio is not None:
        ci = (ratio - half / base, ratio + half / base)
        share = f"{100 * ratio:.0f} % ({100 * ci[0]:.0f} to {100 * ci[1]:.0f} %)"
        text = (
            f"All thrusters together give {share} of the thrust that the other runs show, in {of}."
            if shift.kind == "all_thrusters"
            else f"The {shift.name} thruster gives {share} of the thrust that the other runs "
            f"show, in {of}."
        )
    else:
        ci = (change.value - half, change.value + half)
        name, unit = shift.name.replace("_", " "), shift.unit
        text = (
            f"{name[:1].upper()}{name[1:]} is {value:.3g} {unit} in {of}, {base:.3g} {unit} in the "
            f"other runs (difference {ci[0]:.2g} to {ci[1]:.2g})."
        )
    before, after = (base, value) if side == "B" else (value, base)
    return Difference(
        kind=shift.kind,
        what=shift.name,
        where=where,
        unit=shift.unit,
        a=before,
        b=after,
        ratio=ratio,
        ci95=ci,
        p_value=change.p_value,
        text=text,
    )


def conditions_apart(first: FoundSide, second: FoundSide) -> tuple[list[str], list[str]]:
    """Say what of the conditions forbids a comparison, and what to keep in mind.

    What the model is told (ballast with its volume, density, a cable of known length) is counted
    and only said. What nobody can count forbids it.
    """
    why_not: list[str] = []
    cautions: list[str] = []
    supply = [_supply_v(found) for found in (first, second)]
    if supply[0] is not None and supply[1] is not None:
        ratio = supply[1] / supply[0]
        text = f"the supply was {supply[0]:.3g} V in A and {supply[1]:.3g} V in B"
        if abs(ratio - 1.0) > _SUPPLY:
            why_not.append(f"{text}: every thruster is another one at that.")
        elif abs(ratio - 1.0) > _SUPPLY / 5.0:
            cautions.append(f"{text[0].upper()}{text[1:]}; a common factor would be no surprise.")
    loose = [_loose_ballast_kg(found) for found in (first, second)]
    model = model_of(first.vehicle)
    if abs(loose[1] - loose[0]) > _BALLAST * model.rigid_body.mass_kg:
        why_not.append(
            f"ballast of which the notes do not say what it displaces: {loose[0]:.3g} kg in A, "
            f"{loose[1]:.3g} kg in B. State displaced_kg in the notes, and it is counted."
        )
    water = [_water(found) for found in (first, second)]
    kinds = [{kind for kind, _ in own if kind} for own in water]
    density = [[rho for _, rho in own if rho] for own in water]
    if all(kinds) and kinds[0] != kinds[1] and not all(density):
        a, b = (" and ".join(sorted(own)) for own in kinds)
        why_not.append(
            f"the water was {a} in A and {b} in B, and its density is not in the notes of both."
        )
    elif all(density) and abs(np.mean(density[0]) - np.mean(density[1])) > _DENSITY_KGPM3:
        a, b = (f"{np.mean(own):.0f}" for own in density)
        cautions.append(f"The water had {a} kg/m3 in A and {b} in B; that is counted.")
    cable = [
        {note.tether.attached for note in _notes(found) if note.tether} for found in (first, second)
    ]
    if all(cable) and cable[0] != cable[1]:
        text = "a tether was attached in one and not in the other"
        if model.tether is not None:
            cautions.append(f"{text[0].upper()}{text[1:]}; the one of the vehicle file is counted.")
        else:
            why_not.append(f"{text}, and the vehicle file has none to count.")
    return why_not, cautions


def _notes(found: FoundSide) -> Iterator[RunNotes]:
    return (note for note in found.notes if note is not None)


def _supply_v(found: FoundSide) -> float | None:
    """Mean supply of the runs, as measured or as noted [V]."""
    values = []
    for table, note in zip(found.runs, found.notes, strict=True):
        if "voltage" in table.values and table.valid["voltage"].any():
            values.append(float(np.nanmean(table.values["voltage"][table.valid["voltage"]])))
        elif note is not None and note.battery_v is not None:
            values.append(note.battery_v)
    return float(np.mean(values)) if values else None


def _loose_ballast_kg(found: FoundSide) -> float:
    """Largest ballast of a run whose volume nobody states [kg]."""
    loose = [
        sum(i.mass_kg for i in note.ballast if i.displaced_kg is None and i.volume_m3 is None)
        for note in _notes(found)
    ]
    return max(loose, key=abs, default=0.0)


def _water(found: FoundSide) -> list[tuple[str | None, float | None]]:
    return [(n.water.kind, n.water.density_kgpm3) for n in _notes(found) if n.water is not None]


def _excited(runs: Sequence[RunTable], packed: PackedVehicle) -> set[str]:
    """Thrusters whose command moved in a run."""
    least = _EXCITED * np.abs(packed.code_limits).max(axis=1)
    moved = [np.nanstd(table.values["command"], axis=0) > least for table in runs]
    return {
        name
        for name, any_ in zip(packed.thruster_names, np.any(moved, axis=0), strict=True)
        if any_
    }


def _run_curves(
    first: Sequence[RunTable], second: Sequence[RunTable], concerned: Sequence[str]
) -> tuple[Curve, ...]:
    """Motion of a run of each side over each other: of one manoeuvre, where their names say so."""

    def manoeuvre(name: str) -> str:
        return name.lstrip("0123456789-_ T")

    pairs = [(a, b) for a in first for b in second if manoeuvre(a.name) == manoeuvre(b.name)] or [
        (first[0], second[0])
    ]
    a, b = max(pairs, key=lambda pair: sum(run.name in concerned for run in pair))
    found = []
    for quantity, columns in _CURVES.items():
        if quantity not in a.values or quantity not in b.values:
            continue
        for column, label in columns:
            ends = [_thin(run, quantity, column) for run in (a, b)]
            found.append(
                Curve(
                    title=f"{a.name} and {b.name}",
                    x_label="time from the first reading  [s]",
                    y_label=label,
                    points=False,
                    a_x=ends[0][0],
                    a_y=ends[0][1],
                    b_x=ends[1][0],
                    b_y=ends[1][1],
                )
            )
    return tuple(found)


def _thin(run: RunTable, quantity: str, column: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    valid = run.valid[quantity] & np.isfinite(run.values[quantity][:, column])
    rows = np.flatnonzero(valid)[:: max(int(valid.sum()) // 800, 1)]
    time, value = run.time_s[rows].round(3), run.values[quantity][rows, column]
    if quantity == "angular_velocity":
        value = np.degrees(value)
    value = value.round(5)
    return tuple(time.tolist()), tuple(value.tolist())


def _bench(record: Comparison, first: FoundSide, second: FoundSide) -> Comparison:
    """Compare readings of the bench."""
    a, b = first.vehicle.drive, second.vehicle.drive
    if (a.code_min, a.code_max) != (b.code_min, b.code_max):
        return _finished(record, why_not=("their codes have other ranges.",))
    if [p.model_dump() for p in first.points] == [p.model_dump() for p in second.points]:
        return _finished(record, cautions=("The same readings stand on both sides.",))
    volts = [
        np.mean([p.voltage_v for p in found.points if p.voltage_v is not None] or [np.nan])
        for found in (first, second)
    ]
    cautions = []
    if abs(volts[1] / volts[0] - 1.0) > _SUPPLY / 5.0:
        cautions.append(
            f"The supply was {volts[0]:.3g} V in A and {volts[1]:.3g} V in B: a common factor is "
            "what that gives."
        )
    standing, asked, curves = bench_changes(first.points, second.points)
    return _finished(
        record, cautions=tuple(cautions), differences=standing, asked=asked, curves=curves
    )
