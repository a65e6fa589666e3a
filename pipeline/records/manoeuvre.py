"""What was flown in a stretch of a run, as far as the readings show it."""

from typing import Literal

from pipeline.records.base import Record

ManoeuvreName = Literal[
    "idle",
    "hover",
    "straight",
    "surge_steps",
    "surge_ramp",
    "coast_down",
    "zig_zag",
    "heading_steps",
    "spiral",
    "circle",
    "heave_steps",
    "pitch_steps",
    "roll_steps",
    "multisine",
    "chirp",
    "prbs",
    "free_decay",
    "mixed",
]


class ManoeuvreFound(Record):
    """A stretch of a run and what it was.

    `from_s`, `to_s` count from the start of the run's table.
    """

    name: ManoeuvreName
    from_s: float
    to_s: float
    sentence: str
