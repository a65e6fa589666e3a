"""``rig2sea why`` of a number of vehicle.yaml: its interval, and the change that it is from."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.inputs.vehicle_changes import changes_of
from pipeline.inputs.vehicle_place import find_vehicle
from pipeline.plan import VEHICLE_FILE, UsageError
from pipeline.provenance import UNREADABLE, file_digest
from pipeline.records.file_change import AppliedChange
from pipeline.vehicle.change_list import value_at
from pipeline.vehicle.estimates import Estimate, estimates_of
from pipeline.vehicle.load import load_checked
from pipeline.vehicle.schema import Vehicle

#: Sections of a vehicle file that a path may begin with.
_SECTIONS = frozenset({"water", "propellers", "drives", "thrusters", "model", "sensors"})
_DIGITS = 12


@dataclass(frozen=True)
class StatedNumber:
    """A number of the vehicle file; `change` is the entry of the list that wrote it, if one did."""

    vehicle: str
    file: Path
    path: str
    value: object
    estimate: Estimate | None
    change: AppliedChange | None
    source_now: str
    """Digest now of the result that the change is from."""


def why_stated(vehicle: str, words: Sequence[str], raw: Path, out: Path) -> StatedNumber | None:
    """Find a number of the vehicle file; None where the words do not begin as one of its paths.

    Thrusters may be named in place of their number: ``thrusters.upper.gain_ahead``.

    Raises
    ------
    UsageError
        When there is no such number.
    InputError
        When the file or its list of changes cannot be read.
    """
    parts = [part for word in words for part in re.split(r"[.\[\]]+", word) if part]
    if not parts or parts[0] not in _SECTIONS:
        return None
    name, file = find_vehicle(vehicle, raw, out)
    stated = load_checked(file, Vehicle, expected=f"a {VEHICLE_FILE}.", remedy="")
    numbers = {one.name: str(index) for index, one in enumerate(stated.thrusters)}
    if parts[0] == "thrusters" and len(parts) > 1:
        parts[1] = numbers.get(parts[1], parts[1])
    path = ".".join(parts)
    value = value_at(stated.model_dump(), path)
    if value is None or isinstance(value, dict | list | tuple):
        raise UsageError(
            f"{file} has no number {path}. Expected the path of one, such as "
            "thrusters.upper.gain_ahead or model.damping.linear[0]."
        )
    held = [one for one in changes_of(file) if not one.undone_utc]
    wrote = [one for one in held if any(change.path == path for change in one.changes)]
    change = wrote[-1] if wrote else None
    now = UNREADABLE if change is None else file_digest(out / change.source)
    return StatedNumber(name, file, path, value, estimates_of(file).get(path), change, now)


def stated_text(found: StatedNumber) -> str:
    """Return what is printed."""
    lines = [f"{found.path} = {found.value} in {found.file}"]
    own, change = found.estimate, found.change
    if own is not None and own.ci95 is not None:
        lines.append(f"  95 % interval: {own.ci95[0]:.6g} to {own.ci95[1]:.6g}")
    if own is not None and own.source:
        lines.append(f"  from: {own.source}")
    if change is None:
        lines.append("  no change of the list wrote it: it is the engineer's, or a default")
        return "\n".join(lines)
    before = next(one for one in change.changes if one.path == found.path)
    lines.append(f"  before: {before.old}; changed {change.date_utc} UTC by rig2sea apply")
    same = found.source_now == change.source_sha256
    state = "as it was read" if same else "CHANGED since, or gone"
    lines.append(f"  {change.source}: sha256 {change.source_sha256[:_DIGITS]}, {state}")
    lines.append(f"  runs: {', '.join(change.runs)}")
    was = change.before_sha256[:_DIGITS]
    lines.append(f"  {change.former}: the file of before, sha256 {was}")
    return "\n".join(lines)
