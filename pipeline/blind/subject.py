"""A vehicle that cases are made of: its file as text, and what its bench gave."""

import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.blind.truth.faults import FAULTS, OF_MEASUREMENT
from pipeline.records.fits import StaticCharacteristic
from pipeline.vehicle.load import VEHICLE_FILE, load_vehicle
from pipeline.vehicle.schema import Vehicle


@dataclass(frozen=True)
class BlindSubject:
    """A vehicle file, as text and as read; `static` is the bench's family, where there is one.

    Two are the same where their texts are.
    """

    name: str
    text: str
    vehicle: Vehicle = field(compare=False)
    static: StaticCharacteristic | None = field(default=None, compare=False)


def subject_from(folder: Path, static: StaticCharacteristic | None = None) -> BlindSubject:
    """Read the vehicle file of a folder.

    A tether of the nominal model is taken out: no simulation of the package has it.
    """
    file = folder / VEHICLE_FILE if folder.is_dir() else folder
    text = file.read_text(encoding="utf-8")
    vehicle = load_vehicle(file)
    subject = BlindSubject(vehicle.name, text, vehicle, static)
    tether = vehicle.model.tether if vehicle.model is not None else None
    if tether is not None and tether.in_nominal:
        return _edited(subject, "tether", "in_nominal", "false")
    return subject


def variant_for(subject: BlindSubject, effect: str) -> BlindSubject:
    """Return the vehicle with a nominal model that lacks the term which the effect names.

    Of other effects it is the vehicle itself.
    """
    model = subject.vehicle.model
    if model is None:
        return subject
    if effect == "coriolis_omitted" and model.terms.coriolis:
        return _edited(subject, "terms", "coriolis", "false")
    if effect == "advance_speed_loss" and model.terms.thrust_falls_with_speed:
        return _edited(subject, "terms", "thrust_falls_with_speed", "false")
    return subject


def possible_effects(subject: BlindSubject) -> tuple[str, ...]:
    """Effects that a vehicle, or a variant of it, can have and that its sensors could show."""
    model, sensors = subject.vehicle.model, subject.vehicle.sensors
    out = []
    for effect in FAULTS:
        if model is None or sensors is None:
            continue
        if effect in OF_MEASUREMENT and sensors.dvl is None:
            continue
        if effect == "wall_effect" and model.pool is None:
            continue
        if effect == "crossflow_coupling" and (
            model.crossflow is None or model.crossflow.in_nominal
        ):
            continue
        if effect == "thruster_lag" and any(d.balance_in_time for d in model.thrusters.values()):
            continue
        out.append(effect)
    return tuple(out)


def _edited(subject: BlindSubject, section: str, key: str, value: str) -> BlindSubject:
    """Change one key of one section of `model:` in the text, and read it again."""
    lines = subject.text.splitlines(keepends=True)
    inside = in_model = False
    for i, line in enumerate(lines):
        if re.match(r"^\S", line):
            in_model = line.startswith("model:")
        if re.match(r"^  \S", line) and not line.lstrip().startswith("#"):
            inside = in_model and line.startswith(f"  {section}:")
        if inside and re.match(rf"^\s+{key}:", line):
            lines[i] = re.sub(rf"({key}:\s*)\w+", rf"\g<1>{value}", line)
    text = "".join(lines)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / VEHICLE_FILE).write_text(text, encoding="utf-8")
        vehicle = load_vehicle(Path(folder))
    return BlindSubject(subject.name, text, vehicle, subject.static)
