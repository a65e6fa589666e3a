"""What a reader is told first of a vehicle, a day, a run or a diagnosis: one record for all forms.

Pages, the terminal and JSON show the same: what is the matter, what to do, what to fly next, and
what became of the last advice.
"""

from typing import Literal

from pipeline.records.base import Record

Light = Literal["red", "amber", "green"]
#: Worst first.
LIGHTS: tuple[Light, ...] = ("red", "amber", "green")


class Advice(Record):
    """One thing to do: in words, and the command to type where there is one."""

    text: str
    command: str = ""


class Glance(Record):
    """The first screen."""

    light: Light
    matter: str
    """What is the matter, in a sentence."""
    short: str
    """The same for a list of many."""
    do: tuple[Advice, ...] = ()
    """At most three, the most urgent first."""
    fly_next: str = ""
    last_advice: str = ""
    """What became of what the day before advised."""
