import numpy as np
import pytest

from pipeline.physics.thrust_grid import dead_zone_code

TABLE_2 = np.array(
    [
        [-4.0, 0.254, 8.82e-4],
        [-5.0, 0.215, 10.2e-4],
        [-8.0, 0.211, 9.65e-4],
        [-11.0, 0.210, 9.07e-4],
        [-15.0, 0.208, 8.67e-4],
    ]
)


@pytest.mark.parametrize("row", range(5))
def test_dead_zone_ends_at_the_root(row: int) -> None:
    """Not at |N| = K_F0, which is a negative thrust."""
    edge = dead_zone_code(TABLE_2[row])
    k0, k1, k2 = TABLE_2[row]
    assert k0 + k1 * edge + k2 * edge**2 == pytest.approx(0.0, abs=1e-12)
    assert edge > abs(k0)


@pytest.mark.parametrize(
    ("coefficients", "edge"),
    [
        ((1.0, 0.2, 0.0), 0.0),
        ((0.0, 0.2, 0.0), 0.0),
        ((-2.0, 0.2, 0.0), 10.0),
        ((-2.0, -0.2, 0.0), np.inf),
        ((-2.0, 0.0, 0.02), 10.0),
        ((-2.0, 0.3, -0.01), 10.0),  # concave: rises through zero at 10, falls again at 20
        ((-3.0, 0.3, -0.01), np.inf),
        ((-2.0, -0.3, -0.01), np.inf),
    ],
)
def test_dead_zone_of_other_shapes(coefficients: tuple[float, ...], edge: float) -> None:
    assert dead_zone_code(coefficients) == pytest.approx(edge)
