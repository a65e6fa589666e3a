"""Robust linear least squares: the one regression under every polynomial fit of the bench.

Outliers are found by an M-estimate (Tukey's biweight, scale by the median absolute deviation) and
confirmed by Student's t, named, and left out of the ordinary least squares that gives coefficients
and covariance.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.types import BoolArray, FloatArray, IntArray

#: A point this many robust standard deviations off does not belong. At 4.5, a Gaussian sample of
#: 1000 points is expected to lose 0.007 of one where its scale is known.
OUTLIER_SIGMAS = 4.5
#: With fewer degrees of freedom the M-estimate's scale is not known well enough to be believed
#: alone: at 40 it loses one good point in a thousand, at 6 twenty and more.
ENOUGH_DEGREES = 40
#: Where the other clusters hold less than this share of the information on some combination of
#: coefficients, it rests on one cluster alone, and its scatter between clusters is not known.
SMALLEST_SHARE = 1e-9


@dataclass(frozen=True)
class Judgement:
    """Distance of each point in robust standard deviations, and whether it does not belong."""

    sigmas: FloatArray
    outlier: BoolArray


@dataclass(frozen=True)
class LinearFit:
    """A least-squares fit y = X c.

    `fitted`, `residuals`, `robust_sigmas`, `outlier` have the length of y and cover the outliers
    too; the scores (`residual_std`, `r_squared`, `aicc`, `leave_one_out_rmse`) and the covariance
    are of the points that were fitted. `degrees_of_freedom` belongs to the t quantile of the
    intervals: points less parameters, or clusters less one.
    """

    coefficients: FloatArray
    covariance: FloatArray
    ci95: FloatArray
    fitted: FloatArray
    residuals: FloatArray
    robust_sigmas: FloatArray
    outlier: BoolArray
    residual_std: float
    r_squared: float
    aicc: float
    leave_one_out_rmse: float
    degrees_of_freedom: int
    clustered: bool
    """Whether the covariance is that of whole clusters; False without, or with too few of them."""


def fit_linear(
    design: FloatArray,
    response: FloatArray,
    *,
    clusters: IntArray | None = None,
    judged: Judgement | None = None,
) -> LinearFit:
    r"""Fit ``response`` (m,) by ``design @ c``, the constant among the regressors (m, k).

    `clusters` (m,) label groups whose errors go together (a sweep of the bench): the covariance is
    then `jackknife_covariance`, if there are more groups than regressors. `judged` is given where
    the caller has a better judge of outliers than this model; `judge` of this design otherwise.

    Raises
    ------
    CannotComputeError
        With fewer points than parameters plus two, or regressors that depend on each other.

    Notes
    -----
    Leave-one-out error from the hat matrix h: e_i / (1 - h_ii) (PRESS; Allen 1974).
    AICc = m ln(SSE / m) + 2 p + 2 p (p + 1) / (m - p - 1), p = k + 1 (Hurvich and Tsai 1989).
    """
    from scipy import stats
    from statsmodels.regression.linear_model import OLS

    count, width = design.shape
    if count < width + 2:
        raise CannotComputeError(
            f"{count} points cannot carry {width} coefficients; at least {width + 2} are needed"
        )
    # columns of like size: loads of 1e6 N and their squares would pass for dependent
    scale = np.max(np.abs(design), axis=0)
    design = design / np.where(scale > 0, scale, 1.0)
    if np.linalg.matrix_rank(design) < width:
        raise CannotComputeError(
            f"the {count} points do not determine {width} coefficients: the values of the "
            "variable are too few or all alike"
        )
    if judged is None:
        judged = judge(design, response)
    keep = ~judged.outlier
    if not _determined(design[keep]):
        keep = np.ones(count, bool)
    plain = OLS(response[keep], design[keep]).fit()
    degrees = int(keep.sum()) - width
    covariance = np.asarray(plain.cov_params())
    clustered = False
    if clusters is not None:
        labels = clusters[keep]
        groups = np.unique(labels).size
        if groups > width:
            jackknife = jackknife_covariance(design[keep], np.asarray(plain.resid), labels)
            if jackknife is not None:
                covariance, degrees, clustered = jackknife, groups - 1, True
    coefficients = np.asarray(plain.params, float)
    half = stats.t.ppf(0.975, degrees) * np.sqrt(np.diag(covariance))
    fitted = design @ coefficients
    residuals = response - fitted
    coefficients, covariance = coefficients / scale, covariance / np.outer(scale, scale)
    half = half / scale
    left_out = np.asarray(plain.get_influence().resid_press)
    return LinearFit(
        coefficients=coefficients,
        covariance=covariance,
        ci95=np.stack([coefficients - half, coefficients + half], axis=1),
        fitted=fitted,
        residuals=residuals,
        robust_sigmas=judged.sigmas,
        outlier=~keep,
        residual_std=float(np.sqrt(plain.mse_resid)),
        r_squared=_r_squared(response[keep], residuals[keep]),
        aicc=_aicc(residuals[keep], width),
        leave_one_out_rmse=float(np.sqrt(np.mean(left_out**2))),
        degrees_of_freedom=degrees,
        clustered=clustered,
    )


def jackknife_covariance(
    design: FloatArray, residuals: FloatArray, clusters: IntArray
) -> FloatArray | None:
    r"""Covariance of least-squares coefficients from leaving out one cluster at a time (CR3).

    With few clusters their residuals are too small, because the fit follows them: most of all at
    the ends of the variables. What the fit without a cluster misses it by is not. `design` (m, k),
    `residuals` (m,) are of ordinary least squares, `clusters` (m,) labels. None where some
    combination of coefficients rests on one cluster alone; its quantile is Student's t for the
    number of clusters less one.

    Notes
    -----
    :math:`\frac{G - 1}{G} \sum_g d_g d_g'` with
    :math:`d_g = (X'X)^{-1} X_g' (I - X_g (X'X)^{-1} X_g')^{-1} e_g`, the change of the coefficients
    when cluster g is left out.

    References
    ----------
    Bell and McCaffrey 2002, Survey Methodology 28(2), 169-181. Cameron and Miller 2015, Journal of
    Human Resources 50(2), 317-372.
    """
    orthonormal, triangle = np.linalg.qr(design)
    labels = np.unique(clusters)
    changes = np.empty((design.shape[1], labels.size))
    for column, label in enumerate(labels):
        own = orthonormal[clusters == label]
        others = np.eye(design.shape[1]) - own.T @ own
        if np.linalg.eigvalsh(others)[0] < SMALLEST_SHARE:
            return None
        # Q_g' (I - Q_g Q_g')^-1 = (I - Q_g' Q_g)^-1 Q_g': k equations, however many points
        changes[:, column] = np.linalg.solve(others, own.T @ residuals[clusters == label])
    changes = np.linalg.solve(triangle, changes)
    return np.asarray((labels.size - 1) / labels.size * changes @ changes.T)


def _r_squared(response: FloatArray, residuals: FloatArray) -> float:
    """Return 1 - SSE / SST; of a response that does not vary, 1: nothing is left unexplained."""
    about_mean = response - response.mean()
    total = float(about_mean @ about_mean)
    if total <= (1e-12 * float(np.max(np.abs(response), initial=0.0))) ** 2 * response.size:
        return 1.0
    return 1.0 - float(residuals @ residuals) / total


def _aicc(residuals: FloatArray, width: int) -> float:
    count, parameters = residuals.size, width + 1
    if count - parameters - 1 <= 0:
        return np.inf
    square_sum = max(float(residuals @ residuals), np.finfo(float).tiny)
    penalty = 2 * parameters + 2 * parameters * (parameters + 1) / (count - parameters - 1)
    return float(count * np.log(square_sum / count) + penalty)


def judge(design: FloatArray, response: FloatArray) -> Judgement:
    """Find the points that do not belong; parameters as in `fit_linear`.

    An M-estimate passes all but exactly through some of few points, and its scale is then that of
    their chance agreement: of eight points of a cubic it would call a good one an outlier every
    fifth time. So what it finds too far off is predicted by ordinary least squares through the
    others, whose few degrees of freedom count by Student's t, at the probability that a Gaussian
    point has to be beyond `OUTLIER_SIGMAS`.
    """
    from scipy import stats

    sigmas = _robust_sigmas(design, response)
    suspect = np.abs(sigmas) > OUTLIER_SIGMAS
    others = design[~suspect]
    degrees = len(others) - design.shape[1]
    if not suspect.any() or degrees >= ENOUGH_DEGREES:
        return Judgement(sigmas, suspect)
    if not _determined(others):
        return Judgement(sigmas, np.zeros(suspect.shape, bool))
    coefficients = np.linalg.lstsq(others, response[~suspect], rcond=None)[0]
    residuals = response - design @ coefficients
    std = float(np.sqrt(np.sum(residuals[~suspect] ** 2) / degrees))
    _, triangle = np.linalg.qr(others)
    spread = np.sum(np.linalg.solve(triangle.T, design[suspect].T) ** 2, axis=0)
    # others that agree exactly leave the floor of rounding
    error = np.maximum(std, _floor(response)) * np.sqrt(1.0 + spread)
    outlier = suspect.copy()
    limit = stats.t.isf(stats.norm.sf(OUTLIER_SIGMAS), degrees)
    outlier[suspect] = np.abs(residuals[suspect]) > limit * error
    return Judgement(sigmas, outlier)


def _determined(design: FloatArray) -> bool:
    """Whether points carry the coefficients with two to spare."""
    count, width = design.shape
    return count >= width + 2 and bool(np.linalg.matrix_rank(design) == width)


def _floor(response: FloatArray) -> float:
    """Return what rounding leaves of a fit that is exact."""
    return 1e-9 * float(np.max(np.abs(response), initial=0.0))


def _robust_sigmas(design: FloatArray, response: FloatArray) -> FloatArray:
    """Residuals of the M-estimate in robust standard deviations, shape (m,).

    Zero throughout where the model fits exactly.
    """
    from statsmodels.robust import norms
    from statsmodels.robust.robust_linear_model import RLM

    floor = _floor(response)
    plain = response - design @ np.linalg.lstsq(design, response, rcond=None)[0]
    if np.max(np.abs(plain)) <= floor:
        return np.zeros_like(response)  # an exact fit has no scale to judge by
    robust = RLM(response, design, M=norms.TukeyBiweight()).fit()
    residuals = response - design @ np.asarray(robust.params)
    scale = max(float(robust.scale), floor)
    return np.asarray(residuals / scale)
