"""Shaft speeds against those known at the same codes: the supply, or the propellers.

A supply that is low and propellers that give less push a vehicle alike. The shafts tell them apart:
with the one they turn more slowly at every code, with the other they do not (Healey and others
1995). How fast they should turn is known from the bench, or from healthy runs. Thruster by thruster
the shaft's speed n over that expected at its code and speed through the water, n_0(N, V), is that
with a share of the code

    s = (n / n_0)^(1/e),    e = d log n_0 / d log N

which a supply that is low, or a dead zone, foretells: what reaches the drive over what reached it
on the bench. One number in the middle of all thrusters is weighed: a fouled propeller, or one that
blows at another, turns otherwise by some per cent, and thousands of readings say nothing of that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from pipeline.diagnose.case import Case
from pipeline.diagnose.inference.answer import Answers, Candidate
from pipeline.diagnose.inference.verdict import departures_of, effect_alone
from pipeline.diagnose.judging.search import Search
from pipeline.diagnose.linear.linear_model import vector_of
from pipeline.diagnose.rules.shares import Share
from pipeline.diagnose.rules.weighing import UNKNOWN
from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import was_measured
from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.records.run_table import RunTable
from pipeline.simulate.kernel_alone import codes_that_act
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray, IntArray

#: Deviation of the share that healthy shafts turn as with: from the bench; from the bench as
#: healthy runs bear it out; from what other runs alone say, flown at other speeds.
_OF_BENCH, _OF_BOTH, _OF_RUNS = 0.015, 0.008, 0.05
#: Deviations beyond which shafts say no more, and a share so far off that they were not read right.
_FARTHEST, _MISREAD = 8.0, 0.5
#: A code counts where it is this share of the largest, and moved by no more than a share of itself
#: for so long: the shaft has followed. [1, 1, s]
_LEAST_CODE, _STEADY, _SETTLES_S = 0.2, 0.15, 1.0
#: Classes of code in which earlier runs say how fast a shaft turns, and readings that one takes.
_CLASSES, _ENOUGH = 12, 20
#: Readings of a run that are kept, about.
_MOST = 4000
#: Share of the thrusters that must have been seen.
_SEEN = 0.5
#: Step in the logarithm of the code for the exponent, and what an exponent can be.
_STEP, _EXPONENTS = 0.05, (0.3, 3.0)


@dataclass(frozen=True)
class Turning:
    """Steady readings (k,) of shafts.

    `thruster`, signed `code` over the largest, `speed_rpm`, `command` (k, 12): the codes of all
    thrusters, and `along_mps`: speed along the thrust, not a number where none is known.
    """

    thruster: IntArray
    code: FloatArray
    speed_rpm: FloatArray
    command: FloatArray
    along_mps: FloatArray


#: Shaft speed (k,) [rpm] expected of readings at so many times their codes; not a number where that
#: is not known.
Expected = Callable[[Turning, float], FloatArray]


@dataclass(frozen=True)
class ShaftsSeen:
    """Shares (k,) of their codes with which the shafts of some runs turn.

    `command` (k, 12) and `thruster` (k,) are those of the readings, `stated` the parameters of the
    vehicle file; `deviation` is that of a healthy vehicle from what they are held `against`.
    """

    share: FloatArray
    command: FloatArray
    thruster: IntArray
    stated: FloatArray
    deviation: float
    against: str

    def off(self, vector: FloatArray) -> float:
        """Share of their codes by which the shafts turn faster than a parameter vector says."""
        left = self.share - self._reaches(vector) / np.maximum(self._reaches(self.stated), 1e-9)
        return float(np.median([np.median(left[self.thruster == i]) for i in self.thrusters]))

    @property
    def middle(self) -> float:
        """Share of their codes with which the shafts turn in the middle of all thrusters."""
        return 1.0 + self.off(self.stated)

    @property
    def thrusters(self) -> IntArray:
        """Those that were seen."""
        return np.unique(self.thruster)

    def log_likelihood(self, vector: FloatArray) -> float:
        """Log of the normal density at what a vector leaves, over that at nothing left."""
        return -0.5 * min(abs(self.off(vector)) / self.deviation, _FARTHEST) ** 2

    def _reaches(self, vector: FloatArray) -> FloatArray:
        """Size of the code that reaches the drive of each reading's thruster (k,)."""
        codes = np.zeros_like(self.command)
        codes_that_act(vector, self.command, codes)
        return np.abs(codes[np.arange(len(codes)), self.thruster])


def shafts_seen(case: Case) -> ShaftsSeen | None:
    """Compare the shaft speeds of a case's runs with those known; None where there is nothing.

    Nor is there where the supply's voltage is logged: that says it better.
    """
    if any(was_measured(run, "voltage") for run in (*case.runs, *case.holdout)):
        return None
    packed = case.stated
    now, well = turning_in(case.runs, packed), turning_in(case.healthy, packed)
    of_bench = _of_bench(packed)
    seen = _against(now, of_bench, packed, _OF_BENCH, "the bench")
    before = _against(well, of_bench, packed, _OF_BENCH, "the bench")
    if seen is not None and before is not None:
        share = seen.share / before.middle
        seen = replace(seen, share=share, deviation=_OF_BOTH, against="the bench and healthy runs")
    if seen is None:
        seen = _against(now, _of_runs(well), packed, _OF_RUNS, "the healthy runs")
    if seen is None or seen.thrusters.size < _SEEN * len(packed.thruster_names):
        return None
    return seen if abs(seen.middle - 1.0) < _MISREAD else None


def by_shaft_speeds(found: Search, answered: Answers, seen: ShaftsSeen | None) -> Answers:
    """Weigh answers by what they say of the shafts; `unknown` says nothing and keeps its share."""
    if seen is None:
        return answered
    known = [one for one in answered.ranking if one.name != UNKNOWN]
    logs = np.array([_log_likelihood(found, one, seen) for one in known])
    before = np.array([one.probability for one in known])
    worth = before * np.exp(logs - logs.max(initial=-np.inf))
    if not worth.sum() > 0.0:
        return answered
    after = worth * before.sum() / worth.sum()
    shares = [Share(one.name, float(p)) for one, p in zip(known, after, strict=True)]
    shares += [Share(one.name, one.probability) for one in answered.ranking if one.name == UNKNOWN]
    return answered.reweighed(sorted(shares, key=lambda one: (-one.probability, one.name)))


def _log_likelihood(found: Search, one: Candidate, seen: ShaftsSeen) -> float:
    added = effect_alone(found, departures_of(found, one, one.finding), one.finding)
    try:
        vector = vector_of(found.setting, added)
    except CannotComputeError:
        vector = seen.stated
    return seen.log_likelihood(vector)


def turning_in(runs: Sequence[RunTable], packed: PackedVehicle) -> Turning:
    """Collect the readings of shafts that have followed their codes.

    Parameters
    ----------
    runs : sequence of RunTable
        With ``command`` and ``shaft_speed``, or without.
    packed : PackedVehicle
        For the largest codes, and the directions of the thrusters.
    """
    largest = np.abs(packed.code_limits).max(axis=1)
    directions = read(packed.vector, "thruster_direction")[: len(packed.thruster_names)]
    parts = [_empty()]
    for run in runs:
        if not was_measured(run, "shaft_speed") or "command" not in run.values:
            continue
        code = np.nan_to_num(run.values["command"]) / largest
        speed = run.values["shaft_speed"]
        good = run.valid["shaft_speed"][:, None] & np.isfinite(speed)
        good &= run.reading.get("shaft_speed", np.ones(len(code), bool))[:, None]
        back = max(round(_SETTLES_S / float(np.median(np.diff(run.time_s)))), 1)
        if len(code) <= back:
            continue
        moved = np.full(code.shape, np.inf)
        moved[back:] = np.ptp(np.lib.stride_tricks.sliding_window_view(code, back + 1, 0), axis=-1)
        size = np.abs(code)
        steady = good & (size >= _LEAST_CODE) & (moved <= _STEADY * size)
        steady &= np.sign(speed) == np.sign(code)
        row, column = np.nonzero(steady)
        along = np.full(code.shape, np.nan)
        if was_measured(run, "velocity"):
            along = run.values["velocity"] @ directions.T
            along[~run.valid["velocity"]] = np.nan
        command = np.zeros((len(code), MOST_THRUSTERS))
        command[:, : code.shape[1]] = np.nan_to_num(run.values["command"])
        of_run = (column, code[row, column], speed[row, column], command[row], along[row, column])
        parts.append(_thinned(Turning(*of_run)))
    return Turning(
        *(np.concatenate([getattr(one, field.name) for one in parts]) for field in fields(Turning))
    )


def _empty() -> Turning:
    none = np.zeros(0)
    return Turning(np.zeros(0, int), none, none, np.zeros((0, MOST_THRUSTERS)), none)


def _thinned(turning: Turning) -> Turning:
    """Keep every so manyth reading: what stands still says the same a hundred times."""
    every = max(turning.code.size // _MOST, 1)
    return Turning(*(getattr(turning, field.name)[::every] for field in fields(Turning)))


def _against(
    turning: Turning, expected: Expected, packed: PackedVehicle, deviation: float, against: str
) -> ShaftsSeen | None:
    """Shares of all readings of which the speed is known."""
    speed = np.abs(turning.speed_rpm)
    # a step down: above the largest code nothing is known
    at_code, below = expected(turning, 1.0), expected(turning, np.exp(-_STEP))
    with np.errstate(divide="ignore", invalid="ignore"):
        exponent = np.clip(np.log(at_code / below) / _STEP, *_EXPONENTS)
        share = np.where(at_code > 0.0, speed / at_code, np.nan) ** (1.0 / exponent)
    known = np.isfinite(share)
    count = np.bincount(turning.thruster[known], minlength=1)
    known &= np.isin(turning.thruster, np.flatnonzero(count >= _ENOUGH))
    if not known.any():
        return None
    return ShaftsSeen(
        share[known],
        np.ascontiguousarray(turning.command[known]),
        turning.thruster[known],
        packed.vector,
        deviation,
        against,
    )


def _of_bench(packed: PackedVehicle) -> Expected:
    """Give what the bench expects at a code and a speed along the thrust."""
    kinds = read(packed.vector, "thruster_type").astype(int)
    inflow = read(packed.vector, "inflow_fraction")

    def expected(turning: Turning, times: float) -> FloatArray:
        found = np.full(turning.code.size, np.nan)
        if packed.shaft_tables is None:
            return found
        for thruster in np.unique(turning.thruster):
            own = (turning.thruster == thruster) & np.isfinite(turning.along_mps)
            size = np.abs(turning.code[own]) * times
            largest = float(np.abs(packed.code_limits[thruster]).max())
            along = inflow[thruster] * np.sign(turning.code[own]) * turning.along_mps[own]
            found[own] = packed.shaft_speed(
                int(kinds[thruster]), size * largest, np.maximum(along, 0.0)
            )
        return found

    return expected


def _of_runs(well: Turning) -> Expected:
    """Give what other runs show of each thruster and sense at a code, whatever the speed."""
    curves = {}
    for thruster in np.unique(well.thruster):
        for sign in (1.0, -1.0):
            own = (well.thruster == thruster) & (np.sign(well.code) == sign)
            code, speed = np.abs(well.code[own]), np.abs(well.speed_rpm[own])
            place = np.floor(code * _CLASSES).astype(int)
            full = [k for k in np.unique(place) if (place == k).sum() >= _ENOUGH]
            middle = np.array([[np.median(x[place == k]) for k in full] for x in (code, speed)])
            if len(full) >= 2 and (np.diff(middle) > 0.0).all():
                curves[int(thruster), sign] = np.log(middle)

    def expected(turning: Turning, times: float) -> FloatArray:
        found = np.full(turning.code.size, np.nan)
        for (thruster, sign), (code, speed) in curves.items():
            own = (turning.thruster == thruster) & (np.sign(turning.code) == sign)
            size = np.log(np.abs(turning.code[own]))
            known = (size >= code[0]) & (size <= code[-1])
            # the first slope goes on for the step of the exponent
            slope = (speed[1] - speed[0]) / (code[1] - code[0])
            longer, further = [code[0] - _STEP, *code], [speed[0] - slope * _STEP, *speed]
            at = np.exp(np.interp(size + np.log(times), longer, further))
            found[own] = np.where(known, at, np.nan)
        return found

    return expected
