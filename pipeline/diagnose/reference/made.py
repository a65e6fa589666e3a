"""A reference from sound runs: learned, told in the units of its reader, and put to the test."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from pipeline.diagnose.case import Case, channels_of, setting_of, usual_force, with_rest
from pipeline.diagnose.linear.rest import rest_terms
from pipeline.diagnose.reference.departures import departures_of
from pipeline.diagnose.reference.held_out import MOST_PARTS, Identified, predictions
from pipeline.diagnose.reference.judged import judged
from pipeline.diagnose.reference.lacking import lacking
from pipeline.diagnose.reference.learn import Learned, learn
from pipeline.diagnose.with_reference import BETTER
from pipeline.errors import CannotComputeError
from pipeline.identify.windows import Window
from pipeline.records.reference import AxisForce, Departure, Prediction
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray


@dataclass(frozen=True)
class Made:
    """A reference and how good it is; as of `ReferenceRecord`."""

    used: bool
    why: str
    windows: int
    gain_per_window: float
    axes: dict[str, AxisForce]
    departures: tuple[Departure, ...]
    noise: dict[str, float]
    held_out: str
    predictions: tuple[Prediction, ...]


def made(
    case: Case,
    identified: Identified | None = None,
    threads: int = 2,
    tell: Callable[[str], None] = lambda _: None,
) -> Made:
    """Learn from the healthy runs of a case and predict each by the others.

    Parameters
    ----------
    case : Case
        The vehicle and its healthy runs, two or more.
    identified : Identified, optional
        The vehicle as it was identified, which the reference has to beat.
    threads : int
        Simulations side by side.
    tell : callable
        Told what is done now.

    Raises
    ------
    CannotComputeError
        When the runs cannot be used.
    """
    try:
        # the matrices are small: threads of BLAS beside our own only wait for each other
        with threadpool_limits(1, user_api="blas"):
            return _made(case, identified, threads, tell)
    except np.linalg.LinAlgError as error:
        raise CannotComputeError(
            f"the sound runs of {case.name} and its model are so far apart that the equations of "
            f"the reference have no solution ({error}). Check that the vehicle file belongs to "
            "these runs: positions and signs of the thrusters, masses, sensor noise."
        ) from None


def _made(
    case: Case, identified: Identified | None, threads: int, tell: Callable[[str], None]
) -> Made:
    runs = case.healthy
    channels = channels_of(case.vehicle, runs)
    terms = rest_terms(case.packed, usual_force(case.packed))

    def learned_from(
        some: Sequence[RunTable], taken: Callable[[Sequence[Window]], BoolArray] | None
    ) -> Learned:
        return learn(
            with_rest(setting_of(case, some, channels, threads=threads, taken=taken), terms)
        )

    tell(f"learning what the vehicle file lacks from {len(runs)} runs")
    setting = with_rest(setting_of(case, runs, channels, threads=threads), terms)
    learned = learn(setting)
    windows = setting.bench.window_count
    table = predictions(
        case, runs, channels, learned_from, identified=identified, threads=threads, tell=tell
    )
    gain = learned.gain / windows
    used, why = judged(table, gain, BETTER)
    return Made(
        used,
        why,
        windows,
        gain,
        lacking(case, setting, runs, channels, learned),
        departures_of(learned),
        {name: float(value) for name, value in learned.beliefs.widen.items()},
        _left_out(len(runs)),
        table,
    )


def _left_out(runs: int) -> str:
    if runs < 3:
        return "half of each run in turn"
    if runs <= MOST_PARTS:
        return "each run in turn"
    return f"the runs in {MOST_PARTS} parts, each part in turn"
