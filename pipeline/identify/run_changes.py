r"""What changed from run to run: thrusters and parameters that differ between two sets of runs.

All runs are fitted together, as `identify` fits them: every run has the parameters x, and x + d v
where a shift d along a direction v (a thruster's gain, a drag) is taken into the model for it. A
few Gauss-Newton steps are enough: what the model lacks in all runs is no difference between them,
so nothing has to settle. A shift that is not in the model is one more column of the normal
equations of x, the shifts taken, and the offsets of every run.

Of the shifts that are asked for and stand (Holm's correction for their number), the one that
explains most is taken into the model, the steps are gone on with, and the others are asked again
beside it, until none is left. The standard deviation is that by which the windows scatter, where
that is more than the noise says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtr

from pipeline.identify.channel_noise import channel_noise
from pipeline.identify.gain_tests import adjusted
from pipeline.identify.output_error import (
    LONGEST_STEP,
    Reduced,
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


@dataclass(frozen=True, eq=False)
class Shift:
    """A question: does `name` differ in these runs? `direction` (p + q,) is one unit of it."""

    kind: str
    name: str
    unit: str
    runs: tuple[int, ...]
    direction: FloatArray


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
    joint = _Joint(packed, sensors, [*before, *after], uncertainty)
    shifts = _questions(joint.problems[0], packed, len(before), len(before) + len(after))
    joint.settle(_ROUNDS)
    asked = joint.ask(shifts, ordinary=False)
    while len(joint.taken) < _MOST_CHANGES:
        rest = [one for one in asked if one.shift not in joint.taken and one.p_value < FALSE_ALARMS]
        if not rest:
            break
        best = max(rest, key=lambda one: one.gain)
        joint.taken[best.shift] = best.value
        # the first moves all that is common
        joint.settle(_ROUNDS + 1 if len(joint.taken) == 1 else 1)
        asked = joint.ask(shifts, ordinary=False)
    asked = joint.ask(shifts)
    changes = tuple(one for one in asked if one.shift in joint.taken and one.p_value < FALSE_ALARMS)
    return RunChanges(changes, tuple(one for one in asked if one.shift.kind != "run_parameter"))


def _questions(problem: FitProblem, packed: PackedVehicle, count: int, runs: int) -> list[Shift]:
    """Thrusters in each run and in the second set, all of them together, parameters of the set."""
    own, share = len(problem.parameters), problem.thrust.share
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
class _RunEquations:
    """Normal equations of one run's (x, offsets), and how all unknowns move those (`design`)."""

    reduced: Reduced
    design: FloatArray
    matrix: FloatArray
    pull: FloatArray

    def of(self, direction: FloatArray) -> FloatArray:
        """Widen a direction of x by offsets that stay."""
        return np.append(direction, np.zeros(len(self.pull) - direction.size))


class _Joint:
    """All runs with common parameters x (n,), and the shifts taken with their sizes."""

    def __init__(
        self,
        packed: PackedVehicle,
        sensors: Sensors,
        tables: Sequence[RunTable],
        uncertainty: Uncertainty,
    ) -> None:
        channels = channel_noise(sensors, tables)
        parameters = free_parameters(packed, uncertainty)
        # the factors alone: the shape of a curve is no matter of a day
        thrust = thrust_uncertainty(packed, uncertainty).factors()
        self.problems: list[FitProblem] = []
        for table in tables:
            windows = chained_windows(packed, packed.vector, cut(packed, [table], channels))
            stack = stack_windows(packed, windows, channels)
            self.problems.append(FitProblem(stack, parameters, packed.vector, thrust=thrust))
        self.points: list[FitPoint] = [one.origin() for one in self.problems]
        self.known: list[Derivatives] = []
        self.x = np.zeros(self.problems[0].size)
        self.taken: dict[Shift, float] = {}
        self.wider: dict[str, float] = {}

    def settle(self, rounds: int) -> None:
        """Go rounds of steps, each with derivatives made anew, and take the noise for what is left.

        The noise of a quantity is what the residuals of most runs show.
        """
        for _ in range(rounds):
            self._place()
            self.known = [
                derivatives(problem, point)
                for problem, point in zip(self.problems, self.points, strict=True)
            ]
            for _ in range(_CHORDS):
                self._step()
            self._place()
            found: dict[str, list[float]] = {}
            for problem, point in zip(self.problems, self.points, strict=True):
                factors = widened(problem.stack, residuals(problem, point))
                for rows in problem.stack.rows:
                    quantity = rows.channel.quantity
                    found.setdefault(quantity, []).append(factors.get(quantity, 1.0))
            self.wider = {quantity: float(np.median(each)) for quantity, each in found.items()}

    def _place(self) -> None:
        """Put every run at its parameters."""
        for number, point in enumerate(self.points):
            steps = self.x + sum(
                size * shift.direction for shift, size in self.taken.items() if number in shift.runs
            )
            self.points[number] = replace(point, steps=steps)

    def _step(self) -> None:
        """Go a step with the derivatives at hand."""
        equations = self._equations()
        matrix, pull = self._normal(equations)
        move = np.linalg.solve(matrix, pull)
        count = self.x.size
        longest = float(np.abs(move[:count]).max(initial=0.0))
        share = min(1.0, LONGEST_STEP / max(longest, 1e-12))
        for number, one in enumerate(equations):
            point, own = self.points[number], one.design @ move
            self.points[number] = FitPoint(
                point.steps,
                point.shared + share * own[count:],
                point.starts + share * one.reduced.start_moves(own),
            )
        self.x = np.maximum(self.x + share * move[:count], self.problems[0].lowest)
        for shift, by in zip(self.taken, move[count:].tolist(), strict=False):
            self.taken[shift] += share * by

    def ask(self, shifts: Sequence[Shift], *, ordinary: bool = True) -> tuple[RunChange, ...]:
        """Estimate each shift beside those taken; p-values by Holm over what could be told.

        `ordinary` counts what single runs differ by without a cause: only once what differs is in
        the model, for until then it passes for the ordinary.
        """
        equations = self._equations()
        matrix, pull = self._normal(equations)
        inverse = np.asarray(np.linalg.inv(matrix), float)
        alone = [self._estimate(equations, inverse, pull, shift) for shift in shifts]
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
        aside = {run for each in self.taken if each.name == shift.name for run in each.runs}
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
        windows = sum(len(self.problems[k].stack.windows) for k in shift.runs)
        chance = 2.0 * float(stdtr(max(windows - 1, 1), -abs(one.value) / std))
        return replace(one, std=std, p_value=chance)

    def _equations(self) -> list[_RunEquations]:
        """Set up the equations of every run where it stands, with the derivatives at hand."""
        self._place()
        count, found = self.x.size, []
        begin = count + len(self.taken)
        size = begin + sum(one.shared.size for one in self.problems)
        for number, (problem, point) in enumerate(zip(self.problems, self.points, strict=True)):
            stack = problem.stack
            known = replace(self.known[number], residual=residuals(problem, point))
            soft = softness_of(stack, known.residual)
            for k, rows in enumerate(stack.rows):
                own = stack.owner == k
                soft[own] = np.maximum(soft[own], self.wider.get(rows.channel.quantity, 1.0))
            weights = huber_weights(known.residual, soft)
            reduced = reduce_windows(problem, known, point, weights)
            # the prior of x is that of all runs together
            prior = reduced.prior.copy()
            prior[:count, :count] = 0.0
            shared = problem.shared.size
            design = np.zeros((count + shared, size))
            design[:count, :count] = np.eye(count)
            for k, shift in enumerate(self.taken):
                design[:count, count + k] = shift.direction * (number in shift.runs)
            design[count:, begin : begin + shared] = np.eye(shared)
            begin += shared
            pull = reduced.gradient - prior[:, count:] @ point.shared
            matrix = reduced.information + prior
            found.append(_RunEquations(reduced, design, matrix, pull))
        return found

    def _normal(self, equations: Sequence[_RunEquations]) -> tuple[FloatArray, FloatArray]:
        """Set up the normal equations of (x, shifts taken, offsets), priors included."""
        count, size = self.x.size, equations[0].design.shape[1]
        precision = self.problems[0].precision
        matrix, pull = 1e-9 * np.eye(size), np.zeros(size)
        matrix[:count, :count] += precision
        pull[:count] = -precision @ self.x
        for one in equations:
            matrix += one.design.T @ one.matrix @ one.design
            pull += one.design.T @ one.pull
        return matrix, pull

    def _estimate(
        self,
        equations: Sequence[_RunEquations],
        inverse: FloatArray,
        pull: FloatArray,
        shift: Shift,
    ) -> RunChange:
        """Estimate one shift beside the others that are taken."""
        move = inverse @ pull
        if shift in self.taken:
            place = self.x.size + list(self.taken).index(shift)
            row, variance, step, alone = inverse[place], float(inverse[place, place]), 0.0, 0.0
            value = self.taken[shift] + float(move[place])
        else:
            column, square, score = np.zeros(len(pull)), 1e-9, 0.0
            for number in shift.runs:
                one = equations[number]
                own = one.of(shift.direction)
                column += one.design.T @ (one.matrix @ own)
                square += float(own @ one.matrix @ own)
                score += float(own @ one.pull)
            beside = inverse @ column
            variance = 1.0 / (square - float(column @ beside))
            value = step = variance * (score - float(beside @ pull))
            move = move - step * beside
            row, alone = -variance * beside, variance
        # what the windows say once all has moved: their scatter counts where it is wider
        scatter = 0.0
        for number, one in enumerate(equations):
            own = one.of(shift.direction * (number in shift.runs))
            weight, moved = one.design @ row + alone * own, one.design @ move + step * own
            for piece in one.reduced.pieces:
                left = piece.score - piece.information @ moved[piece.index]
                scatter += float(weight[piece.index] @ left) ** 2
        index = int(np.argmax(np.abs(shift.direction)))
        at = float(self.x[index]) / float(np.abs(shift.direction).max())
        parameters = self.problems[0].parameters
        nominal = parameters[index].nominal if index < len(parameters) else 1.0
        return RunChange(
            shift, nominal + at, value, max(variance, scatter) ** 0.5, value**2 / variance
        )
