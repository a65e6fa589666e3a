"""Tests of gains: one number a question, a p-value each, all of them counted together.

What is asked: docs/methods/gains.md. The evidence ratio of a hypothesis exceeds k with a chance of
at most 1 / k where the other is true (Markov's inequality; Wasserman, Ramdas and Balakrishnan 2020,
PNAS 117(29), 16880-16890), so that 1 / ratio is a p-value. The family-wise rate is held by Holm
1979, Scand. J. Statist. 6(2), 65-70.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from pipeline.identify.gain_estimates import Doubt, gaussian_posterior, typical
from pipeline.identify.thruster_regression import RunLikelihood
from pipeline.records.gains import FindingKind
from pipeline.types import FloatArray


@dataclass(frozen=True)
class GainQuestion:
    """One comparison: what would be found, in which runs, and how unlikely it is by chance.

    `p` counts this question alone, `chance` all of them.
    """

    kind: FindingKind
    p: float
    runs: tuple[str, ...]
    thrusters: tuple[str, ...] = ()
    axis: str | None = None
    value: float | None = None
    ci95: tuple[float, float] | None = None
    expected: float | None = None
    against: str = ""
    chance: float = 1.0


def sentence(one: GainQuestion, runs: Sequence[str]) -> str:
    """Say what was found, in which `runs`, and what to look at; `one` is clearest of it."""
    figure = ""
    if one.value is not None and one.ci95 is not None:
        low, high = one.ci95
        figure = f"{one.value:.2f} [{low:.2f}, {high:.2f}]"
    expected = "" if one.expected is None else f"{one.expected:.2f}"
    names, where, against = " and ".join(one.thrusters), _where(runs), one.against
    value = "" if one.value is None else f"{one.value:.2f}"
    said = {
        "dead": f"{names} gives nothing: {figure} of what the vehicle file says, {where}.",
        "reversed": f"{names} pushes the other way: {figure} of what the file says, {where}.",
        "weak": f"{names} gives less than expected: {figure} of what the vehicle file says, "
        f"where {against} let expect {expected}, {where}.",
        "strong": f"{names} gives more than expected: {figure} of what the vehicle file says, "
        f"where {against} let expect {expected}, {where}.",
        "swapped": f"{names} look exchanged: each moves the vehicle as the other should, {where}. "
        "Check the order of the commands and the wiring.",
        "axis_reversed": f"{one.axis}: what was measured goes against every thruster, {where}. "
        "Check the sign and the axes of the sensor, then the directions of the thrusters.",
        "coupled": f"{names} moves {one.axis}, which by its place and direction it cannot: "
        f"{figure} of a typical thruster there, {where}.",
        "heading_reversed": f"the heading counts the other way: its rate goes against {against} "
        f"(correlation {value}), {where}. Check the sign of the heading, and of what it goes "
        "against.",
        "common_scale": f"all thrusters give {figure} of what they gave in {against}, alike, "
        f"{where}: no single thruster's fault. Look at the supply, the pilot's gain, the mass.",
    }
    return said[one.kind]


def _where(runs: Sequence[str]) -> str:
    if len(runs) == 1:
        return f"in {runs[0]}"
    if len(runs) <= 3:
        return f"in {', '.join(runs)}"
    return f"in {len(runs)} runs ({', '.join(runs[:2])}, ...)"


#: Chance of any finding at all where every run is sound.
FALSE_ALARMS = 0.01
#: Share of a typical thruster that one moves an axis by which it should not move, and is ordinary.
ORDINARY_COUPLING = 0.2
#: Standard deviations of a gain under the file's levers, and under levers that are exchanged.
_ANY_GAIN, _USUAL_GAIN = 1.0, 0.4
#: What a thruster's effect on one axis may differ from that on the others by, and be ordinary.
_LOOSE = 0.3


@dataclass(frozen=True)
class LeverLayout:
    """Levers (6, n) that a hypothesis puts in place of the file's."""

    kind: FindingKind
    thrusters: tuple[int, ...]
    axis: int | None
    levers: FloatArray


def other_layouts(levers: FloatArray) -> list[LeverLayout]:
    """List exchanged pairs, and axes that count the other way."""
    count = levers.shape[1]
    found = []
    for first, second in itertools.combinations(range(count), 2):
        order = np.arange(count)
        order[[first, second]] = second, first
        if not np.allclose(levers, levers[:, order]):
            found.append(LeverLayout("swapped", (first, second), None, levers[:, order]))
    for axis in np.flatnonzero(typical(levers) > 0.0):
        turned = levers.copy()
        turned[axis] *= -1.0
        found.append(LeverLayout("axis_reversed", (), int(axis), turned))
    return found


def layout_evidence(
    run: RunLikelihood, levers: FloatArray, doubt: Doubt, *, exchanged: bool = False
) -> float:
    """Log evidence of a run for levers: the file's with any gains, `exchanged` ones with usual."""
    gain_std = _USUAL_GAIN if exchanged else _ANY_GAIN
    count, axes = levers.shape[1], [one for one in run.axes if np.any(levers[one.axis])]
    size = typical(levers)
    information = np.zeros((len(axes) * count, len(axes) * count))
    vector, mean = np.zeros(len(information)), np.zeros(len(information))
    design = np.zeros((len(information), count))
    covariance = np.zeros_like(information)
    for k, one in enumerate(axes):
        part = slice(k * count, (k + 1) * count)
        lever = levers[one.axis]
        information[part, part], vector[part], mean[part] = one.information, one.vector, lever
        design[part] = np.diag(lever)
        covariance[part, part] = doubt.axis**2 * np.outer(lever, lever) + np.diag(
            (max(doubt.thruster, _LOOSE) * lever) ** 2 + (ORDINARY_COUPLING * size[one.axis]) ** 2
        )
    covariance += gain_std**2 * design @ design.T
    return gaussian_posterior(information, vector, mean, covariance)[2]


def against_all(runs: Sequence[RunLikelihood], lever: FloatArray, axis: int) -> float:
    """Probability of a common gain of all thrusters on an axis that is so far below zero."""
    told = [one for run in runs for one in run.axes if one.axis == axis]
    size = float(sum(lever @ one.information @ lever for one in told))
    if size <= 0.0:
        return 1.0
    gain = float(sum(lever @ one.vector for one in told)) / size
    degrees = sum(one.degrees for one in told)
    # what a coupling that is ordinary makes of it is no sign of the axis
    return tail(gain, float(np.hypot(size**-0.5, ORDINARY_COUPLING)), degrees)


def tail(value: float, std: float, degrees: float) -> float:
    """Probability of at most so small a value, by Student's t."""
    return float(stdtr(max(degrees, 1.0), value / max(std, 1e-12)))


def adjusted(p_values: Sequence[float]) -> FloatArray:
    """Return Holm's adjusted p-values, at most 1: what is below a rate is rejected at that rate.

    Examples
    --------
    >>> adjusted([0.001, 0.02, 0.004]).tolist()
    [0.003, 0.02, 0.008]
    """
    p = np.asarray(p_values, float)
    order, found = np.argsort(p), np.ones(p.size)
    steps = p[order] * (p.size - np.arange(p.size))
    found[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return found
