"""Marginal likelihoods against the multivariate normal density written out."""

import numpy as np
import pytest
from scipy import stats

from pipeline.diagnose.judging.hypotheses import log_evidence_of, with_ordinary
from pipeline.diagnose.linear.elimination import ForcePrior, Grams, Marginal, marginal, solve
from pipeline.diagnose.linear.evidence import Prior, fit, log_inside, posterior, promise
from pipeline.types import FloatArray

Linear = tuple[Grams, FloatArray, FloatArray, ForcePrior]
WINDOWS, ROWS, PIECES, SHARED, DEPARTURES = 3, 40, 2, 2, 4
RUN = np.array([0, 0, 1])
#: What the departures of a run differ by: some of them do not.
SCATTER = np.array([0.3, 0.0, 0.7, 0.0])


@pytest.fixture(scope="module", params=["one vehicle", "from run to run"])
def linear(request: pytest.FixtureRequest) -> Linear:
    """Random normal equations, with the dense columns and the dense covariance of the rest.

    Of the shared unknowns each run has one, and one is common to both.
    """
    generator = np.random.default_rng(5)
    own = 12 + 6 * PIECES
    forces = ForcePrior(np.eye(6 * PIECES) / 0.49, 6 * PIECES * np.log(0.49))
    shared_precision = np.diag([1.0, 2.0, 4.0])
    own_columns = generator.normal(size=(WINDOWS, ROWS, own))
    shared_columns = generator.normal(size=(WINDOWS, ROWS, SHARED))
    departures = generator.normal(size=(WINDOWS, ROWS, DEPARTURES))
    readings = generator.normal(size=(WINDOWS, ROWS, 1)) * 3.0
    rest = np.concatenate([shared_columns, departures, readings], axis=2)
    scatter = SCATTER if request.param == "from run to run" else np.zeros(DEPARTURES)
    index = np.column_stack([RUN, np.full(WINDOWS, 2)])
    grams = Grams(
        np.einsum("wka,wkb->wab", own_columns, own_columns),
        np.einsum("wka,wkb->wab", own_columns, rest),
        np.einsum("wka,wkb->wab", rest, rest),
        index,
        shared_precision,
        RUN,
        np.array([0, 1, -1]),
        scatter,
    )
    size = WINDOWS * ROWS
    covariance = np.eye(size)
    spread = np.diag(np.concatenate([np.ones(12), np.full(6 * PIECES, 0.49)]))
    for number, columns in enumerate(own_columns):
        rows = slice(number * ROWS, (number + 1) * ROWS)
        covariance[rows, rows] += columns @ spread @ columns.T
    flat = np.zeros((size, len(shared_precision)))
    for number, columns in enumerate(shared_columns):
        flat[number * ROWS : (number + 1) * ROWS, index[number]] = columns
    covariance += flat @ np.linalg.inv(shared_precision) @ flat.T
    of_row = np.repeat(RUN, ROWS)
    wide = departures.reshape(size, DEPARTURES) * scatter
    covariance += np.where(of_row[:, None] == of_row, wide @ wide.T, 0.0)
    columns = np.concatenate(
        [departures.reshape(size, DEPARTURES), readings.reshape(size, 1)], axis=1
    )
    return grams, columns, covariance, forces


def test_schur_complements_are_the_dense_marginal(linear: Linear) -> None:
    grams, columns, covariance, forces = linear
    found = marginal(grams, forces)
    solved = np.linalg.solve(covariance, columns)
    g, y = columns[:, :-1], columns[:, -1]
    np.testing.assert_allclose(found.information, g.T @ solved[:, :-1], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.score, g.T @ solved[:, -1], rtol=1e-9, atol=1e-9)
    assert found.misfit == pytest.approx(y @ solved[:, -1], rel=1e-9)
    assert found.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-9)


def test_log_evidence_is_that_of_the_density(linear: Linear) -> None:
    grams, columns, covariance, forces = linear
    prior = Prior(np.array([0.3, 0.0, -0.2, 0.0]), np.diag([0.5, 0.0, 1.5, 0.1]))
    g, y = columns[:, :-1], columns[:, -1]
    whole = covariance + g @ prior.covariance @ g.T
    expected = stats.multivariate_normal(g @ prior.mean, whole).logpdf(y)
    constant = -0.5 * y.size * np.log(2 * np.pi)
    found = marginal(grams, forces)
    assert fit(found, prior).log_evidence + constant == pytest.approx(expected, rel=1e-9)
    ground = with_ordinary(found, prior)
    assert log_evidence_of(ground) + constant == pytest.approx(expected, rel=1e-9)


def test_posterior_is_that_of_normal_equations(linear: Linear) -> None:
    grams, _, _, forces = linear
    found = marginal(grams, forces)
    prior = Prior(np.full(4, 0.1), np.diag([0.5, 0.2, 1.5, 0.1]))
    precision = found.information + np.linalg.inv(prior.covariance)
    mean = np.linalg.solve(precision, found.score + np.linalg.solve(prior.covariance, prior.mean))
    left = posterior(found, prior)
    np.testing.assert_allclose(left.mean, mean, rtol=1e-8)
    np.testing.assert_allclose(left.covariance, np.linalg.inv(precision), rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(fit(found, prior).mean, mean, rtol=1e-8)


def test_own_and_shared_unknowns_solve_the_joint_equations(linear: Linear) -> None:
    grams, _, _, forces = linear
    departures = np.array([0.2, -0.1, 0.0, 0.4])
    best = solve(grams, forces, departures)
    # gradient of the cost by each window's own unknowns is zero
    for number in range(WINDOWS):
        own = np.concatenate([best.starts[number], best.forces[number]])
        rest = np.concatenate([best.shared[grams.index[number]], departures])
        pull = grams.cross[number, :, -1] - grams.cross[number, :, :-1] @ rest
        pull -= grams.own[number] @ own
        pull[:12] -= best.starts[number]
        pull[12:] -= forces.precision @ best.forces[number]
        np.testing.assert_allclose(pull, 0.0, atol=1e-8)


@pytest.mark.parametrize(
    ("mean", "std", "low", "high"),
    [(0.0, 1.0, -1.0, 2.0), (5.0, 0.5, 0.0, np.inf), (-3.0, 1.0, 0.0, 4.0), (9.0, 1.0, -1.0, 1.0)],
)
def test_log_inside_is_the_normal_probability(
    mean: float, std: float, low: float, high: float
) -> None:
    # on the side of the mean where differences are accurate
    side = stats.norm.sf if low > mean else lambda x, m, s: -stats.norm.cdf(x, m, s)
    expected = np.log(side(low, mean, std) - side(high, mean, std))
    assert log_inside(mean, std, low, high) == pytest.approx(expected, rel=1e-6)


def test_a_flat_likelihood_leaves_the_prior() -> None:
    found = Marginal(np.zeros((2, 2)), np.zeros(2), 7.0, 3.0)
    prior = Prior(np.array([1.0, 2.0]), np.diag([0.5, 0.25]))
    left = fit(found, prior)
    assert left.log_evidence == pytest.approx(-5.0)
    np.testing.assert_allclose(left.mean, prior.mean)
    np.testing.assert_allclose(left.std, np.sqrt([0.5, 0.25]))


def test_a_way_to_the_most_probable_departures_promises_what_it_gains(linear: Linear) -> None:
    """Against the joint log density of readings and departures at both ends."""
    found = marginal(linear[0], linear[3])
    root = np.diag([0.5, 1.0, 0.0, 2.0]) + np.diag([0.3, 0.0, 0.0], -1)
    prior = Prior(np.array([0.1, -0.2, 0.7, 0.0]), root @ root.T)
    best, active = fit(found, prior).mean, [0, 1, 3]

    def density(at: FloatArray) -> float:
        off = (at - prior.mean)[active]
        believed = np.linalg.inv(prior.covariance[np.ix_(active, active)])
        return float(found.score @ at - at @ found.information @ at / 2 - off @ believed @ off / 2)

    begin = best - np.array([0.3, -0.1, 0.0, 0.2])
    assert promise(found, prior, best - begin) == pytest.approx(density(best) - density(begin))
