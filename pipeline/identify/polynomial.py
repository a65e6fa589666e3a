"""Polynomial fits of one variable with quality, intervals and the case for the order."""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.linear_fit import Judgement, LinearFit, fit_linear, judge
from pipeline.records.base import Source
from pipeline.records.fits import FitQuality, OrderScore, Outlier, PolynomialFit, ResidualPoint
from pipeline.types import FloatArray


def fit_polynomial(
    x: FloatArray,
    y: FloatArray,
    *,
    degree: int,
    quantity: str,
    variable: str,
    unit: str,
    degree_reason: str,
    sources: Sequence[Source | None] | None = None,
    compared_degrees: Sequence[int] = (1, 2, 3, 4),
) -> PolynomialFit:
    """Fit y = sum c_i x^i of a given degree and say how other degrees would have done.

    `x`, `y` (m,) are variable and measured quantity; `quantity`, `variable` and `unit` name them
    for the report. The evidence of the scores is appended to `degree_reason`; outliers are named by
    the row of each point in `sources`.

    Raises
    ------
    CannotComputeError
        If the points do not determine the polynomial.
    """
    try:
        fit = fit_linear(np.vander(x, degree + 1, increasing=True), y)
    except CannotComputeError as error:
        raise CannotComputeError(f"{quantity}({variable}): {error}") from None
    orders = _score_degrees(x, y, degree, compared_degrees)
    names = tuple(sources) if sources is not None else (None,) * len(x)
    return PolynomialFit(
        quantity=quantity,
        variable=variable,
        coefficients=fit.coefficients.tolist(),
        covariance=fit.covariance.tolist(),
        ci95=fit.ci95.tolist(),
        quality=FitQuality(
            points=int((~fit.outlier).sum()),
            outliers=name_outliers(fit, names, x, variable),
            r_squared=fit.r_squared,
            residual_std=fit.residual_std,
            unit=unit,
            valid_range=(float(x[~fit.outlier].min()), float(x[~fit.outlier].max())),
            orders=orders,
            order_reason=f"{degree_reason} {compare_orders(orders)}".strip(),
        ),
        points=tuple(
            ResidualPoint(
                x=float(x[i]),
                measured=float(y[i]),
                fitted=float(fit.fitted[i]),
                outlier=bool(fit.outlier[i]),
                source=names[i],
            )
            for i in np.argsort(x, kind="stable").tolist()
        ),
    )


def name_outliers(
    fit: LinearFit, sources: Sequence[Source | None], x: FloatArray, variable: str
) -> tuple[Outlier, ...]:
    """List the points that the fit left out, worst first, each with its row."""
    worst_first: list[int] = sorted(
        np.flatnonzero(fit.outlier).tolist(), key=lambda index: -abs(fit.robust_sigmas[index])
    )
    return tuple(
        Outlier(
            source=sources[index],
            label=f"{variable} = {x[index]:.4g}",
            residual=float(fit.residuals[index]),
            robust_sigmas=float(fit.robust_sigmas[index]),
        )
        for index in worst_first
    )


def compare_orders(orders: Sequence[OrderScore]) -> str:
    """Say in one sentence how the chosen order stands against the best of the compared ones."""
    chosen = next((score for score in orders if score.chosen), None)
    if chosen is None or len(orders) < 2:
        return ""
    best = min(orders, key=lambda score: score.aicc)
    best_out = min(orders, key=lambda score: score.leave_one_out_rmse)
    ratio = chosen.leave_one_out_rmse / max(best_out.leave_one_out_rmse, np.finfo(float).tiny)
    if best.chosen:
        return (
            f"AICc prefers it too; its leave-one-out error is {ratio:.2f} times the smallest "
            f"({best_out.order})."
        )
    return (
        f"AICc would prefer {best.order} (by {chosen.aicc - best.aicc:.1f}); the leave-one-out "
        f"error of the chosen order is {ratio:.2f} times the smallest ({best_out.order})."
    )


def _score_degrees(
    x: FloatArray, y: FloatArray, chosen: int, degrees: Sequence[int]
) -> tuple[OrderScore, ...]:
    """Score the degrees over the same points, else a degree would gain by what it calls outliers.

    A point is left out where every degree finds it too far off: what a stiffer one misses may be a
    bend.
    """
    # of like size: high powers of 1e6 N would drown the constant
    scaled = x / max(float(np.max(np.abs(x))), np.finfo(float).tiny)
    designs = {
        degree: np.vander(scaled, degree + 1, increasing=True)
        for degree in sorted({*degrees, chosen})
        if min(x.size - 2, np.unique(x).size) > degree
    }
    by_degree = [judge(design, y) for design in designs.values()]
    judged = Judgement(
        np.min([np.abs(one.sigmas) for one in by_degree], axis=0),
        np.all([one.outlier for one in by_degree], axis=0),
    )
    scores = []
    for degree, design in designs.items():
        try:
            fit = fit_linear(design, y, judged=judged)
        except CannotComputeError:
            continue
        if not np.isfinite(fit.aicc):
            continue
        scores.append(
            OrderScore(
                order=f"degree {degree}",
                parameters=degree + 1,
                aicc=fit.aicc,
                leave_one_out_rmse=fit.leave_one_out_rmse,
                chosen=degree == chosen,
            )
        )
    return tuple(scores)
