r"""Added mass from the slope of acceleration against thrust, after Potapov and Galyaev.

On a straight stretch without rotation, with whatever else acts constant (their eq. 4),

.. math:: \dot u = \tau / M + \mathrm{const}, \qquad A = 1 / \mathrm{slope} - m

with acceleration and thrust filtered alike (`straight_line_samples`). Beside it the regression with
the terms that the equation omits, over all samples, turns included.

The samples overlap (a smoother made them), so no interval counts them as independent: it is that of
leaving out one block of them at a time, with Student's t for the number of blocks (`blocks_of`).
Noise in the thrust pulls a slope towards zero: over the reliability of the thrust,
1 - s_tau^2 / var(tau), it is free of that (Fuller 1987, section 1.1).
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.linear_fit import Judgement, LinearFit, fit_linear
from pipeline.identify.smoothing import Method
from pipeline.identify.straight_line_samples import UNITS, WEIGHT, filtered_samples
from pipeline.physics.parameters import read
from pipeline.records.identification import (
    RegressionTerm,
    SlopeEstimate,
    StraightLineIdentification,
)
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.pack_hull import vector_under
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.sensor_schema import Sensors

AXES = ("surge", "sway", "heave")
BANDWIDTH_HZ = 0.4
#: Standard deviation of the thrust's error from reading to reading, as a share of its rms.
THRUST_SCATTER = 0.02
#: Points of the picture.
MOST_POINTS = 400
#: A shift of the total mass by the omitted terms that is worth a warning.
NOTABLE_SHIFT = 0.1
#: Lengths of a block that are tried, in lags of the smoother, until every block can be left out.
#: Longer blocks depend on each other less, and are fewer.
_BLOCK_LAGS = (10, 5, 2, 1)
#: The least that a scatter between blocks is taken from where one stretch is all there is.
_FEWEST_BLOCKS = 4
#: A regressor counts if at least this share of it is not in the others already.
OWN_SHARE = 0.02
#: Largest coefficients to expect: of rotation (m + A_jj) / (m + A_ii), of the weight along the axis
#: (W - B) / M at 2 % residual buoyancy [m/s^2]. Drag and walls are always asked for.
_LARGEST = {"rotation": 3.0, WEIGHT: 0.2}
#: A term that at its largest moves the acceleration by less than this share of its noise is left
#: out: its coefficient could only be noise.
_NOTICEABLE = 0.1


def straight_line(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    *,
    axis: str = "surge",
    method: Method = "local_polynomial",
    bandwidth_hz: float = BANDWIDTH_HZ,
) -> StraightLineIdentification:
    """Estimate an added mass by the slope, without and with the terms that the slope omits.

    Along an `axis`, surge, sway or heave, with the velocity smoothed to -3 dB at `bandwidth_hz`.

    Raises
    ------
    CannotComputeError
        Without velocity, or where no stretch is straight, or the thrust does not vary in them.
    """
    along = AXES.index(axis)
    found = [filtered_samples(packed, sensors, run, along, method, bandwidth_hz) for run in runs]
    acceleration, thrust, valid = (
        np.concatenate([getattr(one, name) for one in found])
        for name in ("acceleration", "thrust", "valid")
    )
    run_number = np.repeat(np.arange(len(found)), [one.stretch.size for one in found])
    before = np.cumsum([0, *(len(one.segments) for one in found)])[run_number]
    stretch = np.concatenate([one.stretch for one in found])
    stretch = np.where(stretch < 0, -1, stretch + before)
    segments = tuple(segment for one in found for segment in one.segments)
    inside = stretch >= 0
    if inside.sum() < 10:
        raise CannotComputeError(
            f"{', '.join(run.name for run in runs)}: no stretch along {axis} is straight for long "
            "enough (see the thresholds in docs/methods/identification.md); fly surge_steps, or "
            "use the whole-vehicle fit"
        )
    smoother, noise = found[0].smoother, found[0].noise
    lags = smoother.derivative.size
    scatter = THRUST_SCATTER * float(np.sqrt(np.mean(thrust[inside] ** 2)))
    mass = _dry_mass(packed, runs)
    slope = plain_slope(thrust[inside], acceleration[inside], stretch[inside], lags)
    share = reliability(thrust[inside], scatter)
    value, ends = slope.coefficients[0], slope.ci95[0]
    name, note = "least squares over reliability", f"reliability {share:.4f}"
    plain = (
        estimate("least squares", value, ends, mass, "jackknife over blocks"),
        estimate(name, value / share, ends / share, mass, note),
    )
    terms = {
        name: np.concatenate([one.terms[name] for one in found])[valid]
        for name in found[0].terms
        if all(name in one.terms for one in found)
    }
    # gaps may leave no sample at which all terms are known
    used = usable_terms(thrust[valid], terms, noise) if valid.any() else ()
    terms = {name: terms[name] for name in used}
    full, coefficients = _with_terms(
        thrust[valid], acceleration[valid], terms, run_number[valid], lags, mass
    )
    pairs = np.stack([thrust[inside], acceleration[inside]], axis=1)
    return StraightLineIdentification(
        vehicle=packed.name,
        axis=axis,
        segments=segments,
        seconds=float(sum(one.to_s - one.from_s for one in segments)),
        smoother=f"{smoother.method.replace('_', ' ')} over {smoother.length_s:.2f} s",
        bandwidth_hz=smoother.derivative_bandwidth_hz,
        acceleration_noise_mps2=noise,
        thrust_noise_n=scatter,
        reliability=share,
        dry_mass_kg=mass,
        plain=plain,
        with_terms=full,
        terms=coefficients,
        warnings=_warnings(plain, full),
        points=pairs[:: -(-len(pairs) // MOST_POINTS)].round(6).tolist(),
    )


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
        kind = "rotation" if " rate" in name else name
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


def _dry_mass(packed: PackedVehicle, runs: Sequence[RunTable]) -> float:
    """Mean over the time of the runs, with what the vehicle is known to have carried. [kg]."""
    masses, seconds = [], []
    for run in runs:
        ends = [0, *run.changes, run.time_s.size - 1]
        for first, last in pairwise(ends):
            known = run.conditions_at(float(run.time_s[first]))
            masses.append(float(read(vector_under(known, packed.vector), "mass")))
            seconds.append(float(run.time_s[last] - run.time_s[first]))
    return float(np.average(masses, weights=seconds))


def estimate(name: str, slope: float, ends: FloatArray, mass: float, note: str) -> SlopeEstimate:
    """Turn a slope into a mass; the ends (2,) of the slope's interval become those of the mass.

    A slope whose interval holds zero bounds no mass: acceleration need not follow the thrust.
    """
    if slope == 0.0:
        raise CannotComputeError("acceleration does not follow the thrust at all: the slope is 0")
    total = 1.0 / float(slope)
    low, high = ends.tolist()
    ci95 = (1.0 / high - mass, 1.0 / low - mass) if low * high > 0.0 else None
    refused = ""
    if ci95 is not None and ci95[1] < 0.0:
        refused = (
            f"{total - mass:.1f} kg with an interval below zero is no added mass of any body: "
            "thrust, mass or the sign of a channel is wrong"
        )
    return SlopeEstimate(
        estimator=name,
        slope_per_kg=float(slope),
        total_mass_kg=total,
        added_mass_kg=total - mass,
        ci95_kg=None if refused else ci95,
        note=note,
        refused=refused,
    )


def _with_terms(  # noqa: PLR0917 - one caller
    thrust: FloatArray,
    acceleration: FloatArray,
    terms: dict[str, FloatArray],
    run: IntArray,
    lags: int,
    mass: float,
) -> tuple[SlopeEstimate | None, tuple[RegressionTerm, ...]]:
    """Regress on the thrust, a constant and every term that the runs excite, turns included."""
    if not thrust.size:
        return None, ()
    design = np.column_stack([thrust, np.ones_like(thrust), *terms.values()])
    try:
        found = least_squares(design, acceleration, run, lags)
    except CannotComputeError:
        return None, ()
    named = tuple(
        RegressionTerm(name=name, unit=UNITS.get(name, "1"), coefficient=value, ci95=(low, high))
        for name, value, (low, high) in zip(
            terms, found.coefficients[2:].tolist(), found.ci95[2:].tolist(), strict=True
        )
    )
    note = f"with {', '.join(terms)}; all samples, turns included"
    note = note if terms else "no term is excited"
    name, slope = "least squares with the omitted terms", found.coefficients[0]
    return estimate(name, slope, found.ci95[0], mass, note), named


def _warnings(plain: tuple[SlopeEstimate, ...], full: SlopeEstimate | None) -> tuple[str, ...]:
    found = []
    first, between = plain[0], plain[0].ci95_kg
    if first.refused:
        found.append(f"the plain slope is refused: {first.refused}")
    elif between is None:
        found.append(
            "the slope's interval holds zero, so it bounds no mass: acceleration does not follow "
            "the thrust in these stretches (in a steady run drag takes all of it)"
        )
    elif (between[1] - between[0]) / 2 > 0.3 * abs(first.total_mass_kg):
        found.append("the slope itself is known to no better than 30 %: the thrust hardly varies")
    if full is not None and (
        abs(full.total_mass_kg - first.total_mass_kg) > NOTABLE_SHIFT * abs(full.total_mass_kg)
        or _apart(full.ci95_kg, between)
    ):
        found.append(
            f"the omitted terms move the added mass from {first.added_mass_kg:.2f} to "
            f"{full.added_mass_kg:.2f} kg: the plain method's assumptions do not hold on these "
            "runs"
        )
    if first.added_mass_kg < 0 and not first.refused:
        found.append("a negative added mass: thrust, mass or the sign of a channel is wrong")
    return tuple(found)


def _apart(one: tuple[float, float] | None, other: tuple[float, float] | None) -> bool:
    """Whether two intervals have nothing in common."""
    return one is not None and other is not None and (one[0] > other[1] or one[1] < other[0])
