"""``rig2sea export --format``: a vehicle for an autopilot or a simulator, and what that costs."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline import __version__
from pipeline.errors import CannotComputeError
from pipeline.export.receivers.autopilots import ardusub, px4
from pipeline.export.receivers.exported import Exported, Subject, subject_of
from pipeline.export.receivers.gazebo import gazebo
from pipeline.export.receivers.stonefish import stonefish
from pipeline.inputs.simulated_vehicle import load_simulated
from pipeline.provenance import write_atomically
from pipeline.simulate.run import run
from pipeline.types import FloatArray

FORMATS: dict[str, Callable[[Subject], Exported]] = {
    "px4": px4,
    "ardusub": ardusub,
    "gazebo": gazebo,
    "stonefish": stonefish,
}
#: Manoeuvre -> share of the largest force or moment of each axis that is asked for.
_MANOEUVRES = {
    "ahead": (0.5, 0.0, 0.0, 0.0, 0.0, 0.0),
    "turn": (0.3, 0.0, 0.0, 0.0, 0.0, 0.2),
    "dive": (0.2, 0.0, 0.3, 0.0, 0.0, 0.0),
}
_SECONDS, _STEP_S = 20.0, 0.02
_CHANNELS = ("u", "v", "w", "p", "q", "r")
_UNITS = ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")


@dataclass(frozen=True)
class Cost:
    """A channel of a manoeuvre: rms of this model's, and of the exported one less this."""

    manoeuvre: str
    channel: str
    rms: float
    rms_difference: float

    @property
    def line(self) -> str:
        """One line of the table."""
        unit = _UNITS[_CHANNELS.index(self.channel)]
        return (
            f"{self.manoeuvre:<6} {self.channel} rms {self.rms:8.4f}, exported differs by "
            f"{self.rms_difference:8.4f} {unit}"
        )


@dataclass(frozen=True)
class ReceiverFile:
    """The file, what it cannot hold, and how much that costs."""

    path: Path
    says: tuple[str, ...]
    lost: tuple[str, ...]
    costs: tuple[Cost, ...]


def export_to_receiver(vehicle: str, form: str, to: Path, raw: Path, out: Path) -> ReceiverFile:
    """Write a vehicle in the format of a receiver."""
    one = load_simulated(vehicle, raw, out)
    subject = subject_of(one.vehicle, one.packed)
    exported = FORMATS[form](subject)
    costs = tuple(_costs(subject, exported))
    digest = one.file_digest
    lines = [
        f"{one.name} for {form}, by rig2sea {__version__} from vehicle.yaml with SHA-256 {digest}.",
        *exported.says,
        *(f"Not in it: {text}." for text in exported.lost),
        "",
        f"What that costs, flown for {_SECONDS:g} s from rest by both:",
        *(f"  {cost.line}" for cost in costs),
    ]
    head = "".join(exported.comment(line) + "\n" for line in lines)
    path = to / exported.file
    write_atomically(path, exported.text(head))
    return ReceiverFile(path, exported.says, exported.lost, costs)


def _costs(subject: Subject, exported: Exported) -> list[Cost]:
    """Fly the manoeuvres by this model and by the equations of the exported one."""
    matrix, ahead = subject.matrix, subject.ahead[:, -1]
    shares = np.linalg.pinv(matrix, rcond=1e-6)
    found = []
    for name, axes in _MANOEUVRES.items():
        wrench = np.zeros(6)
        for axis, part in enumerate(axes):
            unit = shares[:, axis]
            reached = abs(float(matrix[axis] @ unit) - 1.0) < 1e-3
            if part and reached:
                wrench[axis] = part / float(np.max(np.abs(unit) / np.maximum(ahead, 1e-9)))
        if not wrench.any():
            continue
        own = subject.code(shares @ wrench)
        theirs = own if exported.codes_for is None else exported.codes_for(wrench)
        first = _flown(subject, own, None)
        second = (
            _flown(subject, theirs, exported.vector)
            if exported.fly is None
            else exported.fly(theirs, len(first), _STEP_S)
        )
        differs = second - first
        for k, channel in enumerate(_CHANNELS):
            rms, off = (float(np.sqrt(np.mean(x[:, k] ** 2))) for x in (first, differs))
            if max(rms, off) > 1e-3:
                found.append(Cost(name, channel, rms, off))
    if not found:
        raise CannotComputeError(
            f"{subject.packed.name} makes no surge, heave or yaw by itself, so that there is "
            "nothing to compare an exported model by."
        )
    return found


def _flown(subject: Subject, codes: FloatArray, vector: FloatArray | None) -> FloatArray:
    command = np.tile(codes, (round(_SECONDS / _STEP_S), 1))
    return run(subject.packed, command, dt_s=_STEP_S, vector=vector).nu
