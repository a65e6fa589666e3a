"""The vehicle as its sound runs show it, where that predicts better than its file."""

from dataclasses import dataclass

from pipeline.diagnose.case import Case
from pipeline.diagnose.linear.coordinates import Coordinate
from pipeline.diagnose.regression.directions import directions_of, stated_widths
from pipeline.diagnose.regression.grid import grid_period, on_grid
from pipeline.diagnose.regression.held_out import FileModel, best_of, decides
from pipeline.diagnose.regression.ordinary import Ordinary, ordinary_of
from pipeline.diagnose.regression.response import Response
from pipeline.errors import CannotComputeError

#: Sound runs without which nothing is known of how much runs differ.
LEAST_SOUND = 3


@dataclass(frozen=True)
class Reference:
    """A vehicle as its sound runs show it; `why` tells why it decides."""

    directions: tuple[Coordinate, ...]
    response: Response
    ordinary: Ordinary
    why: str


def reference_of(case: Case) -> tuple[Reference | None, str]:
    """Learn from the healthy runs of a case, and say why it decides; None where it does not."""
    sensors = case.vehicle.sensors
    directions = directions_of(case.vehicle, case.packed, case.candidates)
    period = grid_period((*case.healthy, *case.runs))
    try:
        plain = [on_grid(case.packed, run, sensors, (), period) for run in case.healthy]
        if len({run.channels for run in plain}) > 1:
            return None, "the sound runs have not the same channels."
        bent, table = best_of(plain, {"vehicle file": FileModel(case.packed)})
        chosen, why = decides(table)
        if not chosen:
            return None, why
        runs = [on_grid(case.packed, run, sensors, directions, period) for run in case.healthy]
    except CannotComputeError as error:
        return None, str(error)
    response = Response(runs, bent)
    stated = stated_widths(case.vehicle, directions)
    ordinary = ordinary_of(response.told_of_sound(), directions, stated)
    return Reference(directions, response, ordinary, why), why
