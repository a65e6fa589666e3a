"""Slope of acceleration against thrust: plain, with noise in both, and with the terms left out.

All of them fit du/dt = tau / M + ... by least squares and give M = 1 / slope; the samples overlap
(a smoother made them), so no interval counts them as independent: it is that of leaving out one
block of them at a time, with Student's t for the number of blocks (`blocks_of`). Noise in the
thrust pulls a slope towards zero: over the reliability of the thrust, 1 - s_tau^2 / var(tau), it is
free of that (Fuller 1987, section 1.1).
"""

from collections.abc import Collection

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.channel_noise import was_measured
from pipeline.identify.linear_fit import Judgement, LinearFit, fit_linear
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable, down_axis
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray, IntArray

#: Lengths of a block that are tried, in lags of the smoother, until every block can be left out.
#: Longer blocks depend on each other less, and are fewer.
_BLOCK_LAGS = (10, 5, 2, 1)
#: The least that a scatter between blocks is taken from where one stretch is all there is.
_FEWEST_BLOCKS = 4


def blocks_of(stretch: IntArray, length: int) -> IntArray:
    """Cut stretches (m,), ascending, into blocks of about `length` samples, and number them (m,).

    No block spans two stretches; a short one is a block as it is.

    Examples
    --------
    >>> blocks_of(np.array([0, 0, 0, 0, 1]), 2).tolist()
    [0, 0, 1, 1, 2]
    """
    _, sizes = np.unique(stretch, return_counts=True)
    least = _FEWEST_BLOCKS if sizes.size == 1 else 1
    parts, first = [], 0
    for size in sizes.tolist():
        count = min(max(round(size / length), least), size)
        parts.append(first + np.arange(size) * count // size)
        first += count
    return np.concatenate(parts)


def least_squares(
    design: FloatArray, response: FloatArray, stretch: IntArray, lags: int
) -> LinearFit:
    """Ordinary least squares with a covariance that honours autocorrelation within stretches.

    The thrust is the first of the regressors `design` (m, k), the constant is among them. `stretch`
    (m,) labels samples, ascending; nothing correlates across stretches, and up to `lags` samples
    residuals go together.

    Raises
    ------
    CannotComputeError
        With too few samples, or regressors that depend on each other or show in one place alone.
    """
    every = Judgement(np.zeros(response.size), np.zeros(response.size, bool))
    for size in _BLOCK_LAGS:
        block = blocks_of(stretch, size * lags)
        try:
            found = fit_linear(design, response, clusters=block, judged=every)
        except CannotComputeError as error:
            raise CannotComputeError(f"acceleration against thrust: {error}") from None
        if found.clustered:
            return found
    raise CannotComputeError("the thrust, or what acts beside it, varies in a single moment alone")


def plain_slope(
    thrust: FloatArray, acceleration: FloatArray, stretch: IntArray, lags: int
) -> LinearFit:
    """Least-squares slope with a common constant, eq. (4) of Potapov and Galyaev: the first one."""
    design = np.column_stack([thrust, np.ones_like(thrust)])
    return least_squares(design, acceleration, stretch, lags)


def reliability(thrust: FloatArray, thrust_noise: float) -> float:
    """Share of the thrust's variance that is signal, not noise; not below 0.05."""
    return float(max(1.0 - thrust_noise**2 / max(float(np.var(thrust)), 1e-300), 0.05))


WEIGHT, WALLS = "weight along the axis", "nearness of walls x thrust"
#: Units of the coefficients that are no plain ratio.
UNITS = {"linear drag": "1/s", "quadratic drag": "1/m", WEIGHT: "m/s^2", WALLS: "1/kg"}
#: A regressor counts if at least this share of it is not in the others already.
OWN_SHARE = 0.02
#: Largest coefficients to expect: of rotation (m + A_jj) / (m + A_ii), of the weight along the axis
#: (W - B) / M at 2 % residual buoyancy [m/s^2]. Drag and walls are always asked for.
_LARGEST = {"rotation": 3.0, "weight": 0.2}
#: A term that at its largest moves the acceleration by less than this share of its noise is left
#: out: its coefficient could only be noise.
_NOTICEABLE = 0.1

_ROTATION = (
    (("sway speed x yaw rate", 1, 2, 1.0), ("heave speed x pitch rate", 2, 1, -1.0)),
    (("surge speed x yaw rate", 0, 2, -1.0), ("heave speed x roll rate", 2, 0, 1.0)),
    (("sway speed x roll rate", 1, 0, -1.0), ("surge speed x pitch rate", 0, 1, 1.0)),
)


def omitted_terms(
    packed: PackedVehicle, run: RunTable, velocity: FloatArray, thrust: FloatArray, along: int
) -> dict[str, FloatArray]:
    """Return the regressors (m,) of one axis at every sample of a run.

    Rotation: the parts of -(omega x v), each with its own coefficient, as the added masses of the
    other axes are not this one's. Drag: -v and -v|v|. Buoyancy: the component of "down" along the
    axis. Walls: the nearness sum (R / distance)^3 times the thrust, where the vehicle file states
    walls and the run has a position: 1 / (m + A (1 + c s)) is 1 / M - s c A / M^2 to first order.
    `velocity` (m, 3) is that of the body origin [m/s], `thrust` (m,) goes along the axis [N].
    """
    omega = np.nan_to_num(run.values["angular_velocity"])
    v = velocity[:, along]
    terms = {
        name: sign * velocity[:, speed] * omega[:, rate]
        for name, speed, rate, sign in _ROTATION[along]
    }
    terms["linear drag"] = -v
    terms["quadratic drag"] = -v * np.abs(v)
    if was_measured(run, "attitude"):
        terms[WEIGHT] = down_axis(np.nan_to_num(run.values["attitude"]))[:, along]
    walls = int(read(packed.vector, "wall_count"))
    if walls and was_measured(run, "position"):
        points = read(packed.vector, "wall_point")[:walls]
        normals = read(packed.vector, "wall_normal")[:walls]
        radius = float(read(packed.vector, "wall_radius"))
        place = np.nan_to_num(run.values["position"])
        distance = np.einsum("mkj,kj->mk", place[:, None, :] - points, normals)
        near = np.sum((radius / np.maximum(distance, radius)) ** 3, axis=1)
        # a vehicle beyond a wall: the walls of the file are not those of this run
        if distance[run.valid["position"]].min(initial=np.inf) > 0.0:
            terms[WALLS] = near * thrust
    return terms


def terms_known(run: RunTable, terms: Collection[str]) -> BoolArray:
    """Rows (m,) of a run at which all that terms of `omitted_terms` are made of is known.

    Elsewhere a term holds zeros in place of readings, and whatever is taken over such a row is not
    to be used.
    """
    known = run.valid["angular_velocity"]
    for name, quantity in ((WEIGHT, "attitude"), (WALLS, "position")):
        if name in terms:
            known = known & run.valid[quantity]
    return known


def usable_terms(
    thrust: FloatArray, terms: dict[str, FloatArray], acceleration_noise: float
) -> tuple[str, ...]:
    """Names of the terms that vary enough to be seen, and not only together with the others.

    A term enters if at least `OWN_SHARE` of its variation is left after the thrust, a constant and
    the terms before it are taken out, and if it could move the acceleration noticeably. Terms (m,)
    are filtered as the acceleration, whose noise is in m/s^2.
    """
    columns = [thrust, np.ones_like(thrust)]
    used = []
    for name, signal in terms.items():
        varies = float(np.linalg.norm(signal - signal.mean()))
        kind = "rotation" if " rate" in name else "weight" if "weight" in name else ""
        largest = _LARGEST.get(kind, np.inf) * varies / np.sqrt(max(signal.size, 1))
        if varies <= 1e-9 * max(float(np.linalg.norm(signal)), 1e-9):
            continue
        if largest < _NOTICEABLE * acceleration_noise:
            continue
        basis, _ = np.linalg.qr(np.column_stack(columns))
        rest = signal - basis @ (basis.T @ signal)
        if float(np.linalg.norm(rest)) > OWN_SHARE * varies:
            used.append(name)
            columns.append(signal)
    return tuple(used)
