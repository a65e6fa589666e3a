r"""From the likelihoods of runs to gains: of an axis, of a thruster, pooled over runs.

On an axis beta_i ~ N(b_i, (3 b_i)^2) where the file gives thruster i a lever b_i; where it gives
none, beta_i ~ N(0, (t L)^2) with L the typical lever of the axis and t the one of a grid under
which the run is most probable (empirical Bayes). Of a thruster, on all axes together,
beta_ia = b_ia (1 + d_a) (g_i + e_ia) (docs/methods/gains.md), linear about the last g.

Pooled by DerSimonian and Laird 1986, Control. Clin. Trials 7, 177-188, its interval by Student's t
with the variance of Hartung and Knapp 2001, Stat. Med. 20, 3875-3889, never narrower than without.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.identify.heading_check import HeadingCheck
from pipeline.identify.thruster_regression import AxisLikelihood, RunLikelihood
from pipeline.records.fit_values import NORMAL_95, student_95
from pipeline.records.gains import GainReference
from pipeline.types import BoolArray, FloatArray

#: Prior standard deviation of a gain: no thruster gives three times what its file says.
PRIOR_STD = 3.0
#: A gain whose interval reaches so far each way tells neither dead nor sound.
WIDEST = 1.0
#: A lever below this share of the largest of the axis is none.
LEAST_LEVER = 0.02
_COUPLED = (0.02, 0.06, 0.2, 0.6, 1.5)
#: Axis of a gain that all axes tell together.
ALL = "all"
#: Fewer sound runs do not tell what runs differ by: at least so much is taken.
_MANY, _FEW_BETWEEN = 4, 0.1


@dataclass(frozen=True)
class Doubt:
    """Relative standard deviations of what the file says: of an axis, and of a thruster on it."""

    axis: float
    thruster: float


@dataclass(frozen=True)
class Gain:
    """A gain that `runs` tell: mean, standard error, degrees of freedom, scatter between them."""

    mean: float
    std: float
    degrees: int
    between: float = 0.0
    runs: tuple[str, ...] = ()

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval."""
        return self.std * (student_95(self.degrees) if self.degrees > 0 else NORMAL_95)

    @property
    def ci95(self) -> tuple[float, float]:
        """The 95 % interval."""
        return self.mean - self.half_width, self.mean + self.half_width


#: (thruster, axis) -> the gain, and what sound runs gave.
Gains = dict[tuple[str, str], Gain]
References = Mapping[tuple[str, str], GainReference]


def moving(levers: FloatArray) -> BoolArray:
    """Tell which thrusters move which axes (6, n)."""
    size = np.abs(levers)
    return np.asarray(size > LEAST_LEVER * np.maximum(size.max(axis=1, keepdims=True), 1e-6))


def typical(levers: FloatArray) -> FloatArray:
    """Typical lever of each axis (6,): root mean square of those there are, 0 where none is."""
    there = moving(levers)
    count = np.maximum(there.sum(axis=1), 1)
    return np.asarray(np.sqrt(np.sum(np.where(there, levers, 0.0) ** 2, axis=1) / count))


def gaussian_posterior(
    information: FloatArray, vector: FloatArray, mean: FloatArray, covariance: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Mean and covariance of b ~ N(mean, covariance) by the likelihood exp(-b'Ib/2 + v'b).

    Third comes the log evidence, that of the likelihood averaged over the prior.
    """
    rest = vector - information @ mean
    inner = np.eye(len(mean)) + covariance @ information
    spread = np.asarray(np.linalg.solve(inner, covariance), float)
    moved = spread @ rest
    evidence = vector @ mean - 0.5 * mean @ information @ mean + 0.5 * rest @ moved
    return mean + moved, spread, float(evidence - 0.5 * np.linalg.slogdet(inner)[1])


def axis_gains(axis: AxisLikelihood, levers: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gains of the thrusters along an axis that is moved at all, and standard errors, (n,)."""
    lever, there = levers[axis.axis], moving(levers)[axis.axis]
    size = np.where(there, np.abs(lever), typical(levers)[axis.axis])
    mean = np.where(there, lever, 0.0)
    stds = (np.where(there, PRIOR_STD * size, coupled * size) for coupled in _COUPLED)
    beta, covariance, _ = max(
        (gaussian_posterior(axis.information, axis.vector, mean, np.diag(std**2)) for std in stds),
        key=lambda found: found[2],
    )
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return beta / np.where(there, lever, size), std / size


def joint_gains(
    run: RunLikelihood, levers: FloatArray, doubt: Doubt
) -> tuple[FloatArray, FloatArray]:
    """One gain of each thruster from all axes together, and standard errors, (n,)."""
    count = levers.shape[1]
    there, size = moving(levers), typical(levers)
    gains: FloatArray = np.ones(count)
    covariance: FloatArray = np.zeros((0, 0))
    prior = np.concatenate([np.full(count, PRIOR_STD**-2), np.full(6, doubt.axis**-2)])
    for _ in range(3):
        precision = np.diag(prior)
        vector = np.concatenate([np.full(count, PRIOR_STD**-2), np.zeros(6)])
        for axis in run.axes:
            a = axis.axis
            if size[a] == 0.0:
                continue
            lever = np.where(there[a], levers[a], 0.0)
            design = np.zeros((count, count + 6))
            design[:, :count] = np.diag(lever)
            # an axis' own factor is that of what its thrusters give, so a dead one has none of it
            design[:, count + a] = lever * np.clip(gains, -1.0, 1.0)
            off = np.where(there[a], doubt.thruster * np.abs(lever), 0.1 * size[a]) ** 2
            inner = np.eye(count) + axis.information * off
            known = np.linalg.solve(inner, np.column_stack([axis.information, axis.vector]))
            precision += design.T @ known[:, :-1] @ design
            vector += design.T @ known[:, -1]
        covariance = np.asarray(np.linalg.inv(0.5 * (precision + precision.T)), float)
        gains = (covariance @ vector)[:count]
    return gains, np.sqrt(np.diag(covariance)[:count])


def pool(values: Sequence[float], stds: Sequence[float], least_between: float = 0.0) -> Gain:
    """Pool a gain over runs by random effects.

    `least_between` is the standard deviation between runs that is taken at least: one or two runs
    tell none.

    Examples
    --------
    >>> found = pool([1.0, 1.2, 0.8], [0.1, 0.1, 0.1])
    >>> round(found.mean, 3), round(found.between, 3)
    (1.0, 0.173)
    """
    y, v = np.asarray(values, float), np.asarray(stds, float) ** 2
    weight = 1.0 / v
    fixed = float(weight @ y / weight.sum())
    count = len(y)
    between = least_between**2
    if count > 1:
        excess = float(weight @ (y - fixed) ** 2) - (count - 1)
        scale = float(weight.sum() - (weight**2).sum() / weight.sum())
        between = max(excess / max(scale, 1e-300), between)
    weight = 1.0 / (v + between)
    mean = float(weight @ y / weight.sum())
    variance = 1.0 / float(weight.sum())
    if count > 2:
        scatter = float(weight @ (y - mean) ** 2) / (count - 1)
        variance *= max(scatter, 1.0)
    return Gain(mean, variance**0.5, count - 1 if count > 2 else 0, between**0.5)


@dataclass(frozen=True)
class RunGains:
    """Everything of one run: likelihood, every gain, and of these what is known well enough."""

    likelihood: RunLikelihood
    gains: Gains
    told: Gains
    heading: HeadingCheck | None

    @property
    def name(self) -> str:
        """Name of the run."""
        return self.likelihood.run

    @classmethod
    def of(
        cls,
        run: RunLikelihood,
        names: Sequence[str],
        levers: FloatArray,
        doubt: Doubt,
        heading: HeadingCheck | None,
    ) -> Self:
        """Estimate the gains of thrusters of these `names` on all axes together and on each."""
        degrees = max((axis.degrees for axis in run.axes), default=3.0)
        found = {ALL: (*joint_gains(run, levers, doubt), degrees)}
        for axis in run.axes:
            if typical(levers)[axis.axis] > 0.0:
                found[axis.name] = (*axis_gains(axis, levers), axis.degrees)
        gains, told = Gains(), Gains()
        for axis_name, (values, stds, degrees) in found.items():
            every = zip(names, values.tolist(), stds.tolist(), run.excited.tolist(), strict=True)
            for name, value, std, excited in every:
                one = Gain(value, std, max(int(degrees), 1), runs=(run.run,))
                gains[name, axis_name] = one
                if excited and one.half_width < WIDEST:
                    told[name, axis_name] = one
        return cls(run, gains, told, heading)


@dataclass(frozen=True)
class GainSet:
    """Runs of a vehicle that were regressed, and what is needed to compare them."""

    names: tuple[str, ...]
    levers: FloatArray
    doubt: Doubt
    runs: tuple[RunGains, ...]
    why_not: dict[str, str] = field(default_factory=dict)
    called: str = ""
    """How the runs are called; by their names where that is empty."""

    def moves(self, thruster: str, axis: str) -> bool:
        """Tell whether a thruster moves an axis."""
        if axis == ALL:
            return True
        return bool(moving(self.levers)[AXES.index(axis), self.names.index(thruster)])

    def pooled(self, least_between: float = 0.0) -> Gains:
        """Pool each gain over the runs that tell it."""
        told: dict[tuple[str, str], list[Gain]] = {}
        for run in self.runs:
            for key, row in run.told.items():
                told.setdefault(key, []).append(row)
        return {
            key: replace(
                pool([one.mean for one in rows], [one.std for one in rows], least_between),
                runs=tuple(run for one in rows for run in one.runs),
            )
            for key, rows in told.items()
        }

    def apart_from(self, *runs: str) -> References:
        """Take the runs for sound, but for some, and say what they gave."""
        kept = tuple(run for run in self.runs if run.name not in runs)
        least = max(self.doubt.thruster, 0.0 if len(kept) >= _MANY else _FEW_BETWEEN)
        name = self.called or ", ".join(run.name for run in kept)
        return {
            key: GainReference(
                name=name, runs=one.runs, mean=one.mean, ci95=one.ci95, between_runs=one.between
            )
            for key, one in replace(self, runs=kept).pooled(least).items()
        }
