"""Least squares of a few coefficients beside many terms that nobody asks for.

The terms are taken off both sides first (Frisch and Waugh 1933, Econometrica 1(4), 387-401), with
priors on what they may be; rows have weights.
"""

import numpy as np

from pipeline.types import FloatArray, IntArray

#: A row whose leverage is so many times the mean counts less.
LEVERAGE = 3.0


def bounded(partial: FloatArray) -> FloatArray:
    """Weights (k,) of rows that bound how much of the answer rests on a single one."""
    normal = partial.T @ partial
    normal[np.diag_indices_from(normal)] += 1e-9 * max(float(np.trace(normal)), 1e-300)
    leverage = np.sum(partial * np.linalg.solve(normal, partial.T).T, axis=1)
    return np.asarray(
        np.minimum(1.0, LEVERAGE * leverage.mean() / np.maximum(leverage, 1e-300)), float
    )


def less_known(  # noqa: PLR0917  one system of equations
    known: FloatArray,
    size: FloatArray,
    held: FloatArray,
    thrust: FloatArray,
    response: FloatArray,
    weight: FloatArray,
    noise: float,
) -> tuple[FloatArray, FloatArray]:
    """Take what the known terms explain off the thrusts and the left side."""
    scaled = known / size
    weighted = weight[:, None] * scaled
    normal = scaled.T @ weighted
    # a whisker for terms that go together: what each of them gets is of no account
    normal[np.diag_indices_from(normal)] += noise / (held * size) ** 2 + 1e-9 * len(response)
    both = np.column_stack([thrust, response])
    both = both - scaled @ np.linalg.solve(normal, weighted.T @ both)
    return both[:, :-1], both[:, -1]


def solve(
    partial: FloatArray, rest: FloatArray, weight: FloatArray, terms: int
) -> tuple[FloatArray, float, FloatArray]:
    """Solve for beta; also the variance of what it leaves, and that."""
    weighted = weight[:, None] * partial
    normal = partial.T @ weighted
    normal[np.diag_indices_from(normal)] += 1e-9 * max(float(np.trace(normal)), 1e-300)
    beta = np.linalg.solve(normal, weighted.T @ rest)
    error = rest - partial @ beta
    degrees = max(float(weight.sum()) - partial.shape[1] - terms, 1.0)
    noise = max(float((weight * error**2).sum()) / degrees, 1e-300)
    return np.asarray(beta, float), noise, error


def widened(information: FloatArray, scores: FloatArray, label: IntArray) -> FloatArray:
    """Take from each direction what its scores vary more over blocks than independent ones do."""
    _, where = np.unique(label, return_inverse=True)
    blocks = int(where.max()) + 1
    size, axes = np.linalg.eigh(0.5 * (information + information.T))
    sums = np.zeros((blocks, scores.shape[1]))
    np.add.at(sums, where, scores)
    more = np.sum((sums @ axes) ** 2, axis=0) * blocks / max(blocks - 1, 1)
    ratio = np.maximum(more / np.maximum(size, 1e-12 * max(float(size[-1]), 1e-300)), 1.0)
    return np.asarray((axes * (np.maximum(size, 0.0) / ratio)) @ axes.T)
