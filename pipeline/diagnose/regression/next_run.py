"""The manoeuvre that would tell two answers apart best, against sound runs."""

from collections.abc import Sequence

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.coordinates import Added
from pipeline.diagnose.regression.change import Change
from pipeline.diagnose.regression.decide import Said, effects_of
from pipeline.diagnose.regression.grid import all_at, on_grids
from pipeline.diagnose.regression.known import Reference
from pipeline.diagnose.regression.ordinary import beyond_ordinary
from pipeline.errors import CannotComputeError
from pipeline.records.diagnosis import NONE, UNKNOWN, NextRun
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES, Manoeuvre
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.sensor_schema import Sensors

_SECONDS = 30.0


def next_run(
    case: Case,
    known: Reference,
    ranking: Sequence[Change],
    said: Said,
    added: Sequence[Added],
) -> NextRun | None:
    """Best of the manoeuvres that the vehicle can fly, by the expected separation.

    The vehicle of the file flies each. The separation is that of the two predictions against the
    noise of the sound runs, in standard deviations, after the second answer has taken all of the
    first that it can; `none` can take nothing. None where nothing is left to be told apart.

    Parameters
    ----------
    case : Case
        Vehicle and runs.
    known : Reference
        What the sound runs show.
    ranking : sequence of Change
        All hypotheses, the most probable first.
    said : Said
        What is said of them.
    added : sequence of Added
        The last directions; see `taken.with_sizes`.
    """
    told = [*said.names, *said.ambiguous]
    named = [one for one in ranking if one.which and set(effects_of(one.name)) <= set(told)]
    if not named or case.vehicle.sensors is None:
        return None
    first = named[0]
    own = effects_of(first.name)
    rival = next((name for name in told if name not in {*own, UNKNOWN}), None)
    if rival is None:
        return None
    other = next((one for one in ranking if effects_of(one.name) == (rival,)), None)
    taken = [] if rival == NONE or other is None else list(other.which)
    direction = np.zeros(len(known.directions))
    direction[list(first.which)] = first.mean
    found: list[tuple[float, str]] = []
    for manoeuvre in MANOEUVRES.values():
        try:
            found.append(
                (
                    _separation(case, known, manoeuvre, added, direction, taken),
                    manoeuvre.name,
                )
            )
        except CannotComputeError:
            continue  # cannot be flown, or is not measured as the sound runs were
    if not found:
        return None
    value, name = max(found)
    return NextRun(
        manoeuvre=name, separates=("+".join(own), rival), expected_separation_sigma=value
    )


def _separation(  # noqa: PLR0917 - one caller
    case: Case,
    known: Reference,
    manoeuvre: Manoeuvre,
    added: Sequence[Added],
    direction: FloatArray,
    taken: Sequence[int],
) -> float:
    """Norm of what is left of a signature once the other answer's are taken off."""
    learned, sensors = known.best, case.vehicle.sensors or Sensors()
    stated = known.directions[: len(known.directions) - len(added)]
    flown = fly(case.packed, manoeuvre.plan(case.packed, 1.0, _SECONDS))
    run = table_of_log(measure(flown, case.packed, sensors), sensors, name=manoeuvre.name)
    (grid,) = all_at(
        on_grids(case.packed, run, sensors, stated, [learned.response.period_s]), added
    )
    if grid.channels != learned.response.channels:
        raise CannotComputeError(f"{manoeuvre.name}: other channels than the sound runs'")
    told = learned.response.would_tell(grid).tempered(learned.ordinary.share)
    whole, _ = beyond_ordinary(told, learned.ordinary.width)
    left = float(direction @ whole @ direction)
    if taken:
        own = whole[np.ix_(taken, taken)] + 1e-9 * np.eye(len(taken))
        shared = whole[list(taken)] @ direction
        left -= float(shared @ np.linalg.solve(own, shared))
    return float(np.sqrt(max(left, 0.0)))
