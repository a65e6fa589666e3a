"""A pool run on one time base: what identification, validation and diagnosis work on.

Held in memory only; the processed file of a run is made by the stage that reads it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.types import BoolArray, FloatArray

#: Quantities of a run: name -> (columns, unit, meaning). Axes SNAME and NED. Commands and shaft
#: speeds have a column for each thruster.
QUANTITIES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "command": ((), "code", "commanded code of each thruster, in the order of the vehicle file"),
    "shaft_speed": ((), "rpm", "shaft speed of each thruster, in the order of the vehicle file"),
    "angular_velocity": (("p", "q", "r"), "rad/s", "body axes"),
    "specific_force": (("x", "y", "z"), "m/s^2", "body axes, at the place of the sensor"),
    "attitude": (("w", "x", "y", "z"), "1", "quaternion, body to NED"),
    "velocity": (("u", "v", "w"), "m/s", "over ground, body axes, at the place of the sensor"),
    "depth": (("depth",), "m", "of the sensor"),
    "position": (("north", "east", "down"), "m", "NED"),
    "voltage": (("supply",), "V", "supply"),
    "current": (("supply",), "A", "drawn from the supply"),
}


@dataclass(frozen=True)
class RunTable:
    """Channels resampled to one time base.

    `time_s` (m,) from 0; `values` quantity -> (m, k); `valid` quantity -> (m,) False where a gap,
    a mark or the end of the channel leaves nothing to trust: what stands there is not to be used
    (not a number in a table of a log). A quantity that was not measured is absent. Known delays
    are removed. `name` is the run's.
    """

    name: str
    time_s: FloatArray
    values: dict[str, FloatArray]
    valid: dict[str, BoolArray]
    notes: tuple[str, ...] = field(default=())
    reading: dict[str, BoolArray] = field(default_factory=dict)
    """Quantity -> (m,) True at the sample nearest to each reading of the sensor; what lies between
    is interpolated. A quantity that is absent here says nothing about it."""
    thrusters: tuple[str, ...] = ()
    """Names of the columns of `command` and `shaft_speed`; empty where nothing names them."""
    start_time_ns: int = 0
    """Where `time_s` is 0, on the clock of the log. [ns since 1970]"""
    left_out: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    """Channel -> mark -> readings that took no part because of it."""
