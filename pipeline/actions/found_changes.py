"""A diagnosis or an identification as changes of the vehicle file, each with its interval."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from pipeline.effects.library import apply_effects, effects
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.identify.corrected_file import file_changes
from pipeline.inputs.simulated_vehicle import SimulatedVehicle
from pipeline.plan import VEHICLE_FILE
from pipeline.provenance import write_atomically
from pipeline.records.base import FileChange
from pipeline.records.diagnosis import RankedEffect
from pipeline.records.identification import VehicleIdentification
from pipeline.simulate.context import model_of
from pipeline.simulate.unpack import changed_keys
from pipeline.vehicle.change_list import listed_changes
from pipeline.vehicle.frames import Change, changes_as_stated
from pipeline.vehicle.load import load_checked
from pipeline.vehicle.schema import Vehicle


def as_stated(one: SimulatedVehicle) -> Vehicle:
    """Read the vehicle in the axes of its own file."""
    return load_checked(one.file, Vehicle, expected=f"a {VEHICLE_FILE}.", remedy="")


def source_of(runs: Sequence[str], kind: str = "diagnosis") -> str:
    """Say in a line what numbers are from; of many runs the first ones.

    >>> source_of(["a", "b", "c", "d"])
    'diagnosis of a, b and 2 more'
    """
    some = list(runs)[:2] if len(runs) > 3 else list(runs)
    more = f" and {len(runs) - len(some)} more" if len(runs) > len(some) else ""
    return f"{kind} of {', '.join(some)}{more}"


def diagnosed_changes(
    one: SimulatedVehicle, top: RankedEffect | None, specs: Sequence[EffectSpec]
) -> tuple[FileChange, ...]:
    """List what the effects of a verdict change; their intervals are those of its entry `top`."""

    def changes(now: Sequence[EffectSpec]) -> dict[str, Change]:
        vector = apply_effects(one.packed.vector, now, one.packed.context)
        found = changed_keys(one.vehicle, model_of(one.vehicle), one.packed, vector)
        return changes_as_stated(found, one.vehicle.frame)

    ends = []
    known_of = {} if top is None else top.parameters
    for index, spec in enumerate(specs):
        known = {parameter.name: parameter for parameter in effects()[spec.id].parameters}
        for name, value in spec.values.items():
            own = known_of.get(f"{spec.id}.{name}", known_of.get(name))
            if own is None or not own.ci95[0] < own.ci95[1]:
                continue
            pair = []
            for end in own.ci95:
                low, high = known[name].possible
                moved = min(max(value + end - own.value, low), high)
                other = replace(spec, values={**spec.values, name: moved})
                # what leaves no valid vehicle bounds nothing
                with suppress(CannotComputeError):
                    pair.append(changes([*specs[:index], other, *specs[index + 1 :]]))
            if len(pair) == 2:
                ends.append((pair[0], pair[1]))
    return listed_changes(as_stated(one), changes(specs), ends)


def ranked_specs(ranked: RankedEffect) -> tuple[EffectSpec, ...]:
    """Return the effects of an entry of a ranking as they are switched on."""
    specs = []
    for effect in ranked.effect.split("+"):
        alone, own = f"{effect}.", {}
        for name, found in ranked.parameters.items():
            if name.startswith(alone) or "." not in name:
                own[name.removeprefix(alone)] = found.value
        of_one = effects()[effect].scope == "thruster"
        target = ranked.thrusters.get(effect, ranked.thruster if of_one else None)
        specs.append(EffectSpec(effect, own, target))
    return tuple(specs)


def identified_changes(
    one: SimulatedVehicle, whole: VehicleIdentification
) -> tuple[FileChange, ...]:
    """List what an identification changes."""
    model = model_of(one.vehicle)

    def changes(now: VehicleIdentification) -> dict[str, Change]:
        return file_changes(one.vehicle, model, one.packed, now.parameters, now.thrust)

    def moved(kind: str, k: int, by: float) -> dict[str, Change]:
        every = getattr(whole, kind)
        value = every[k].value if every[k].file_value is None else every[k].file_value
        other = every[k].model_copy(update={"file_value": value + by})
        return changes(whole.model_copy(update={kind: (*every[:k], other, *every[k + 1 :])}))

    ends = [
        (moved(kind, k, own.ci95[0] - own.value), moved(kind, k, own.ci95[1] - own.value))
        for kind in ("parameters", "thrust")
        for k, own in enumerate(getattr(whole, kind))
        if own.file_value is not None or kind == "parameters"
    ]
    return listed_changes(as_stated(one), changes(whole), ends)


def write_corrected(file: Path, one: SimulatedVehicle, text: str | None) -> Path | None:
    """Write a corrected vehicle file, not over the engineer's own; None removes an old one."""
    if text is None:
        file.unlink(missing_ok=True)  # it would pass for this one's
        return None
    if file.exists() and file.samefile(one.file):
        raise CannotComputeError(f"{file} is the vehicle file itself; choose another folder (--to)")
    write_atomically(file, text)
    return file
