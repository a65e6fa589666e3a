import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.physics.propeller import advance_ratio, efficiency, polynomial, thrust, torque

K_T = np.array([0.139, -0.155, -0.061])
K_M = np.array([0.0171, -0.0164, -0.0055])
WATER = {"diameter_m": 0.14, "density_kgpm3": 1000.62}

# N = 127: the drive's speed and torque that belong to Table 2 of Kostenko 2023, by inversion of
# Tables 1 and 2; thrust is Table 2 itself
CODE_127 = [
    (0.0, 1692.0, 0.732, 42.48),
    (0.5, 1746.0, 0.684, 38.76),
    (1.0, 1805.0, 0.628, 34.36),
    (1.5, 1892.0, 0.583, 30.30),
    (2.0, 1982.0, 0.527, 25.40),
]


@pytest.mark.parametrize(("speed", "rpm", "torque_nm", "thrust_n"), CODE_127)
def test_tables_1_and_2_meet_on_the_drive(
    speed: float, rpm: float, torque_nm: float, thrust_n: float
) -> None:
    assert float(thrust(rpm / 60, speed, coefficients=K_T, **WATER)) == pytest.approx(
        thrust_n, abs=0.06
    )
    assert float(torque(rpm / 60, speed, coefficients=K_M, **WATER)) == pytest.approx(
        torque_nm, abs=0.001
    )


def test_factors_by_hand() -> None:
    """J = 0.5 at 1 m/s, 10 rev/s, 0.2 m; T = 0.05 * 1000 * 100 * 0.0016 = 8 N."""
    assert float(advance_ratio(1.0, 10.0, 0.2)) == 0.5
    size = {"diameter_m": 0.2, "density_kgpm3": 1000.0}
    assert float(thrust(10.0, 1.0, coefficients=[0.1, -0.1], **size)) == pytest.approx(8.0)
    assert float(torque(10.0, 1.0, coefficients=[0.01, -0.01], **size)) == pytest.approx(0.16)


@given(n=st.floats(1.0, 50.0), j=st.floats(0.0, 0.7), scale=st.floats(0.5, 2.0))
def test_similarity(n: float, j: float, scale: float) -> None:
    """At equal J, thrust grows with n^2 D^4 and torque with n^2 D^5."""
    size = {"diameter_m": 0.14 * scale, "density_kgpm3": 1000.62}
    speed = j * n * 0.14
    at_scale = {"shaft_speed_rps": n / scale, "speed_mps": speed, **size}
    assert float(thrust(coefficients=K_T, **at_scale)) == pytest.approx(
        float(thrust(n, speed, coefficients=K_T, **WATER)) * scale**2, abs=1e-9
    )
    assert float(torque(coefficients=K_M, **at_scale)) == pytest.approx(
        float(torque(n, speed, coefficients=K_M, **WATER)) * scale**3, abs=1e-9
    )


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=5))
def test_polynomial_is_the_sum_of_powers(j: list[float]) -> None:
    values = np.array(j)
    expected = K_T[0] + K_T[1] * values + K_T[2] * values**2
    np.testing.assert_allclose(polynomial(values, K_T), expected, atol=1e-15)


@given(n=st.floats(5.0, 50.0))
def test_thrust_and_torque_fall_with_speed(n: float) -> None:
    speed = np.linspace(0.0, 0.7 * n * 0.14, 30)
    for of, k in ((thrust, K_T), (torque, K_M)):
        assert (np.diff(of(n, speed, coefficients=k, **WATER)) < 0).all()


@given(n=st.floats(5.0, 50.0), j=st.floats(0.01, 0.69))
def test_efficiency_is_power_out_over_power_in(n: float, j: float) -> None:
    speed = j * n * 0.14
    out = float(thrust(n, speed, coefficients=K_T, **WATER)) * speed
    put_in = float(torque(n, speed, coefficients=K_M, **WATER)) * 2 * np.pi * n
    ratio = float(efficiency(j, polynomial(j, K_T), polynomial(j, K_M)))
    assert ratio == pytest.approx(out / put_in)
    assert 0 < ratio < 1
