r"""What dead reckoning says of the errors of a DVL: information and score, with honest noise.

The noise of a stretch of duration T is that of a random walk (noise of the velocity, of variance
v T) and of the readings at its ends (2 v c, of which -v c is shared with the next stretch). v and c
are those that make what is left most probable, for the horizontal and the vertical. A constant
error of a run's attitude is integrated out. Where what is left hangs together over a quarter of a
minute, the information is worth less: sandwich estimator over such blocks, each with what it lacks
to the fit without it (White 1980, Econometrica 48(4), 817-838; CR3 of Bell and McCaffrey 2002,
Survey Methodology 28(2), 169-181).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from pipeline.diagnose.kinematics.dead_reckoning import NEUTRAL, Mount, Stretches, Track, stretches
from pipeline.types import FloatArray

#: Steps in which the errors are sought, and the share of a unit at which no further is taken.
_STEPS, _SETTLED = 6, 0.01
#: Rounds in which noise and errors are estimated in turns.
_ROUNDS = 2
#: Ratios c of the noise of the place to that of the velocity that are tried. [s]
_RATIOS = np.concatenate([[0.0], np.geomspace(0.01, 100.0, 25)])
#: Stretches that are needed at least.
_LEAST = 20
#: What is left in the same time of a run hangs together. [s]
_BLOCK_S = 15.0
#: Variance that an error has before anything is measured, in its units. It is taken off again: it
#: keeps what hardly shows near neutral, far from which a stretch would seem to tell of it.
_WIDE = 1.0
#: Where errors are sought, for the delay [s] and the scale.
_MOST_LATE_S, _SCALES = 3.0, (0.2, 5.0)


@dataclass(frozen=True)
class Reckoning:
    """Information (8, 8) and score (8,) about the departures of the errors from neutral.

    In the units that they were asked for in. `count` is the number of stretches.
    """

    information: FloatArray
    score: FloatArray
    count: int


@dataclass(frozen=True)
class _Noise:
    """Variance of the random walk [m^2/s], and the ratio of the noise of the place to it. [s]."""

    walk: float
    ratio: float


@dataclass(frozen=True)
class _Normal:
    """Normal equations of errors and attitudes (p, p), (p,), and each row's part in them."""

    matrix: FloatArray
    score: FloatArray
    rows: tuple[tuple[Stretches, FloatArray, FloatArray], ...]


def reckoning(
    tracks: Sequence[Track], mount: Mount, unit: FloatArray, wander_rad: float
) -> Reckoning | None:
    """Estimate the errors of a DVL by dead reckoning.

    Parameters
    ----------
    tracks : sequence of Track
        The runs.
    mount : Mount
        How the DVL is stated to sit.
    unit : ndarray, shape (8,)
        Units of the errors, in the order of `dead_reckoning.ERRORS`.
    wander_rad : float
        Standard deviation of the attitude's error over a run.

    Returns
    -------
    Reckoning or None
        None where there are too few stretches.
    """
    errors = NEUTRAL.copy()
    noise = {False: _Noise(1.0, 1.0), True: _Noise(1.0, 1.0)}
    size = len(NEUTRAL)
    wide = np.zeros((size + 3 * len(tracks),) * 2)
    wide[:size, :size] = np.diag(1.0 / (_WIDE * unit**2))
    wide[size:, size:] = np.eye(3 * len(tracks)) / max(wander_rad, 1e-3) ** 2
    for _ in range(_STEPS):
        rows = stretches(tracks, errors, mount)
        if sum(one.lacks.size for one in rows) < _LEAST:
            return None
        pull = np.zeros(len(wide))
        pull[:size] = (NEUTRAL - errors) / (_WIDE * unit**2)
        for _ in range(_ROUNDS):
            normal = _normal(rows, noise, len(wide))
            best = np.asarray(np.linalg.solve(normal.matrix + wide, normal.score + pull), float)
            noise = _noise_of(rows, best, noise)
        move = best[:size]
        if float(np.abs(move / unit).max()) < _SETTLED:
            break
        errors = errors + move
        errors[0] = np.clip(errors[0], -_MOST_LATE_S, _MOST_LATE_S)
        errors[7] = np.clip(errors[7], *_SCALES)
    rows = stretches(tracks, errors, mount)
    count = sum(one.lacks.size for one in rows)
    if count < _LEAST:
        return None
    normal = _normal(rows, noise, len(wide))
    return _without_attitude(normal, wide, errors, unit, count)


def _without_attitude(
    normal: _Normal, wide: FloatArray, errors: FloatArray, unit: FloatArray, count: int
) -> Reckoning:
    """Integrate the attitudes out, and widen by what the residuals hang together."""
    size = len(NEUTRAL)
    covariance = np.asarray(np.linalg.inv(normal.matrix + wide), float)
    widen = _widening(normal, covariance) * np.sqrt(count / max(count - len(wide), 1))
    matrix = normal.matrix + wide
    share = np.linalg.solve(matrix[size:, size:], normal.matrix[size:, :size]).T
    information = normal.matrix[:size, :size] - share @ normal.matrix[size:, :size]
    score = normal.score[:size] - share @ normal.score[size:]
    # what is left of the way from where it was linear; each error is widened by a factor of its own
    rest = np.linalg.solve(information + wide[:size, :size], score)
    per_unit = unit / widen
    information = information * np.outer(per_unit, per_unit)
    departure = (errors - NEUTRAL + rest) / unit
    return Reckoning((information + information.T) / 2, information @ departure, count)


def _widening(normal: _Normal, covariance: FloatArray) -> FloatArray:
    """Widen the deviations (8,) by what blocks of a run make them, where that is more.

    What a block lacks is taken from the fit to the others: its own fit has followed it.
    """
    best = covariance @ normal.score
    parts: dict[tuple[int, int], list[tuple[FloatArray, FloatArray]]] = {}
    for one, columns, lacks in normal.rows:
        left = lacks - columns @ best
        for block in np.unique(one.middle_s // _BLOCK_S):
            own = one.middle_s // _BLOCK_S == block
            parts.setdefault((one.run, int(block)), []).append((columns[own], left[own]))
    blocks = []
    for of_block in parts.values():
        columns = np.concatenate([one for one, _ in of_block])
        left = np.concatenate([one for _, one in of_block])
        blocks.append(columns.T @ left_without(columns, left, covariance))
    scores = np.stack(blocks)
    robust = covariance @ (scores.T @ scores) @ covariance
    robust *= len(scores) / max(len(scores) - 1, 1)
    size = len(NEUTRAL)
    return np.asarray(np.sqrt(np.maximum(np.diag(robust)[:size] / np.diag(covariance)[:size], 1.0)))


def left_without(columns: FloatArray, left: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return what a block lacks (k,) to the fit without it, given what it lacks to the whole fit.

    (I - X_g P X_g')^-1 e_g for its rows X_g, `columns` (k, p), and e_g, `left` (k,), of unit noise;
    P is the `covariance` (p, p) of the whole fit, its prior included. Bell and McCaffrey 2002.
    """
    followed = columns @ covariance @ columns.T
    return np.asarray(np.linalg.solve(np.eye(left.size) - followed, left))


def _normal(rows: Sequence[Stretches], noise: Mapping[bool, _Noise], size: int) -> _Normal:
    matrix, score, parts = np.zeros((size, size)), np.zeros(size), []
    for one in rows:
        columns = _columns(one, size)
        own = noise[one.axis == 2]
        root = np.linalg.cholesky(own.walk * _covariance(one, own.ratio))
        columns, lacks = np.linalg.solve(root, columns), np.linalg.solve(root, one.lacks)
        matrix += columns.T @ columns
        score += columns.T @ lacks
        parts.append((one, columns, lacks))
    return _Normal(matrix, score, tuple(parts))


def _columns(one: Stretches, size: int) -> FloatArray:
    """Columns (n, size) of the errors and of every run's attitude."""
    found, first = np.zeros((one.lacks.size, size)), len(NEUTRAL) + 3 * one.run
    found[:, : len(NEUTRAL)] = one.causes
    found[:, first : first + 3] = one.turned
    return found


def _covariance(one: Stretches, ratio: float) -> FloatArray:
    """Covariance (n, n) of what stretches lack, over the variance of the random walk."""
    own, shared = _diagonals(one, ratio)
    return np.diag(own) + np.diag(shared[:-1], 1) + np.diag(shared[:-1], -1)


def _diagonals(one: Stretches, ratio: float) -> FloatArray:
    """Diagonals (2, n) of that covariance: its own, and the one below it."""
    shared = np.concatenate([np.where(one.joined, -ratio, 0.0), [0.0]])
    return np.stack([one.duration_s + 2.0 * ratio, shared])


def _noise_of(
    rows: Sequence[Stretches], best: FloatArray, before: Mapping[bool, _Noise]
) -> dict[bool, _Noise]:
    """Most probable noise of what is left, horizontal (False) and vertical (True)."""
    found = dict(before)
    for vertical in (False, True):
        left = [
            (one, one.lacks - _columns(one, best.size) @ best)
            for one in rows
            if (one.axis == 2) == vertical
        ]
        if left:
            found[vertical] = max((_likely(left, ratio) for ratio in _RATIOS), key=itemgetter(0))[1]
    return found


def _likely(left: Sequence[tuple[Stretches, FloatArray]], ratio: float) -> tuple[float, _Noise]:
    """Log likelihood of what is left at the most probable random walk, which goes with it."""
    square, log_determinant, count = 0.0, 0.0, 0
    for one, values in left:
        # a stretch shares noise with its neighbours alone: two diagonals
        root = cholesky_banded(_diagonals(one, ratio), lower=True, check_finite=False)
        square += float(values @ cho_solve_banded((root, True), values, check_finite=False))
        log_determinant += 2.0 * float(np.log(root[0]).sum())
        count += values.size
    walk = max(square / count, 1e-12)
    return -0.5 * (count * np.log(walk) + log_determinant), _Noise(walk, ratio)
