"""Schema of ``reference.json``: the vehicle as its sound runs show it, against its file."""

from typing import Literal

from pipeline.records.base import Record


class SoundRun(Record):
    """A run that the reference was learned from."""

    name: str
    file: str
    sha256: str
    seconds: float
    because: str
    """Why it is taken for sound: its notes, an accepted day, or the command line."""


class Width(Record):
    """How much sound runs differ in a parameter of an effect: standard deviations, in `unit`.

    `stated` is what was taken before any run was seen, `learned` what they show.
    """

    name: str
    unit: str
    stated: float
    learned: float


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
    period_s: float
    """Of the grid on which velocities are regressed. [s]"""
    noise_trusted: float
    """Share of the information of a run that is left once noise is as large as runs scatter. [1]"""
    force: dict[str, dict[str, float]]
    """Channel -> axis: change of the velocity by a newton (metre) that acts for a second."""
    widths: tuple[Width, ...]
    predictions: tuple[Prediction, ...]
    notes: tuple[str, ...] = ()
