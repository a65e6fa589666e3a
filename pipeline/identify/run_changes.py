r"""What changed from run to run: thrusters and parameters that differ between two sets of runs.

All runs are fitted together, as `identify` fits them, with common parameters x; some have x + d v,
where a shift d along a direction v (a thruster's gain, a drag) is taken into the model for them. A
few Gauss-Newton steps are enough: what the model lacks in all runs is no difference between them,
so nothing has to settle. A shift that is not in the model is one more column of the normal
equations of x, the shifts taken, and what the windows of a run share.

Of the shifts that are asked for and stand (Holm's correction for their number), the one that
explains most is taken into the model, the steps are gone on with, and the others are asked again
beside it, until none is left. The standard deviation is that by which the windows scatter, where
that is more than the noise says.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import Self

import numpy as np
from scipy.special import stdtr

from pipeline.identify.channel_noise import channel_noise
from pipeline.identify.gain_tests import adjusted
from pipeline.identify.output_error import (
    LONGEST_STEP,
    Piece,
    huber_weights,
    reduce_windows,
    softness_of,
)
from pipeline.identify.thrust_uncertainty import thrust_uncertainty
from pipeline.identify.vehicle_fit import chained_windows, widened
from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.identify.window_derivatives import (
    Derivatives,
    FitPoint,
    FitProblem,
    Shift,
    derivatives,
    residuals,
)
from pipeline.identify.window_outputs import stack_windows
from pipeline.identify.windows import cut
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

#: Chance of any difference at all between sets of runs of one unchanged vehicle.
FALSE_ALARMS = 0.05
#: Rounds with derivatives made anew, and steps with those at hand in each.
_ROUNDS, _CHORDS = 2, 3
#: A gain whose shift is not known to this is not asked for. [1]
_WIDEST_GAIN = 0.3
_MOST_CHANGES = 3
#: What a gain [1], and a parameter in its prior's width, differ by between sound runs at least.
_ORDINARY_GAIN, _ORDINARY_SHARE = 0.02, 0.1


@dataclass(frozen=True)
class RunChange:
    """A shift that was asked for: `value` over `base`, what the other runs have.

    `gain` is by how much it lowers the cost, `p_value` with all questions counted.
    """

    shift: Shift
    base: float
    value: float
    std: float
    gain: float
    p_value: float = 1.0


@dataclass(frozen=True)
class RunChanges:
    """What changed, and every question with its answer beside that."""

    changes: tuple[RunChange, ...]
    asked: tuple[RunChange, ...]


def changes_between(
    packed: PackedVehicle,
    sensors: Sensors,
    before: Sequence[RunTable],
    after: Sequence[RunTable],
    uncertainty: Uncertainty,
) -> RunChanges:
    """Ask which thrusters (in a run, or in the second set) and parameters (of that set) differ.

    Raises
    ------
    CannotComputeError
        If there is nothing to fit.
    """
    tables = [*before, *after]
    channels = channel_noise(sensors, tables)
    windows = chained_windows(packed, packed.vector, cut(packed, tables, channels))
    problem = FitProblem(
        stack_windows(packed, windows, channels),
        free_parameters(packed, uncertainty),
        packed.vector,
        len(tables),
        # the factors alone: the shape of a curve is no matter of a day
        thrust=thrust_uncertainty(packed, uncertainty).factors(),
    )
    shifts = _questions(problem, packed, len(before))
    fit = _Fit.of(problem, problem.origin(), _ROUNDS)
    asked = fit.ask(shifts, ordinary=False)
    while len(taken := fit.problem.shifts) < _MOST_CHANGES:
        rest = [one for one in asked if one.shift not in taken and one.p_value < FALSE_ALARMS]
        if not rest:
            break
        best = max(rest, key=lambda one: one.gain)
        begin = replace(fit.point, steps=np.append(fit.point.steps, best.value))
        problem = replace(problem, shifts=(*taken, best.shift))
        # the first moves all that is common
        fit = _Fit.of(problem, begin, 1 if taken else _ROUNDS + 1, fit.wider)
        asked = fit.ask(shifts, ordinary=False)
    asked = fit.ask(shifts)
    changes = tuple(one for one in asked if one.shift in taken and one.p_value < FALSE_ALARMS)
    return RunChanges(changes, tuple(one for one in asked if one.shift.kind != "run_parameter"))


def _questions(problem: FitProblem, packed: PackedVehicle, count: int) -> list[Shift]:
    """Thrusters in each run and in the second set, all of them together, parameters of the set."""
    own, share, runs = len(problem.parameters), problem.thrust.share, problem.runs
    second = tuple(range(count, runs))
    sets = [second, *((k,) for k in range(runs) if runs > 2 and (k,) != second)]

    def along(indices: Sequence[int], size: float) -> FloatArray:
        direction = np.zeros(problem.size)
        direction[list(indices)] = 1.0 / size
        return direction

    gains = list(range(own, own + problem.thrust.gains))
    found = []
    for these in sets if gains else []:
        found += [
            Shift("thruster", name, "1", these, along([index], share))
            for index, name in zip(gains, packed.thruster_names, strict=True)
        ]
        found.append(Shift("all_thrusters", "all thrusters", "1", these, along(gains, share)))
    for these in sets:
        # of single runs they only show what runs of one vehicle differ by: what the model lacks
        # in one manoeuvre passes for a parameter of it
        kind = "parameter" if these == second else "run_parameter"
        found += [
            Shift(kind, one.name, one.unit, these, along([index], one.prior_std))
            for index, one in enumerate(problem.parameters)
        ]
    return found


@dataclass(frozen=True)
class _Fit:
    """Where the fit of all runs stands, with its normal equations there.

    `pieces` are those of the windows, `inverse` of the matrix of all, `move` (x, shared) what they
    ask for; `wider` by what a quantity's noise is wider than stated.
    """

    problem: FitProblem
    point: FitPoint
    wider: dict[str, float]
    pieces: tuple[Piece, ...]
    inverse: FloatArray
    move: FloatArray

    @classmethod
    def of(
        cls,
        problem: FitProblem,
        point: FitPoint,
        rounds: int,
        wider: Mapping[str, float] = MappingProxyType({}),
    ) -> Self:
        """Go rounds of steps, each with derivatives made anew, and take the noise for what is left.

        The noise of a quantity is what the residuals of most runs show.
        """
        for _ in range(rounds):
            known = derivatives(problem, point)
            for _ in range(_CHORDS):
                fit = cls._at(problem, point, wider, known)
                own = problem.size - len(problem.shifts)
                longest = float(np.abs(fit.move[:own]).max(initial=0.0))
                share = min(1.0, LONGEST_STEP / max(longest, 1e-12))
                moves = [one.first - one.second @ fit.move[one.index] for one in fit.pieces]
                steps, shared = np.split(share * fit.move, [problem.size])
                point = FitPoint(
                    np.maximum(point.steps + steps, problem.lowest),
                    point.shared + shared,
                    point.starts + share * np.array(moves),
                )
            left = residuals(problem, point)
            each = [widened(problem.stack, left, run) for run in range(problem.runs)]
            found = {name: [one.get(name, 1.0) for one in each] for one in each for name in one}
            wider = {name: float(np.median(factors)) for name, factors in found.items()}
        return cls._at(problem, point, wider, known)

    @classmethod
    def _at(
        cls, problem: FitProblem, point: FitPoint, wider: Mapping[str, float], known: Derivatives
    ) -> Self:
        """Set up the equations at a point, with the derivatives at hand."""
        stack, known = problem.stack, replace(known, residual=residuals(problem, point))
        runs = np.array([window.run for window in stack.windows])[problem.shared.window]
        soft = np.empty(runs.size)
        for k, run in product(range(len(stack.rows)), range(problem.runs)):
            # a run that differs is far off alone
            own = (stack.owner == k) & (runs == run)
            far = softness_of(known.residual[own])
            soft[own] = max(far, wider.get(stack.rows[k].channel.quantity, 1.0))
        reduced = reduce_windows(problem, known, point, huber_weights(known.residual, soft))
        matrix = reduced.information + reduced.prior + 1e-9 * np.eye(len(reduced.prior))
        now = np.concatenate([point.steps, point.shared])
        inverse = np.asarray(np.linalg.inv(matrix), float)
        move = inverse @ (reduced.gradient - reduced.prior @ now)
        return cls(problem, point, dict(wider), reduced.pieces, inverse, move)

    def ask(self, shifts: Sequence[Shift], *, ordinary: bool = True) -> tuple[RunChange, ...]:
        """Estimate each shift beside those taken; p-values by Holm over what could be told.

        `ordinary` counts what single runs differ by without a cause: only once what differs is in
        the model, for until then it passes for the ordinary.
        """
        alone = [self._estimate(shift) for shift in shifts]
        found = [self._tested(one, alone if ordinary else ()) for one in alone]
        told = [
            k
            for k, one in enumerate(found)
            if one.shift.kind == "parameter"
            or (one.shift.kind != "run_parameter" and one.std < _WIDEST_GAIN)
        ]
        p = np.ones(len(found))
        p[told] = adjusted([found[k].p_value for k in told])
        return tuple(replace(one, p_value=float(each)) for one, each in zip(found, p, strict=True))

    def _tested(self, one: RunChange, alone: Sequence[RunChange]) -> RunChange:
        """Test a shift against its noise and what other single runs, not taken, differ by."""
        shift, is_gain = one.shift, one.shift.kind != "parameter"
        taken = self.problem.shifts
        aside = {run for each in taken if each.name == shift.name for run in each.runs}
        if len(shift.runs) == 1:
            aside |= set(shift.runs)
        rest = [
            (other.value, other.std)
            for other in alone
            if other.shift.name == shift.name and len(other.shift.runs) == 1
            if not aside & set(other.shift.runs)
            if not is_gain or other.std < _WIDEST_GAIN
        ]
        values, stds = np.array(rest, float).reshape(-1, 2).T
        # by weight, so that a run that hardly shows it does not decide (DerSimonian and Laird 1986)
        weights = 1.0 / stds**2
        excess = float(np.sum(weights * values**2)) - values.size
        between = max(excess, 0.0) / float(weights.sum()) if rest else 0.0
        size = float(np.abs(shift.direction).max())
        ordinary = _ORDINARY_GAIN if is_gain else _ORDINARY_SHARE / size
        std = (one.std**2 + between / len(shift.runs) + ordinary**2) ** 0.5
        windows = sum(window.run in shift.runs for window in self.problem.stack.windows)
        chance = 2.0 * float(stdtr(max(windows - 1, 1), -abs(one.value) / std))
        return replace(one, std=std, p_value=chance)

    def _estimate(self, shift: Shift) -> RunChange:
        """Estimate one shift beside the others that are taken."""
        problem, move, count = self.problem, self.move, shift.direction.size
        own = np.zeros(len(move))
        own[:count] = shift.direction
        runs = [window.run for window in problem.stack.windows]
        if shift in problem.shifts:
            place = count + problem.shifts.index(shift)
            row, variance = self.inverse[place], float(self.inverse[place, place])
            value, step, alone = float(self.point.steps[place] + move[place]), 0.0, 0.0
        else:
            column, square, score = np.zeros(len(move)), 1e-9, 0.0
            for run, piece in zip(runs, self.pieces, strict=True):
                here = own[piece.index] * (run in shift.runs)
                along = piece.information @ here
                column[piece.index] += along
                square, score = square + float(here @ along), score + float(here @ piece.score)
            beside = self.inverse @ column
            variance = alone = 1.0 / (square - float(column @ beside))
            value = step = variance * (score - float(column @ move))
            move, row = move - step * beside, -variance * beside
        # what the windows say once all has moved: their scatter counts where it is wider
        scatter = 0.0
        for run, piece in zip(runs, self.pieces, strict=True):
            here = own[piece.index] * (run in shift.runs)
            left = piece.score - piece.information @ (move[piece.index] + step * here)
            scatter += float((row[piece.index] + alone * here) @ left) ** 2
        index = int(np.argmax(np.abs(shift.direction)))
        base = float(self.point.steps[index]) / float(np.abs(shift.direction).max())
        base += problem.parameters[index].nominal if index < len(problem.parameters) else 1.0
        return RunChange(shift, base, value, max(variance, scatter) ** 0.5, value**2 / variance)
