r"""What changed from run to run: thrusters and parameters that differ between two sets of runs.

All runs are fitted together, as `identify` fits them: every run has the parameters x, and x + d v
where a shift d along a direction v (a thruster's gain, a drag) is taken into the model for it. A
few Gauss-Newton steps are enough: what the model lacks in all runs is no difference between them,
so nothing has to settle. With M_j the information of run j, g_j its score, sums over the runs S of
a shift, and M that of all with the priors,

.. math::

    \hat d = \frac{v^T g_S - k^T g}{v^T M_S v - k^T M_S v}, \qquad k = M^{-1} M_S v

Of the shifts that are asked for and stand (Holm's correction for their number), the one that
explains most is taken into the model, the steps are gone on with, and the others are asked again
beside it, until none is left. The standard deviation is that by which the windows scatter, where
that is more than the noise says.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import stdtr

from pipeline.identify.channel_noise import channel_noise
from pipeline.identify.gain_tests import adjusted
from pipeline.identify.output_error import LONGEST_STEP
from pipeline.identify.run_equations import FittedRun, RunEquations
from pipeline.identify.run_nuisance import run_nuisance
from pipeline.identify.thrust_uncertainty import EXACT_THRUST, thrust_uncertainty
from pipeline.identify.vehicle_fit import chained_windows, widened
from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.identify.window_derivatives import FitProblem, derivatives, residuals
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
    p_value: float


@dataclass(frozen=True)
class RunChanges:
    """What changed, and every question with its answer beside that."""

    changes: tuple[RunChange, ...]
    asked: tuple[RunChange, ...]
    windows: int


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
    joint = _Joint.of(packed, sensors, [*before, *after], uncertainty)
    shifts = _questions(joint.runs[0].problem, packed, len(before), len(before) + len(after))
    joint.settle(_ROUNDS)
    asked = joint.ask(shifts, ordinary=False)
    while len(joint.taken) < _MOST_CHANGES:
        rest = [one for one in asked if one.shift not in joint.taken]
        rest = [one for one in rest if one.p_value < FALSE_ALARMS]
        if not rest:
            break
        joint.take(max(rest, key=lambda one: one.gain))
        # the first moves all that is common
        joint.settle(_ROUNDS + 1 if len(joint.taken) == 1 else 1)
        asked = joint.ask(shifts, ordinary=False)
    asked = joint.ask(shifts)
    changes = tuple(one for one in asked if one.shift in joint.taken and one.p_value < FALSE_ALARMS)
    told = tuple(one for one in asked if one.shift.kind != "run_parameter")
    return RunChanges(changes, told, sum(len(run.problem.stack.windows) for run in joint.runs))


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


@dataclass
class _Joint:
    """All runs with common parameters x (n,), and the shifts taken with their sizes."""

    runs: list[FittedRun]
    x: FloatArray
    taken: list[Shift]
    sizes: list[float]
    wider: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        packed: PackedVehicle,
        sensors: Sensors,
        tables: Sequence[RunTable],
        uncertainty: Uncertainty,
    ) -> "_Joint":
        channels = channel_noise(sensors, tables)
        parameters = free_parameters(packed, uncertainty)
        thrust = thrust_uncertainty(packed, uncertainty)
        if thrust.size:  # the factors alone: the shape of a curve is no matter of a day
            count = thrust.gains
            thrust = replace(
                EXACT_THRUST,
                share=thrust.share,
                gains=count,
                names=thrust.names[:count],
                correlation=thrust.correlation[:count, :count],
                curves=thrust.curves[:0],
            )
        runs = []
        for table in tables:
            windows = chained_windows(packed, packed.vector, cut(packed, [table], channels))
            stack = stack_windows(packed, windows, channels)
            shared = run_nuisance(stack, 1)
            problem = FitProblem(stack, parameters, packed.vector, shared, thrust=thrust)
            runs.append(FittedRun(problem, problem.origin()))
        return cls(runs, np.zeros(runs[0].problem.size), [], [])

    def steps_of(self, number: int) -> FloatArray:
        """Parameters (n,) of a run."""
        own = self.x.copy()
        for shift, size in zip(self.taken, self.sizes, strict=True):
            if number in shift.runs:
                own += size * shift.direction
        return own

    def settle(self, rounds: int) -> None:
        """Go rounds of steps, each with derivatives made anew."""
        for _ in range(rounds):
            self.differentiate()
            self.step(_CHORDS)
            self.widen()

    def widen(self) -> None:
        """Take the noise for what the residuals of most runs show."""
        found: dict[str, list[float]] = {}
        for number, run in enumerate(self.runs):
            run.point = replace(run.point, steps=self.steps_of(number))
            factors = widened(run.problem.stack, residuals(run.problem, run.point))
            for rows in run.problem.stack.rows:
                quantity = rows.channel.quantity
                found.setdefault(quantity, []).append(factors.get(quantity, 1.0))
        self.wider = {quantity: float(np.median(each)) for quantity, each in found.items()}

    def differentiate(self) -> None:
        """Make the derivatives of every run where it stands."""
        for number, run in enumerate(self.runs):
            run.point = replace(run.point, steps=self.steps_of(number))
            run.known = derivatives(run.problem, run.point)

    def step(self, times: int) -> None:
        """Go so many steps with the derivatives at hand."""
        for _ in range(times):
            equations, columns = self._equations(), self._columns(self.taken)
            matrix, pull = self._normal(equations, columns)
            move = np.linalg.solve(matrix, pull)
            longest = float(np.abs(move[: self.x.size]).max(initial=0.0))
            share = min(1.0, LONGEST_STEP / max(longest, 1e-12))
            for run, own, design in zip(self.runs, equations, columns, strict=True):
                run.move(own, design @ move, share)
            self.x = np.maximum(self.x + share * move[: self.x.size], self.runs[0].problem.lowest)
            self.sizes = [
                a + share * b for a, b in zip(self.sizes, move[self.x.size :], strict=True)
            ]

    def take(self, change: RunChange) -> None:
        """Take a shift into the model."""
        self.taken.append(change.shift)
        self.sizes.append(change.value)

    def ask(self, shifts: Sequence[Shift], *, ordinary: bool = True) -> tuple[RunChange, ...]:
        """Estimate each shift beside those taken; p-values by Holm over what could be told.

        `ordinary` counts what single runs differ by without a cause: only once what differs is in
        the model, for until then it passes for the ordinary.
        """
        equations = self._equations()
        alone = [self._estimate(equations, shift) for shift in shifts]
        found = [self._tested(one, alone if ordinary else ()) for one in alone]
        told = [
            k
            for k, one in enumerate(found)
            if one.shift.kind != "run_parameter"
            and (one.shift.kind == "parameter" or one.std < _WIDEST_GAIN)
        ]
        p = np.ones(len(found))
        p[told] = adjusted([found[k].p_value for k in told])
        return tuple(replace(one, p_value=float(each)) for one, each in zip(found, p, strict=True))

    def _tested(self, one: RunChange, alone: Sequence[RunChange]) -> RunChange:
        """Test a shift against its noise and what other single runs, not taken, differ by."""
        name = one.shift.name
        aside = {run for shift in self.taken if shift.name == name for run in shift.runs}
        if len(one.shift.runs) == 1:
            aside |= set(one.shift.runs)
        rest = [
            (other.value, other.std)
            for other in alone
            if other.shift.name == name and len(other.shift.runs) == 1
            if not aside & set(other.shift.runs)
        ]
        values, stds = np.array(rest, float).reshape(-1, 2).T
        if one.shift.kind != "parameter" and values.size:
            values, stds = values[stds < _WIDEST_GAIN], stds[stds < _WIDEST_GAIN]
        size = float(np.abs(one.shift.direction).max())
        # by weight, so that a run that hardly shows it does not decide (DerSimonian and Laird 1986)
        weights = 1.0 / stds**2
        excess = float(np.sum(weights * values**2)) - values.size
        between = max(excess, 0.0) / float(weights.sum()) if values.size else 0.0
        ordinary = _ORDINARY_GAIN if one.shift.kind != "parameter" else _ORDINARY_SHARE / size
        std = (one.std**2 + between / len(one.shift.runs) + ordinary**2) ** 0.5
        windows = sum(len(self.runs[k].problem.stack.windows) for k in one.shift.runs)
        chance = 2.0 * float(stdtr(max(windows - 1, 1), -abs(one.value) / std))
        return replace(one, std=std, p_value=chance)

    def _equations(self) -> list[RunEquations]:
        return [
            run.equations(self.steps_of(number), self.wider) for number, run in enumerate(self.runs)
        ]

    def _columns(self, shifts: Sequence[Shift]) -> list[FloatArray]:
        """How (x, shifts) move the parameters of each run, (n, n + shifts)."""
        return [
            np.column_stack(
                [np.eye(self.x.size), *(one.direction * (number in one.runs) for one in shifts)]
            )
            for number in range(len(self.runs))
        ]

    def _normal(
        self, equations: Sequence[RunEquations], columns: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Set up the normal equations of (x, shifts), priors included."""
        count, own = columns[0].shape[1], self.x.size
        matrix, pull = 1e-9 * np.eye(count), np.zeros(count)
        precision = self.runs[0].problem.precision
        matrix[:own, :own] += precision
        pull[:own] = -precision @ self.x
        for one, design in zip(equations, columns, strict=True):
            matrix += design.T @ one.information @ design
            pull += design.T @ one.score
        return matrix, pull

    def _estimate(self, equations: Sequence[RunEquations], shift: Shift) -> RunChange:
        """Estimate one shift beside the others that are taken."""
        others = [one for one in self.taken if one is not shift]
        now = dict(zip([id(one) for one in self.taken], self.sizes, strict=True))
        columns = self._columns([*others, shift])
        matrix, pull = self._normal(equations, columns)
        inverse = np.linalg.inv(matrix)
        move = inverse @ pull
        # what the windows say once all has moved: their scatter counts where it is wider
        scatter = 0.0
        for own, design in zip(equations, columns, strict=True):
            left = own.scores - np.einsum("wij,j->wi", own.windows, design @ move)
            scatter += float(np.sum((left @ design @ inverse[-1]) ** 2))
        std = max(float(inverse[-1, -1]), scatter) ** 0.5
        value = now.get(id(shift), 0.0) + float(move[-1])
        problem, size = self.runs[0].problem, float(np.abs(shift.direction).max())
        index = int(np.argmax(np.abs(shift.direction)))
        at = float(self.x[index]) / size
        is_gain = index >= len(problem.parameters)
        nominal = 1.0 if is_gain else problem.parameters[index].nominal
        gain = value**2 / float(inverse[-1, -1])
        return RunChange(shift, nominal + at, value, std, gain, 1.0)
