r"""The next pool day: the manoeuvres whose information brings the parameters to wanted intervals.

Every candidate is flown in simulation; the list (docs/methods/pool_day.md) grows one run at a time
by the one that most lowers, with sigma_i the standard deviation of a parameter after the runs and
its prior, and w_i the wanted one,

.. math:: \sum_i \max\left(\log \frac{\sigma_i}{w_i}, 0\right) + \epsilon \log\det P

The second term breaks ties where all are reached or far (D-optimal; Pukelsheim 2006).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.identifiability import information_of_run
from pipeline.identify.thrust_uncertainty import thrust_uncertainty
from pipeline.identify.vehicle_parameters import FreeParameter, free_parameters
from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvre_reach import why_not_flown
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.simulate.sensors import Log, measure
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

#: Factor on the standard deviations that are promised.
MARGIN = 1.5
#: Wanted standard deviation over the prior's, where nothing else is wanted.
WANTED = 0.2
_SIZES = (1.0, 0.5)
#: Length of a run of the list; a manoeuvre is flown in this time, and again if it is worth it. [s]
RUN_S = 60.0
_TIE = 0.02
#: The usual set: what the bundled runs hold.
USUAL = ("zig_zag", "surge_steps", "heave_steps", "pitch_steps", "straight")


@dataclass(frozen=True)
class PlanCandidate:
    """A run that could be flown: its track's extent (3,), charge [Wh], information (p + q)^2."""

    manoeuvre: str
    amplitude: float
    duration_s: float
    trajectory: Trajectory
    log: Log
    room_m: FloatArray
    information: FloatArray


@dataclass(frozen=True)
class ChosenRuns:
    """The list, and standard deviations (p,) over the priors', after it and after the usual set."""

    runs: tuple[PlanCandidate, ...]
    helps: tuple[tuple[int, ...], ...]
    """For each run, the parameters that it is for."""
    parameters: tuple[FreeParameter, ...]
    after: FloatArray
    usual: FloatArray
    usual_s: float
    left_out: tuple[str, ...]


def plan_pool_day(
    packed: PackedVehicle,
    sensors: Sensors,
    uncertainty: Uncertainty,
    *,
    total_s: float,
    room_m: Sequence[float] | None = None,
    tell: Callable[[str], None] = lambda _: None,
) -> ChosenRuns:
    """Choose what to fly.

    At most `total_s` of flying [s], inside `room_m`, length, width and depth of the pool: a track
    may be turned round, but not be larger [m]. The priors are those of the vehicle file's
    `uncertainty`; `tell` is told what is flown.

    Raises
    ------
    CannotComputeError
        When nothing can be flown in this room and time.
    """
    parameters = free_parameters(packed, uncertainty)
    thrust = thrust_uncertainty(packed, uncertainty)
    duration = min(RUN_S, total_s)
    found: list[PlanCandidate] = []
    left_out: list[str] = []
    for name, manoeuvre in MANOEUVRES.items():
        impossible = why_not_flown(packed, name, manoeuvre.axes)
        if impossible:
            left_out.append(impossible)
            continue
        for amplitude in _SIZES:
            tell(f"flying {name}, size {amplitude:g}")
            try:
                flown = fly(packed, manoeuvre.plan(packed, amplitude, duration))
                room = np.ptp(flown.position_ned_m, axis=0)
                why = _too_large(room, room_m)
                if why:
                    left_out.append(f"{name} at size {amplitude:g} {why}")
                    continue
                log = measure(flown, packed, sensors)
                more = information_of_run(packed, sensors, log, parameters, thrust=thrust)
            except CannotComputeError as error:
                left_out.append(f"{name}: {error}")
                break
            found.append(PlanCandidate(name, amplitude, duration, flown, log, room, more))
    if not found:
        raise CannotComputeError(
            "no manoeuvre fits: "
            + "; ".join(left_out)
            + ". Give more room, or another vehicle file."
        )
    prior = np.eye(len(parameters) + thrust.size)
    prior[len(parameters) :, len(parameters) :] = thrust.precision
    runs, helps, after = _greedy(found, prior, len(parameters), int(total_s / duration + 1e-9))
    usual, usual_s = _usual(found, prior, len(parameters), len(runs))
    return ChosenRuns(runs, helps, parameters, after, usual, usual_s * duration, tuple(left_out))


def _too_large(track_m: FloatArray, room_m: Sequence[float] | None) -> str:
    if room_m is None:
        return ""
    level, pool = sorted(track_m[:2], reverse=True), sorted(room_m[:2], reverse=True)
    if level[0] <= pool[0] and level[1] <= pool[1] and track_m[2] <= room_m[2]:
        return ""
    return f"needs {level[0]:.1f} x {level[1]:.1f} x {track_m[2]:.1f} m, more than the pool has."


def _deviations(information: FloatArray, prior: FloatArray, count: int) -> FloatArray:
    """Return standard deviations (count,) over the priors'."""
    covariance = np.linalg.inv(information + prior)
    return np.asarray(np.sqrt(np.diag(covariance)[:count]), float)


def _greedy(
    found: Sequence[PlanCandidate], prior: FloatArray, count: int, most: int
) -> tuple[tuple[PlanCandidate, ...], tuple[tuple[int, ...], ...], FloatArray]:
    """Add the run that helps most, until all is reached or the time is used."""

    def cost(information: FloatArray) -> float:
        left = MARGIN * _deviations(information, prior, count)
        tie = -float(np.linalg.slogdet(information + prior)[1])
        return float(np.maximum(np.log(left / WANTED), 0.0).sum()) + _TIE * tie

    now = np.zeros_like(prior)
    runs: list[PlanCandidate] = []
    helps: list[tuple[int, ...]] = []
    while len(runs) < most:
        before = _deviations(now, prior, count)
        if runs and (MARGIN * before <= WANTED).all():
            break
        best = min(found, key=lambda one: cost(now + one.information))
        now = now + best.information
        gained = np.log(before / _deviations(now, prior, count))
        order = np.argsort(-gained)
        helps.append(tuple(int(k) for k in order[:4] if gained[k] > 0.05))
        runs.append(best)
    return tuple(runs), tuple(helps), _deviations(now, prior, count)


def _usual(
    found: Sequence[PlanCandidate], prior: FloatArray, count: int, runs: int
) -> tuple[FloatArray, int]:
    """Return standard deviations after the usual set, in turn, of as many runs."""
    own = {one.manoeuvre: one for one in reversed(found)}
    there = [own[name] for name in USUAL if name in own]
    information = np.zeros_like(prior)
    for k in range(runs if there else 0):
        information = information + there[k % len(there)].information
    return _deviations(information, prior, count), runs if there else 0
