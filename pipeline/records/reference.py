"""Schema of ``reference.json``: the vehicle as its sound runs show it, against its file."""

from typing import Literal

from pipeline.records.base import Record
from pipeline.records.diagnosis import Interval


class SoundRun(Record):
    """A run that the reference was learned from."""

    name: str
    file: str
    sha256: str
    seconds: float
    because: str
    """Why it is taken for sound: its notes, an accepted day, or the command line."""


class Departure(Record):
    """One way in which the vehicle may differ from its file, with what the runs say of it.

    `kind` is ``effect`` for a parameter of the library's effects, ``curve`` for an error of a
    thrust curve, else the kind of a force of the rest (docs/methods/reference.md). `value` has the
    meaning of the parameter, `neutral` is where the file is right, `scatter` the standard deviation
    between runs; all in `unit`.
    """

    name: str
    kind: Literal["effect", "curve", "constant", "earth", "thrust", "late", "damping"]
    axis: str | None = None
    thruster: str | None = None
    unit: str
    value: float
    ci95: Interval
    neutral: float
    scatter: float

    @property
    def stands_out(self) -> bool:
        """Whether the vehicle surely differs from its file in this."""
        low, high = self.ci95
        return not low <= self.neutral <= high


class AxisForce(Record):
    """Force along an axis that the model needs to follow the sound runs: rms, in N or N m."""

    unit: str
    lacked: float
    """What the vehicle file lacks."""
    left: float
    """What is left once all that is the same in every run is added."""
    left_in_run: float
    """What is left once each run has its own departures too."""
    same_share: float
    """Share of the square of `lacked` that is the same in every run, 0 to 1."""
    outside: float
    """Outside force that is ordinary with the reference: standard deviation."""
    outside_of_file: float
    """The same as it is taken to be without sound runs."""


class Prediction(Record):
    """Rms error of one way to predict runs that took no part, so many seconds ahead."""

    method: Literal["reference", "vehicle file", "identified file", "black box", "last value"]
    quantity: str
    unit: str
    ahead_s: float
    rmse: float
    readings: int


class ReferenceRecord(Record):
    """The whole reference."""

    vehicle: str
    vehicle_file_sha256: str
    runs: tuple[SoundRun, ...]
    used: bool
    """Whether the diagnosis is told against it."""
    why: str
    windows: int
    gain_per_window: float
    """Log evidence over the vehicle file's own widths, for each window. [nat]"""
    axes: dict[str, AxisForce]
    departures: tuple[Departure, ...]
    noise: dict[str, float]
    """Factor on the stated noise of a quantity."""
    held_out: str
    """What was left out in turn, in words."""
    predictions: tuple[Prediction, ...]
    notes: tuple[str, ...] = ()
