"""The cross product as a matrix, from both sides."""

import numpy as np

from pipeline.physics.carried_body import cross_matrix


def test_it_is_the_cross_product_from_either_side() -> None:
    rng = np.random.default_rng(1)
    place, rates = rng.standard_normal(3), rng.standard_normal((5, 3))
    np.testing.assert_allclose(rates @ cross_matrix(place), np.cross(rates, place), atol=1e-15)
    np.testing.assert_allclose(rates @ cross_matrix(place).T, np.cross(place, rates), atol=1e-15)
